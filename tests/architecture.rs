//! Checks that the sources import in the direction of the floors in `src/ARCHITECTURE.md`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Modules with the floor each stands on, 0 lowest, and its crate, as the architecture lists them.
fn listed() -> BTreeMap<String, (usize, String)> {
    let text = fs::read_to_string(source().join("ARCHITECTURE.md")).expect("architecture");
    let list = text.split("```floors\n").nth(1).expect("list of floors");
    let list = list.split("```").next().expect("end of the list");
    let mut floors = BTreeMap::new();
    for (floor, line) in list.lines().enumerate() {
        let (krate, modules) = line.split_once(": ").expect("crate: modules");
        for module in modules.split_whitespace() {
            let before = floors.insert(module.to_owned(), (floor, krate.to_owned()));
            assert!(before.is_none(), "`{module}` stands on two floors");
        }
    }
    floors
}

fn floors() -> BTreeMap<String, usize> {
    let listed = listed().into_iter();
    listed.map(|(module, (floor, _))| (module, floor)).collect()
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Rust files below `path`, which may be a file.
fn files(path: &Path) -> Vec<PathBuf> {
    match fs::read_dir(path) {
        Ok(entries) => entries
            .flat_map(|entry| files(&entry.expect("entry").path()))
            .collect(),
        Err(_) if path.extension().is_some_and(|e| e == "rs") => vec![path.to_owned()],
        Err(_) => Vec::new(),
    }
}

/// Code that is compiled outside tests: without comments and without what follows a test module's attribute.
fn code(text: &str) -> String {
    let compiled = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let lines = compiled
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Modules that a piece of code names after `root` (`crate`, or the crate's name): in paths and in lists of a `use`.
fn named(code: &str, root: &str) -> Vec<String> {
    let word = |text: &str| -> String {
        let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
        text[..end.unwrap_or(text.len())].to_owned()
    };
    let path = format!("{root}::");
    let mut names = Vec::new();
    for (at, _) in code.match_indices(&path) {
        let before = code[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        match code[at + path.len()..].strip_prefix('{') {
            None => names.push(word(&code[at + path.len()..])),
            Some(list) => {
                let mut depth = 0;
                let mut first = true;
                for (i, c) in list.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => first = true,
                        c if first && depth == 0 && !c.is_whitespace() => {
                            names.push(word(&list[i..]));
                            first = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    names
}

/// Imports against the direction: `module: import`.
fn against(floors: &BTreeMap<String, usize>, module: &str, imports: &[String]) -> Vec<String> {
    let own = floors.get(module);
    let wrong = |import: &&String| {
        // A name that is no module is exported from one, and not checked.
        let other = floors.get(import.as_str());
        import.as_str() != module && other.is_some_and(|other| Some(other) >= own)
    };
    let found = imports.iter().filter(wrong);
    found.map(|import| format!("{module}: {import}")).collect()
}

/// Folders of the crates below `source()`, each with its crate's name; the top crate has `source()` itself.
fn crates() -> Vec<(String, PathBuf)> {
    let entries = fs::read_dir(source()).expect("src");
    let paths = entries.map(|entry| entry.expect("entry").path());
    let parts = paths.filter(|path| path.join("Cargo.toml").exists());
    let name = |path: &Path| {
        path.file_name()
            .expect("name")
            .to_string_lossy()
            .into_owned()
    };
    let mut crates: Vec<_> = parts.map(|path| (name(&path), path)).collect();
    crates.push(("occlab".to_owned(), source()));
    crates
}

/// Every module of a crate, in its folder, and what it imports.
fn imports_in(folder: &Path) -> BTreeMap<String, Vec<String>> {
    let mut imports = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("crate") {
        let path = entry.expect("entry").path();
        let name = path.file_stem().expect("name").to_string_lossy();
        let folder = path.is_dir() && !path.join("Cargo.toml").exists();
        let module = folder || path.extension().is_some_and(|e| e == "rs");
        if !module || ["lib", "main", "build", "tests"].contains(&&*name) {
            continue;
        }
        let modules: &mut Vec<String> = imports.entry(name.into_owned()).or_default();
        for file in files(&path) {
            let test = file.iter().any(|part| part == "tests")
                || file
                    .file_name()
                    .is_some_and(|n| n.to_string_lossy().contains("tests.rs"));
            if !test {
                let code = code(&fs::read_to_string(&file).expect("source"));
                modules.extend(named(&code, "crate"));
                modules.extend(named(&code, "occlab"));
            }
        }
    }
    imports
}

/// Every module of every crate and what it imports.
fn imports() -> BTreeMap<String, Vec<String>> {
    let crates = crates().into_iter();
    crates.flat_map(|(_, folder)| imports_in(&folder)).collect()
}

#[test]
fn every_module_stands_on_a_floor_and_every_floor_holds_modules_that_exist() {
    let listed: BTreeMap<_, _> = listed()
        .into_iter()
        .map(|(module, (_, krate))| (module, krate))
        .collect();
    let found: BTreeMap<_, _> = crates()
        .into_iter()
        .flat_map(|(krate, folder)| {
            let modules = imports_in(&folder).into_keys();
            modules.map(move |module| (module, krate.clone()))
        })
        .collect();
    assert_eq!(listed, found);
}

/// The compiler enforces the floors between crates only if each names no crate of the project but the one below it.
#[test]
fn each_crate_names_the_one_below_alone() {
    let list = fs::read_to_string(source().join("ARCHITECTURE.md")).expect("architecture");
    let list = list.split("```floors\n").nth(1).expect("list of floors");
    let mut order: Vec<&str> = list
        .lines()
        .map_while(|line| Some(line.split_once(": ")?.0))
        .collect();
    order.dedup();
    let mut folders: BTreeMap<_, _> = crates().into_iter().collect();
    for (i, name) in order.iter().enumerate() {
        let folder = folders.remove(*name).expect("a crate of the list");
        let manifest = match *name {
            "occlab" => folder.join("../Cargo.toml"),
            _ => folder.join("Cargo.toml"),
        };
        let text = fs::read_to_string(manifest).expect("manifest");
        let named = text.lines().filter_map(|line| {
            line.strip_prefix("occlab-")?
                .strip_suffix(".workspace = true")
        });
        let below: Vec<_> = order[..i].last().into_iter().copied().collect();
        assert_eq!(named.collect::<Vec<_>>(), below, "crate {name}");
    }
    assert_eq!(folders.keys().collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn imports_point_down() {
    let floors = floors();
    let wrong: Vec<_> = imports()
        .iter()
        .flat_map(|(module, imports)| against(&floors, module, imports))
        .collect();
    assert!(
        wrong.is_empty(),
        "imports against the direction: {wrong:#?}"
    );
}

/// Control: imports in the wrong direction, in every form that one can be written in.
#[test]
fn a_planted_import_is_found() {
    let floors = floors();
    for text in [
        "use crate::report::write;",
        "use crate::{error::Result, report::{self, page}};",
        "use crate::{\n    frame::{Frame, atomic::write},\n    report,\n};",
        "fn f() { crate::report::write() }",
        "/* a */ let r = &crate::report::Page;",
    ] {
        let found = against(&floors, "batch", &named(&code(text), "crate"));
        assert_eq!(found, ["batch: report"], "{text}");
    }
    for text in [
        "// use crate::report::write;",
        "use crate::frame::report;",
        "use mycrate::report::write;",
        "fn f() {}\n#[cfg(test)]\nmod tests {\n    use crate::report::write;\n}",
    ] {
        let found = against(&floors, "batch", &named(&code(text), "crate"));
        assert!(found.is_empty(), "{text}: {found:?}");
    }
}
