//! The folder of truths: each is rendered once and kept under a hash of everything that determines it, within a limit.
//!
//! Using a truth sets the time of its sheet (times of reading are not kept on many systems). When the folder holds more
//! than its limit, those used longest ago are removed; the one just written stays, even where it alone is over the
//! limit. Any number of processes may share the folder. One that reads a truth while another removes it finds a whole
//! one or none, because a truth counts only with its sheet, which is written last and removed first. Files of other
//! names are left alone.

mod entry;
mod limit;

use super::TruthCost;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::provenance::truth_sources;
use crate::scene::ImageSize;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Names the folder, unless it is empty.
pub const FOLDER_VARIABLE: &str = "OCCLAB_CACHE";
/// Names the limit, unless it is empty.
pub const LIMIT_VARIABLE: &str = "OCCLAB_CACHE_LIMIT";
/// Most bytes of truths where no limit is given.
pub const DEFAULT_LIMIT_BYTES: u64 = 4 << 30;
/// After this time a truth that has a picture and no sheet counts as abandoned by its writer.
const ABANDONED: Duration = Duration::from_secs(3600);

/// A folder of truths.
#[derive(Clone, Debug)]
pub struct TruthCache {
    folder: PathBuf,
    limit_bytes: u64,
}

/// What a folder of truths holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Usage {
    /// Truths.
    pub entries: usize,
    /// Bytes of all files, those that are being written included.
    pub bytes: u64,
    /// Last use of the truth that was used longest ago.
    pub oldest_use: Option<SystemTime>,
    /// Latest use of any truth.
    pub last_use: Option<SystemTime>,
}

/// What was removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Removed {
    /// Truths.
    pub entries: usize,
    /// Bytes of all files.
    pub bytes: u64,
}

/// The files of one truth.
struct Item {
    id: String,
    /// In the order in which they are removed.
    files: Vec<PathBuf>,
    bytes: u64,
    used: SystemTime,
    /// The sheet is there; otherwise the truth is being written, or its writer ended early.
    whole: bool,
}

impl TruthCache {
    /// The truths in `folder`, which need not exist; from `limit_bytes` on the oldest are removed.
    pub fn new(folder: impl Into<PathBuf>, limit_bytes: u64) -> Self {
        Self {
            folder: folder.into(),
            limit_bytes,
        }
    }

    /// The folder and the limit that the environment names, or `truth` in the user's cache folder and
    /// [`DEFAULT_LIMIT_BYTES`]; `None` for a user without such a folder.
    pub fn from_environment() -> Result<Option<Self>> {
        let variable = |name| std::env::var_os(name).filter(|value| !value.is_empty());
        let limit_bytes = match variable(LIMIT_VARIABLE) {
            Some(text) => limit::parse(&text.to_string_lossy())?,
            None => DEFAULT_LIMIT_BYTES,
        };
        let own = || {
            let folders = directories::ProjectDirs::from("", "", "occlab")?;
            Some(folders.cache_dir().join("truth"))
        };
        let folder = variable(FOLDER_VARIABLE).map(PathBuf::from).or_else(own);
        Ok(folder.map(|folder| Self::new(folder, limit_bytes)))
    }

    /// Where the truths are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Most bytes that stay; `u64::MAX` where there is no limit.
    pub fn limit_bytes(&self) -> u64 {
        self.limit_bytes
    }

    /// What the folder holds now.
    pub fn usage(&self) -> Result<Usage> {
        let items = self.items()?;
        let used = || items.iter().filter(|item| item.whole).map(|item| item.used);
        Ok(Usage {
            entries: used().count(),
            bytes: items.iter().map(|item| item.bytes).sum(),
            oldest_use: used().min(),
            last_use: used().max(),
        })
    }

    /// Removes every truth, but not one that is being written.
    pub fn clear(&self) -> Result<Removed> {
        let mut removed = Removed::default();
        for item in self.items()?.iter().filter(|item| item.is_settled()) {
            item.remove()?;
            removed.entries += usize::from(item.whole);
            removed.bytes += item.bytes;
        }
        Ok(removed)
    }

    /// The truth named `id`, if a whole one is there, and records that it was used.
    pub(super) fn get(&self, id: &str, image: ImageSize) -> Result<Option<(Frame, TruthCost)>> {
        let found = entry::read(&self.folder, id, image)?;
        if found.is_some() {
            let sheet = File::options()
                .write(true)
                .open(entry::sheet(&self.folder, id));
            // Fails for a user who may read the folder but not write to it, who still gets its truths.
            let _ = sheet.and_then(|sheet| sheet.set_modified(SystemTime::now()));
        }
        Ok(found)
    }

    /// Keeps a truth.
    pub(super) fn put(&self, id: &str, frame: &Frame, cost: &TruthCost) -> Result<()> {
        entry::write(&self.folder, id, frame, cost)
    }

    /// Removes what was used longest ago until the limit is kept, but never the truth named `keep`.
    pub(super) fn trim(&self, keep: &str) -> Result<()> {
        let mut items = self.items()?;
        let mut bytes: u64 = items.iter().map(|item| item.bytes).sum();
        items.sort_by_key(|item| item.used);
        let mut outcome = Ok(());
        for item in items
            .iter()
            .filter(|item| item.id != keep && item.is_settled())
        {
            if bytes <= self.limit_bytes {
                return Ok(());
            }
            match item.remove() {
                Ok(()) => bytes -= item.bytes,
                // A file of another user in a shared folder; removing others may suffice.
                Err(problem) => outcome = Err(problem),
            }
        }
        outcome
    }

    /// Every truth in the folder, whole or not; none where there is no folder.
    fn items(&self) -> Result<Vec<Item>> {
        let entries = match fs::read_dir(&self.folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            other => other.map_err(Error::reading(&self.folder))?,
        };
        let mut items = BTreeMap::new();
        for found in entries {
            let found = found.map_err(Error::reading(&self.folder))?;
            let name = found.file_name();
            let Some((id, part)) = name.to_str().and_then(entry::part_of) else {
                continue;
            };
            // Another process may have removed it since.
            let Ok(metadata) = found.metadata() else {
                continue;
            };
            let Ok(modified) = metadata.modified() else {
                continue;
            };
            if metadata.is_file() {
                let item = items
                    .entry(id.to_owned())
                    .or_insert_with(|| Item::new(id, modified));
                item.add(part, found.path(), metadata.len(), modified);
            }
        }
        Ok(items.into_values().collect())
    }
}

impl Item {
    fn new(id: &str, used: SystemTime) -> Self {
        Self {
            id: id.to_owned(),
            files: Vec::new(),
            bytes: 0,
            used,
            whole: false,
        }
    }

    fn add(&mut self, part: entry::TruthFile, path: PathBuf, bytes: u64, modified: SystemTime) {
        self.bytes += bytes;
        match part {
            entry::TruthFile::Sheet => {
                self.files.insert(0, path);
                (self.used, self.whole) = (modified, true);
            }
            entry::TruthFile::Picture | entry::TruthFile::Unfinished => self.files.push(path),
        }
    }

    /// Whether no process is writing it. A time in the future counts as now.
    fn is_settled(&self) -> bool {
        self.whole || self.used.elapsed().is_ok_and(|age| age > ABANDONED)
    }

    fn remove(&self) -> Result<()> {
        for path in &self.files {
            match fs::remove_file(path) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(Error::Io {
                        path: path.clone(),
                        action: "remove",
                        source: error,
                        remedy: "Check who may write to the folder, or name another one with OCCLAB_CACHE.",
                    });
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The name of a truth: a hash of what determines it, which is `view` and the sources of this program.
pub(super) fn truth_id(view: serde_json::Value) -> String {
    hashed(&view, truth_sources())
}

/// 16 hexadecimal digits.
fn hashed(view: &serde_json::Value, sources: &str) -> String {
    let all = serde_json::json!({ "view": view, "sources": sources });
    blake3::hash(all.to_string().as_bytes()).to_hex()[..16].to_owned()
}

#[cfg(test)]
mod tests;
