//! Build script: the commit that a build is made from, and hashes of the sources that decide its numbers.
//!
//! `provenance.rs` beside it makes the results available and tests the functions below. Everything below `src` of the
//! repository is hashed except two short lists, so that a new module is hashed by default.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// The repository, from this package.
pub const ROOT: &str = "../..";

/// What is compiled in, relative to the repository: a change of anything else leaves the program the same.
pub const COMPILED_IN: [&str; 5] = ["src", "shaders", "configs", "Cargo.toml", "Cargo.lock"];

/// Paths below `src` that decide no number of a cell, and why. No hashed module may use one of these.
pub const NOT_IN_CELLS: [(&str, &str); 9] = [
    ("ARCHITECTURE.md", "is read by people and one test"),
    ("BIBLIOGRAPHY.md", "is read by people and one test"),
    (
        "cli",
        "hands options to the library and prints what comes back",
    ),
    (
        "live",
        "serves the window; its pictures are not recorded, and its batches are those of `batch`",
    ),
    ("main.rs", "calls `cli`"),
    ("measure/build.rs", "runs before the program is built"),
    (
        "output",
        "shows records that are finished; its studies choose experiments, which `batch` records whole",
    ),
    ("render/tests", "is no part of the program"),
    ("ui", "shows what `live` renders"),
];

/// Paths below `src` that, in addition, decide no pixel of a truth.
pub const NOT_IN_TRUTHS: [(&str, &str); 3] = [
    (
        "measure/backend",
        "chooses who renders; who that was is part of a truth's name",
    ),
    ("measure/batch", "asks for truths by scene and size"),
    ("base/metrics", "compares pictures that are finished"),
];

/// Crates that the packages below `src` name and that compute nothing that is recorded: errors, text, files and hashes;
/// terminal, window and pages; tests. Every other one is hashed with its version.
pub const CRATES_WITHOUT_NUMBERS: &str = "
    anyhow base64 blake3 csv directories jsonc-parser pollster schemars serde serde_json serde_path_to_error tempfile thiserror
    clap eframe egui_plot epaint_default_fonts indicatif maud plotters rfd
    egui_kittest jsonschema proptest x11rb";

fn main() -> io::Result<()> {
    let variable = |name| {
        env::var_os(name)
            .map(PathBuf::from)
            .ok_or(io::ErrorKind::NotFound)
    };
    let (package, scratch) = (variable("CARGO_MANIFEST_DIR")?, variable("OUT_DIR")?);
    let root = package.join(ROOT);
    let git = Git {
        program: "git",
        root: &root,
        index: &scratch.join("index"),
    };
    println!("cargo:rustc-env=OCCLAB_COMMIT={}", commit(&git));
    println!(
        "cargo:rustc-env=OCCLAB_TRUTH_SOURCES={}",
        truth_sources(&root)?
    );
    println!(
        "cargo:rustc-env=OCCLAB_CELL_SOURCES={}",
        cell_sources(&root)?
    );
    // Cargo runs a script every time if a file that it names is absent.
    let compiled_in = COMPILED_IN.map(|name| root.join(name)).into_iter();
    for path in compiled_in
        .chain(git.files_of_head())
        .filter(|path| path.exists())
    {
        println!("cargo:rerun-if-changed={}", path.display());
    }
    Ok(())
}

/// Hash of the sources that determine the pixels of a truth, except shaders: these can be reloaded and are hashed at
/// run time.
pub fn truth_sources(root: &Path) -> io::Result<String> {
    let excluded = NOT_IN_CELLS.iter().chain(&NOT_IN_TRUTHS);
    let excluded: Vec<_> = excluded
        .map(|(name, _)| root.join("src").join(name))
        .collect();
    hash(root, &["src"], &excluded)
}

/// Hash of what decides any number of a cell: sources, shaders, and the crates that compute.
pub fn cell_sources(root: &Path) -> io::Result<String> {
    let excluded = NOT_IN_CELLS.map(|(name, _)| root.join("src").join(name));
    hash(root, &["src", "shaders"], &excluded)
}

/// Hash of every file below `folders` but the `excluded`, and of the computing crates in `Cargo.lock`.
fn hash(root: &Path, folders: &[&str], excluded: &[PathBuf]) -> io::Result<String> {
    let mut files = Vec::new();
    for folder in folders {
        collect(&root.join(folder), excluded, &mut files)?;
    }
    let named = |path: PathBuf| -> io::Result<(String, Vec<u8>)> {
        let parts = path.strip_prefix(root).unwrap_or(&path).iter();
        let parts: Vec<_> = parts.map(|part| part.to_string_lossy()).collect();
        Ok((parts.join("/"), fs::read(&path)?))
    };
    let mut all = files
        .into_iter()
        .map(named)
        .collect::<io::Result<Vec<_>>>()?;
    all.sort();
    let lock = fs::read_to_string(root.join("Cargo.lock")).unwrap_or_default();
    all.push(("crates".to_owned(), computing_crates(&lock).into_bytes()));
    let mut hasher = blake3::Hasher::new();
    for (name, content) in &all {
        for part in [name.as_bytes(), content] {
            hasher
                .update(&(part.len() as u64).to_le_bytes())
                .update(part);
        }
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// Adds every file below `folder` but hidden ones, which editors make.
fn collect(folder: &Path, excluded: &[PathBuf], files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        if excluded.contains(&path) || entry.file_name().as_encoded_bytes().starts_with(b".") {
            continue;
        }
        match path.is_dir() {
            true => collect(&path, excluded, files)?,
            false => files.push(path),
        }
    }
    Ok(())
}

/// Name, version and source of the crates in a `Cargo.lock` that compute: those that `occlab` and its parts name, and
/// the parts these consist of (`wgpu-core` is a part of `wgpu`). The whole file where it does not contain `occlab`.
pub fn computing_crates(lock: &str) -> String {
    let packages = || lock.split("[[package]]").skip(1);
    let name = |package: &str| {
        let line = package
            .lines()
            .find_map(|line| line.strip_prefix("name = \""));
        line.map(|rest| rest.trim_end_matches('"').to_owned())
            .unwrap_or_default()
    };
    let own = |name: &str| name == "occlab" || name.starts_with("occlab-");
    if !packages().any(|package| own(&name(package))) {
        return lock.to_owned();
    }
    let named = packages()
        .filter(|package| own(&name(package)))
        .flat_map(str::lines)
        .filter_map(|line| line.trim().strip_prefix('"')?.split(['"', ' ']).next());
    let computing: Vec<_> = named
        .filter(|name| {
            let mut without = CRATES_WITHOUT_NUMBERS.split_whitespace();
            !own(name) && !without.any(|other| other == *name)
        })
        .collect();
    let counts = |package: &&str| {
        let name = name(package);
        let part = |rest: &str| rest.is_empty() || rest.starts_with('-');
        computing
            .iter()
            .any(|whole| name.strip_prefix(whole).is_some_and(part))
    };
    // What a crate depends on stands behind its name, version, source and checksum.
    packages()
        .filter(counts)
        .filter_map(|package| package.split("dependencies").next())
        .collect()
}

/// How git is run.
pub struct Git<'a> {
    /// The program to run.
    pub program: &'a str,
    /// Folder of the sources.
    pub root: &'a Path,
    /// An index file of our own: the user's is neither written nor read, because staging changes nothing that is built.
    pub index: &'a Path,
}

impl Git<'_> {
    /// What a command prints; `None` where it fails or git is not installed.
    fn ask(&self, arguments: &[&str]) -> Option<String> {
        let mut command = Command::new(self.program);
        // Git sets these variables in a hook, to the hook's repository.
        command
            .env_remove("GIT_DIR")
            .env_remove("GIT_WORK_TREE")
            .env("GIT_INDEX_FILE", self.index);
        let output = command
            .current_dir(self.root)
            .args(arguments)
            .output()
            .ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim_end().to_owned())
    }

    /// Files that change when another commit is checked out; a linked working tree has them elsewhere.
    fn files_of_head(&self) -> Vec<PathBuf> {
        let branch = self.ask(&["symbolic-ref", "--quiet", "HEAD"]);
        let names = ["HEAD", "logs/HEAD", "packed-refs", "reftable"].map(str::to_owned);
        let places = names
            .into_iter()
            .chain(branch)
            .filter_map(|name| self.ask(&["rev-parse", "--git-path", &name]));
        places.map(|place| self.root.join(place)).collect()
    }
}

/// 12 digits of the commit, with `-dirty` where what is compiled in differs from it; `unknown` where git does not know,
/// as in a source archive.
pub fn commit(git: &Git) -> String {
    let Some((hash, dirty)) = checked_out(git) else {
        return "unknown".to_owned();
    };
    let digits: String = hash.chars().take(12).collect();
    if dirty {
        format!("{digits}-dirty")
    } else {
        digits
    }
}

/// Commit and state of the working tree; `None` where the sources are no part of the commit, but lie in some
/// other repository.
fn checked_out(git: &Git) -> Option<(String, bool)> {
    git.ask(&["rev-parse", "--verify", "--quiet", "HEAD:./Cargo.toml"])?;
    let hash = git.ask(&["rev-parse", "HEAD"])?;
    // A killed build may have left it, and git would wait for its owner.
    let _ = fs::remove_file(git.index.with_extension("lock"));
    let status = [
        "-c",
        "core.fsmonitor=false",
        "status",
        "--porcelain",
        "--untracked-files=all",
        "--",
    ];
    let status: Vec<_> = status.into_iter().chain(COMPILED_IN).collect();
    let changes = git
        .ask(&["read-tree", "HEAD"])
        .and_then(|_| git.ask(&status));
    Some((hash, changes.is_none_or(|changes| !changes.is_empty())))
}
