//! Provenance of this program, fixed when it is built (by `build.rs` beside it): the commit, and hashes of the sources.
//! Two builds whose hashes agree compute the same numbers, whatever their commits.

/// Commit of the sources, 12 hexadecimal digits, with `-dirty` where compiled-in files differed from it; `unknown`
/// where the sources came without their history.
pub fn commit() -> &'static str {
    env!("OCCLAB_COMMIT")
}

/// Version and commit: `0.1.0 (0123456789ab)`.
pub fn version() -> &'static str {
    concat!(env!("CARGO_PKG_VERSION"), " (", env!("OCCLAB_COMMIT"), ")")
}

/// Hash of the sources that determine the pixels of a truth, 64 hexadecimal digits. Shaders are not in it: they can be
/// reloaded, and [`Sources::hash`](crate::gpu::Sources::hash) is that of the ones in use.
pub fn truth_sources() -> &'static str {
    env!("OCCLAB_TRUTH_SOURCES")
}

/// Hash of the sources that decide any number of a cell, the compiled-in shaders included, 64 hexadecimal digits.
pub fn cell_sources() -> &'static str {
    env!("OCCLAB_CELL_SOURCES")
}

#[cfg(test)]
#[path = "build.rs"]
#[allow(dead_code, reason = "the script's own `main` runs before a build")]
mod build;

#[cfg(test)]
mod tests {
    use super::build::{
        COMPILED_IN, CRATES_WITHOUT_NUMBERS, Git, NOT_IN_CELLS, NOT_IN_TRUTHS, ROOT, cell_sources,
        commit, computing_crates, truth_sources,
    };
    use super::*;
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::process::Command;

    /// The repository.
    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join(ROOT)
    }

    /// A repository with a file in every kind of place, below `folder`.
    fn small(folder: &Path) {
        let lock = "[[package]]\nname = \"occlab\"\ndependencies = [\n \"clap\",\n \"occlab-render\",\n]\n\n\
                    [[package]]\nname = \"occlab-render\"\ndependencies = [\n \"wgpu\",\n]\n\n\
                    [[package]]\nname = \"wgpu-core\"\nversion = \"30.0.1\"\n";
        for (name, text) in [
            ("Cargo.lock", lock),
            ("Cargo.toml", "[package]\n"),
            ("README.md", "read me\n"),
            ("configs/quick.json", "{}\n"),
            ("shaders/raymarch.wgsl", "// march\n"),
            ("src/measure/batch/mod.rs", "// batch\n"),
            ("src/cli/mod.rs", "// cli\n"),
            ("src/lib.rs", "// library\n"),
            ("src/render/raymarch/mod.rs", "// march\n"),
        ] {
            write(folder, name, text);
        }
    }

    fn write(folder: &Path, name: &str, text: &str) {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    fn hashes(root: &Path) -> [String; 2] {
        [truth_sources(root).unwrap(), cell_sources(root).unwrap()]
    }

    /// Which of the two hashes a change of one file changes: of truths, of cells.
    fn changed(name: &str, text: &str) -> [bool; 2] {
        let folder = tempfile::tempdir().unwrap();
        small(folder.path());
        let before = hashes(folder.path());
        write(folder.path(), name, text);
        let after = hashes(folder.path());
        [0, 1].map(|i| before[i] != after[i])
    }

    #[test]
    fn a_hash_changes_with_every_source_that_decides_a_number_and_with_no_other() {
        let lock = |name: &str, version: &str| {
            let text = fs::read_to_string(root().join("Cargo.lock")).unwrap();
            let start = text.find(&format!("name = \"{name}\"\n")).unwrap();
            let (head, tail) = text.split_at(start);
            let line = tail.lines().nth(1).unwrap();
            computing_crates(&(head.to_owned() + &tail.replacen(line, version, 1)))
        };
        let other = "version = \"99.0.0\"";
        let [wgpu, naga, clap] = ["wgpu-core", "naga", "clap"].map(|name| lock(name, other));
        let ours = computing_crates(&fs::read_to_string(root().join("Cargo.lock")).unwrap());
        assert!(wgpu != ours && naga != ours && naga != wgpu);
        assert_eq!(clap, ours);

        for (name, expected) in [
            ("src/render/raymarch/mod.rs", [true, true]),
            ("src/lib.rs", [true, true]),
            ("src/new_module/deep/in.rs", [true, true]),
            ("src/table.bin", [true, true]),
            ("src/measure/batch/mod.rs", [false, true]),
            ("shaders/raymarch.wgsl", [false, true]),
            ("shaders/new.wgsl", [false, true]),
            ("src/cli/mod.rs", [false, false]),
            ("README.md", [false, false]),
            ("configs/quick.json", [false, false]),
            ("src/render/raymarch/.mod.rs.swp", [false, false]),
            ("src/render/tests/maps.rs", [false, false]),
        ] {
            assert_eq!(changed(name, "changed"), expected, "{name}");
        }
        // Moving a file also changes the hash.
        let folder = tempfile::tempdir().unwrap();
        small(folder.path());
        let before = hashes(folder.path());
        fs::rename(
            folder.path().join("src/lib.rs"),
            folder.path().join("src/library.rs"),
        )
        .unwrap();
        assert_ne!(hashes(folder.path()), before);
    }

    #[test]
    fn the_hashes_of_this_build_are_those_of_its_sources() {
        let [truths, cells] = hashes(&root());
        assert_eq!(
            (truth_sources(&root()).unwrap(), truths.len()),
            (truths.clone(), 64)
        );
        assert_eq!(super::truth_sources(), truths);
        assert_eq!(super::cell_sources(), cells);
        assert_ne!(truths, cells);
    }

    /// Every file below `folder`.
    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let below = |path: PathBuf| match path.is_dir() {
            true => files(&path),
            false => vec![path],
        };
        entries.flat_map(below).collect()
    }

    /// Lines of hashed code that use one of `modules`, which are not hashed. The compiler ensures that no part below
    /// `output` uses it.
    fn uses(modules: &[&str]) -> Vec<String> {
        let source = root().join("src");
        let counts = |path: &PathBuf| {
            !modules
                .iter()
                .any(|name| path.starts_with(source.join(name)))
        };
        // Concatenated, so that this line is not found itself.
        let root = ["crate", "::"].concat();
        let names = |line: &str| {
            let code = line.split("//").next().unwrap_or_default();
            let used = |path: &&str| {
                let module = path.rsplit('/').next().unwrap_or(path);
                code.contains(&format!("{root}{}", module.trim_end_matches(".rs")))
            };
            code.contains(&format!("{root}{{")) || modules.iter().any(used)
        };
        let mut found = Vec::new();
        for path in files(&source)
            .into_iter()
            .filter(counts)
            .filter(|p| p.extension().is_some_and(|e| e == "rs"))
        {
            let text = fs::read_to_string(&path).unwrap();
            let lines = text.lines().filter(|line| names(line));
            found.extend(lines.map(|line| format!("{}: {line}", path.display())));
        }
        found
    }

    #[test]
    fn what_does_not_count_has_a_reason_and_is_used_by_nothing_that_counts() {
        let source = root().join("src");
        for (name, reason) in NOT_IN_CELLS.iter().chain(&NOT_IN_TRUTHS) {
            assert!(
                source.join(name).exists(),
                "there is no src/{name} any more"
            );
            assert!(reason.split(' ').count() > 1, "src/{name} has no reason");
        }
        let cells = NOT_IN_CELLS.map(|(name, _)| name);
        let truths = [&cells[..], &NOT_IN_TRUTHS.map(|(name, _)| name)].concat();
        assert_eq!(uses(&cells), [""; 0]);
        assert_eq!(uses(&truths), [""; 0]);
        // Control: `batch` uses `metrics`, and would be found.
        assert_ne!(uses(&["base/metrics"]), [""; 0]);
        let lock = fs::read_to_string(root().join("Cargo.lock")).unwrap();
        for name in CRATES_WITHOUT_NUMBERS.split_whitespace() {
            assert!(
                lock.contains(&format!("name = \"{name}\"\n")),
                "no crate {name} is used any more"
            );
        }
    }

    /// Runs git in a test's own repository, with no settings but these.
    fn git(root: &Path, arguments: &[&str]) {
        let settings = ["-c", "user.name=a", "-c", "user.email=a@example.org"];
        let mut command = Command::new("git");
        command
            .env_remove("GIT_DIR")
            .env_remove("GIT_INDEX_FILE")
            .env("GIT_CONFIG_GLOBAL", root.join("none"));
        let output = command
            .current_dir(root)
            .args(settings)
            .args(arguments)
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{arguments:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }

    #[test]
    fn the_commit_is_named_and_dirty_only_where_the_program_would_be_another() {
        use std::io::Write;
        if Command::new("git").arg("--version").output().is_err() {
            // Not eprintln!, which the test harness keeps to itself when a test passes.
            let _ = writeln!(std::io::stderr(), "skipped: git is not installed");
            return;
        }
        let (folder, scratch) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let (root, index) = (folder.path(), scratch.path().join("index"));
        let label = || {
            commit(&Git {
                program: "git",
                root,
                index: &index,
            })
        };
        small(root);
        assert_eq!(label(), "unknown", "no repository");
        git(root, &["init", "--quiet"]);
        assert_eq!(label(), "unknown", "no commit");
        git(
            root,
            &["commit", "--quiet", "--allow-empty", "-m", "another's"],
        );
        assert_eq!(label(), "unknown", "somebody else's repository");
        git(root, &["add", "."]);
        git(root, &["commit", "--quiet", "-m", "all"]);
        let clean = label();
        assert!(
            clean.len() == 12 && clean.chars().all(|c| c.is_ascii_hexdigit()),
            "{clean}"
        );

        write(root, "README.md", "changed");
        write(root, "reports/quick/report.json", "{}");
        assert_eq!(label(), clean, "neither is compiled in");
        let dirty = format!("{clean}-dirty");
        for name in [
            "src/lib.rs",
            "src/new.rs",
            "shaders/new.wgsl",
            "configs/quick.json",
            "Cargo.toml",
            "Cargo.lock",
        ] {
            let before = fs::read(root.join(name)).ok();
            write(root, name, "changed");
            assert_eq!(label(), dirty, "{name}");
            git(root, &["add", name]);
            assert_eq!(label(), dirty, "{name}, staged");
            match before {
                Some(text) => fs::write(root.join(name), text).unwrap(),
                None => fs::remove_file(root.join(name)).unwrap(),
            }
            assert_eq!(
                label(),
                clean,
                "{name}, back: what is staged is not what is built"
            );
            git(root, &["reset", "--quiet"]);
        }
        git(root, &["commit", "--quiet", "-am", "readme"]);
        assert!(label() != clean && label().len() == 12);
    }

    #[test]
    fn without_git_a_source_archive_says_unknown() {
        let (folder, scratch) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        small(folder.path());
        let label = commit(&Git {
            program: "occlab-has-no-such-program",
            root: folder.path(),
            index: &scratch.path().join("index"),
        });
        assert_eq!(label, "unknown");
        assert!(COMPILED_IN.iter().all(|name| root().join(name).exists()));
    }

    #[test]
    fn this_build_names_its_commit() {
        let (label, version) = (super::commit(), version());
        let hash = label.strip_suffix("-dirty").unwrap_or(label);
        let named = hash.len() == 12 && hash.chars().all(|c| c.is_ascii_hexdigit());
        assert!(named || label == "unknown", "{label}");
        assert_eq!(version, format!("{} ({label})", env!("CARGO_PKG_VERSION")));
        assert_eq!(crate::environment::program(), format!("occlab {version}"));
    }
}
