//! A report folder while it is being filled: one file per cell, each written whole; a killed run leaves no partial
//! file.

use super::clock::ClockRecord;
use super::record::{Cell, Reference, WallClock};
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::frame::atomic::write_atomic;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Experiment, environment and inputs that a folder belongs to.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct FolderState {
    pub experiment: Value,
    pub environment: Environment,
    /// Hash of the sources that decide the numbers; empty in folders of earlier versions.
    #[serde(default)]
    pub sources: String,
    /// Hashes of the files that the scenes read, as the last run found them.
    #[serde(default)]
    pub inputs: BTreeMap<String, String>,
    pub wall: WallClock,
}

pub(super) struct Store {
    folder: PathBuf,
    state: FolderState,
}

const STATE: &str = "batch.json";

impl Store {
    /// Opens a folder for the records of a run, or creates it; also returns notes for the user. A folder with records
    /// of anything else is refused.
    pub fn open(folder: &Path, wanted: FolderState) -> Result<(Self, Vec<String>)> {
        for sub in ["cells", "references", "clock", "images"] {
            let path = folder.join(sub);
            std::fs::create_dir_all(&path).map_err(Error::writing(&path))?;
        }
        let path = folder.join(STATE);
        let mut notes = Vec::new();
        let state = match path.exists() {
            false => wanted,
            true => {
                let found: FolderState = read(&path)?;
                refuse_other(folder, &found, &wanted)?;
                notes = differences(&found, &wanted);
                FolderState {
                    inputs: wanted.inputs,
                    ..found
                }
            }
        };
        let store = Self {
            folder: folder.to_owned(),
            state,
        };
        store.write(STATE, &store.state)?;
        Ok((store, notes))
    }

    pub fn state(&self) -> &FolderState {
        &self.state
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// A path below the folder.
    pub fn path(&self, relative: &str) -> PathBuf {
        self.folder.join(relative)
    }

    pub fn has(&self, id: &str) -> bool {
        self.path(&format!("cells/{id}.json")).exists()
    }

    /// The cell recorded under `id`; its own id must be the same.
    pub fn cell(&self, id: &str) -> Result<Cell> {
        let path = self.path(&format!("cells/{id}.json"));
        let cell: Cell = read(&path)?;
        if cell.id != id {
            return Err(Error::input(
                path.display().to_string(),
                format!("it holds the cell `{}`", cell.id),
                "Remove this file; the next run makes it again.",
            ));
        }
        Ok(cell)
    }

    pub fn put_cell(&self, cell: &Cell) -> Result<()> {
        self.write(&format!("cells/{}.json", cell.id), cell)
    }

    /// The truth of a view; `None` when the view failed before it.
    pub fn reference(&self, view_id: &str) -> Result<Option<Reference>> {
        let path = self.path(&format!("references/{view_id}.json"));
        if path.exists() {
            read(&path).map(Some)
        } else {
            Ok(None)
        }
    }

    pub fn put_reference(&self, view_id: &str, reference: &Reference) -> Result<()> {
        self.write(&format!("references/{view_id}.json"), reference)
    }

    pub fn put_clock(&self, record: &ClockRecord) -> Result<()> {
        let ClockRecord {
            reference, block, ..
        } = record;
        self.write(&format!("clock/{reference}-{block}.json"), record)
    }

    /// Clock records of a view's blocks, in the order of the blocks.
    pub fn clock(&self, view_id: &str) -> Result<Vec<ClockRecord>> {
        let folder = self.path("clock");
        let mut records = Vec::new();
        for entry in std::fs::read_dir(&folder).map_err(Error::reading(&folder))? {
            let path = entry.map_err(Error::reading(&folder))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name.starts_with(&format!("{view_id}-")) && name.ends_with(".json") {
                records.push(read::<ClockRecord>(&path)?);
            }
        }
        records.sort_by_key(|record| record.block);
        Ok(records)
    }

    /// Adds a run's seconds to the account.
    pub fn add_wall(&mut self, total_s: f64, passes_s: f64, compile_s: f64) -> Result<()> {
        let wall = &mut self.state.wall;
        wall.total_s += total_s;
        wall.passes_s += passes_s;
        wall.compile_s += compile_s;
        self.write(STATE, &self.state)
    }

    fn write(&self, relative: &str, value: &impl Serialize) -> Result<()> {
        let path = self.path(relative);
        let text = serde_json::to_vec_pretty(value).map_err(|e| Error::writing(&path)(e.into()))?;
        write_atomic(&path, |file| {
            file.write_all(&text).map_err(Error::writing(&path))
        })
    }
}

fn refuse_other(folder: &Path, found: &FolderState, wanted: &FolderState) -> Result<()> {
    let refused = |problem: String| {
        let remedy = "Name another folder with --out, or remove this one.";
        Err(Error::input(folder.display().to_string(), problem, remedy))
    };
    if found.experiment != wanted.experiment {
        return refused("the folder holds the records of another experiment".to_owned());
    }
    let (theirs, ours) = (&found.environment, &wanted.environment);
    if found.sources != wanted.sources {
        let sources = |state: &FolderState| match state.sources.get(..12) {
            None if state.sources.is_empty() => "sources not recorded".to_owned(),
            start => format!("sources {}", start.unwrap_or(&state.sources)),
        };
        return refused(format!(
            "the folder was measured by {} ({}), this program is {} ({}), and numbers of different sources are not mixed",
            theirs.commit,
            sources(found),
            ours.commit,
            sources(wanted)
        ));
    }
    // The commit is left out: commits whose sources have equal hashes give the same numbers.
    let machine = |environment: &Environment| Environment {
        commit: String::new(),
        ..environment.clone()
    };
    if machine(theirs) != machine(ours) {
        return refused(format!(
            "the folder holds records from `{}` ({}; {}), this run is on `{}` ({}; {})",
            theirs.adapter, theirs.driver, theirs.host, ours.adapter, ours.driver, ours.host
        ));
    }
    Ok(())
}

/// Notes on changes since the last run under which its records may be kept.
fn differences(found: &FolderState, wanted: &FolderState) -> Vec<String> {
    let (theirs, ours) = (&found.environment.commit, &wanted.environment.commit);
    let program = (theirs != ours).then(|| {
        format!(
            "the folder was begun by {theirs}, this program is {ours}; the sources that decide numbers are the same"
        )
    });
    let changed = found.inputs.iter().filter(|(path, hash)| {
        let now = wanted.inputs.get(*path);
        now.is_some_and(|now| now != *hash)
    });
    let changed = changed.map(|(path, _)| {
        format!("{path} has changed since the last run: what it is seen in is measured again")
    });
    program.into_iter().chain(changed).collect()
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let bytes = std::fs::read(path).map_err(Error::reading(path))?;
    serde_json::from_slice(&bytes).map_err(|e| {
        Error::input(
            path.display().to_string(),
            e.to_string(),
            "Remove this file; the next run makes it again.",
        )
    })
}

#[cfg(test)]
mod tests;
