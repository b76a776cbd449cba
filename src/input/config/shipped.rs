//! Built-in experiments, scenes and studies, and the file that a name on the command line stands for.
//!
//! A built-in file has the path that it has in the sources, e.g. `configs/scenes/cumulus.json`. Reading that path gives
//! the file on disk, or the built-in one where there is none.

use super::suggest;
use crate::error::{Error, Result};
use crate::frame::atomic::create_atomic;
use include_dir::{Dir, include_dir};
use std::ffi::OsStr;
use std::io::Write;
use std::path::{Component, Path, PathBuf};

static FILES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../configs");

/// Folder of the built-in files, and the folder below the working directory whose files replace them.
const ROOT: &str = "configs";
/// The only file of [`ROOT`] itself that is no experiment.
const SWEEP: &str = "configs/stability.json";

/// Kind of file that a name on the command line stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A scene of `configs/scenes`.
    Scene,
    /// An experiment of `configs`.
    Experiment,
    /// A study of `configs/studies`.
    Study,
    /// The sweep of `occlab stability`.
    Stability,
}

impl FileKind {
    fn folder(self) -> &'static str {
        match self {
            Self::Scene => "configs/scenes",
            Self::Study => "configs/studies",
            Self::Experiment | Self::Stability => ROOT,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Experiment => "experiment",
            Self::Study => "study",
            Self::Stability => "stability",
        }
    }

    /// Whether a file of [`FileKind::folder`] is of this kind.
    fn holds(self, path: &Path) -> bool {
        let is_sweep = path == Path::new(SWEEP);
        match self {
            Self::Experiment => !is_sweep,
            Self::Stability => is_sweep,
            Self::Scene | Self::Study => true,
        }
    }
}

/// The file that `name` stands for, the first that exists of: `NAME`, `NAME.json`, `NAME.json` in the folder of its
/// kind below the working directory, and the built-in file of that name.
pub fn find(kind: FileKind, name: &Path) -> Result<PathBuf> {
    let mut with_ending = name.as_os_str().to_owned();
    if !is_json(name) {
        with_ending.push(".json");
    }
    let with_ending = PathBuf::from(with_ending);
    let in_folder = Path::new(kind.folder()).join(&with_ending);
    let candidates = [name.to_owned(), with_ending, in_folder];
    let on_disk = |path: &&PathBuf| path.exists() && !path.is_dir();
    let found = candidates.iter().find(on_disk);
    let found = found.or_else(|| candidates.iter().find(|path| text(path).is_some()));
    found.cloned().ok_or_else(|| unknown(kind, name))
}

fn unknown(kind: FileKind, name: &Path) -> Error {
    let names: Vec<String> = built_in(kind).iter().map(|path| stem(path)).collect();
    let hint = suggest::sentence(&stem(name), names.iter().map(String::as_str));
    let (word, folder) = (kind.word(), kind.folder());
    Error::input(
        name.display().to_string(),
        format!(
            "there is no {word} file of this name, neither here nor in {folder}, and none is built in"
        ),
        format!("{hint}Built in: {}.", names.join(", ")),
    )
}

fn is_json(path: &Path) -> bool {
    path.extension() == Some(OsStr::new("json"))
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Paths of all files of a kind, sorted: those of the folder below the working directory, and the built-in ones that
/// none of them replaces.
pub fn list(kind: FileKind) -> Vec<PathBuf> {
    let beside = std::fs::read_dir(kind.folder()).into_iter().flatten();
    let mut paths: Vec<PathBuf> = beside
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| is_json(path) && kind.holds(path))
        .chain(built_in(kind))
        .collect();
    paths.sort();
    paths.dedup();
    paths
}

fn built_in(kind: FileKind) -> Vec<PathBuf> {
    let inside = |path: &Path| path.parent() == Some(Path::new(kind.folder())) && kind.holds(path);
    let mut paths: Vec<PathBuf> = all().into_iter().map(|(path, _)| path).collect();
    paths.retain(|path| inside(path));
    paths
}

/// Every built-in file, sorted by path.
fn all() -> Vec<(PathBuf, &'static str)> {
    fn collect(folder: &'static Dir<'static>, into: &mut Vec<(PathBuf, &'static str)>) {
        let files = folder.files().filter(|file| is_json(file.path()));
        for (file, text) in files.filter_map(|file| Some((file, file.contents_utf8()?))) {
            into.push((Path::new(ROOT).join(file.path()), text));
        }
        folder.dirs().for_each(|folder| collect(folder, into));
    }
    let mut files = Vec::new();
    collect(&FILES, &mut files);
    files.sort();
    files
}

/// Text of the built-in file of this path.
pub(super) fn text(path: &Path) -> Option<&'static str> {
    let plain: PathBuf = path
        .components()
        .filter(|step| *step != Component::CurDir)
        .collect();
    let inside = plain.strip_prefix(ROOT).ok()?;
    FILES.get_file(inside)?.contents_utf8()
}

/// The file that a scene's path in an experiment stands for: a file relative to the experiment's folder, or the
/// built-in one of that path, as given or below `configs`.
pub(super) fn scene_of_experiment(folder: &Path, path: &str) -> Option<PathBuf> {
    let beside = folder.join(path);
    if beside.is_file() || text(&beside).is_some() {
        return Some(beside);
    }
    Some(Path::new(ROOT).join(path)).filter(|path| text(path).is_some())
}

/// The names of the built-in scenes as an experiment writes them.
pub(super) fn scene_paths() -> String {
    let paths = built_in(FileKind::Scene);
    let names = paths.iter().filter_map(|path| path.strip_prefix(ROOT).ok());
    let names: Vec<String> = names.map(|path| path.display().to_string()).collect();
    names.join(", ")
}

/// Result of writing out one built-in file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Copied {
    /// The file is new.
    Written,
    /// A file of the same content existed.
    Same,
    /// A file of other content existed and was left as it is.
    Kept,
}

/// Writes every built-in file below `folder` where there is none; nothing that exists is touched.
pub fn write_out(folder: &Path) -> Result<Vec<(PathBuf, Copied)>> {
    let write = |(path, text): (PathBuf, &str)| {
        let path = folder.join(path);
        let outcome = write_new(&path, text)?;
        Ok((path, outcome))
    };
    all().into_iter().map(write).collect()
}

fn write_new(path: &Path, text: &str) -> Result<Copied> {
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent).map_err(Error::writing(parent))?;
    }
    let written = create_atomic(path, |file| {
        file.write_all(text.as_bytes())
            .map_err(Error::writing(path))
    })?;
    let same = || std::fs::read(path).is_ok_and(|found| found == text.as_bytes());
    Ok(match written {
        true => Copied::Written,
        false if same() => Copied::Same,
        false => Copied::Kept,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Paths below `folder`, files only.
    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        let mut found: Vec<PathBuf> = paths
            .flat_map(|path| match path.is_dir() {
                true => files(&path),
                false => vec![path],
            })
            .collect();
        found.sort();
        found
    }

    #[test]
    fn every_file_of_the_folder_is_built_in() {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        let on_disk: Vec<_> = files(&root.join(ROOT))
            .into_iter()
            .map(|path| {
                let text = std::fs::read_to_string(&path).unwrap();
                (path.strip_prefix(root).unwrap().to_owned(), text)
            })
            .collect();
        let built_in: Vec<_> = all()
            .into_iter()
            .map(|(path, text)| (path, text.to_owned()))
            .collect();
        assert!(on_disk.len() > 20);
        assert_eq!(on_disk, built_in);
    }

    #[test]
    fn a_path_is_built_in_however_it_is_written_and_no_other_is() {
        for path in [
            "configs/quick.json",
            "./configs/quick.json",
            "configs/./quick.json",
        ] {
            assert!(text(Path::new(path)).is_some(), "{path}");
        }
        for path in [
            "quick.json",
            "configs",
            "/configs/quick.json",
            "configs/../configs/quick.json",
            "",
        ] {
            assert!(text(Path::new(path)).is_none(), "{path}");
        }
    }

    #[test]
    fn a_name_found_nowhere_lists_what_is_built_in() {
        let message = find(FileKind::Experiment, Path::new("quik"))
            .unwrap_err()
            .to_string();
        for words in [
            "quik: there is no experiment",
            "Did you mean `quick`?",
            "convergence, decompose",
        ] {
            assert!(message.contains(words), "{words}: {message}");
        }
        assert!(
            !message.contains("stability"),
            "a sweep is no experiment: {message}"
        );
        assert_eq!(
            list(FileKind::Stability),
            [Path::new(SWEEP)],
            "the only sweep"
        );
    }
}
