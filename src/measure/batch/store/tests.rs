//! Damaged folders, and folders that belong to something else.

use super::*;
use crate::batch::record::Report;
use crate::damage::{cases, changed, changes, damaged, edits};
use proptest::prelude::*;
use std::sync::LazyLock;

fn report() -> Report {
    serde_json::from_str(include_str!("../../../../tests/hostile/report.json")).expect("fixture")
}

/// A store whose cells and truth are those of the fixture.
fn filled(folder: &Path) -> Store {
    let report = report();
    let store = open(folder).expect("store");
    report
        .cells
        .iter()
        .for_each(|c| store.put_cell(c).expect("cell"));
    let reference = &report.references[0];
    store
        .put_reference(&reference.id, reference)
        .expect("truth");
    store.put_clock(&report.clock[0]).expect("clock");
    store
}

fn open(folder: &Path) -> Result<Store> {
    Store::open(folder, state()).map(|(store, _)| store)
}

fn state() -> FolderState {
    let report = report();
    FolderState {
        experiment: report.experiment,
        environment: report.environment,
        sources: "a".repeat(64),
        inputs: BTreeMap::from([("cloud.npy".to_owned(), "b".repeat(64))]),
        wall: WallClock::default(),
    }
}

fn opened_as(edit: impl FnOnce(&mut FolderState)) -> Result<Vec<String>> {
    let folder = tempfile::tempdir().expect("folder");
    open(folder.path())?;
    let mut other = state();
    edit(&mut other);
    Store::open(folder.path(), other).map(|(_, notes)| notes)
}

#[test]
fn records_of_other_sources_or_machines_are_refused_by_name() {
    let refused = |edit: &dyn Fn(&mut FolderState), words: &[&str]| {
        let error = opened_as(edit).expect_err("refused").to_string();
        for word in words.iter().chain(&["--out"]) {
            assert!(error.contains(word), "{word}: {error}");
        }
    };
    let (commit, adapter) = (report().environment.commit, report().environment.adapter);
    refused(
        &|state| {
            state.sources = "c".repeat(64);
            state.environment.commit = "occlab 9.9 (c0ffee)".to_owned();
        },
        &[
            &commit,
            "occlab 9.9 (c0ffee)",
            "aaaaaaaaaaaa",
            "cccccccccccc",
        ],
    );
    refused(
        &|state| state.sources = String::new(),
        &["sources not recorded"],
    );
    refused(
        &|state| state.environment.adapter = "another adapter".to_owned(),
        &[&adapter, "another adapter"],
    );
    refused(
        &|state| state.experiment = Value::Null,
        &["another experiment"],
    );
}

#[test]
fn a_folder_of_a_version_that_recorded_no_sources_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    open(folder.path()).expect("store");
    let path = folder.path().join(STATE);
    let mut old: Value =
        serde_json::from_slice(&std::fs::read(&path).expect("state")).expect("state");
    let members = old.as_object_mut().expect("members");
    members.remove("sources");
    members.remove("inputs");
    std::fs::write(&path, old.to_string()).expect("written");
    let error = open(folder.path()).err().expect("refused").to_string();
    assert!(error.contains("sources not recorded"), "{error}");
}

#[test]
fn what_changed_without_spoiling_records_is_told() {
    assert_eq!(opened_as(|_| ()).expect("the same"), [""; 0]);
    let notes = opened_as(|state| state.environment.commit = "occlab 9.9".to_owned());
    let notes = notes.expect("the same sources");
    assert!(
        notes.len() == 1 && notes[0].contains("occlab 9.9"),
        "{notes:?}"
    );
    let notes = opened_as(|state| {
        state.inputs.insert("cloud.npy".to_owned(), String::new());
        state.inputs.insert("new.npy".to_owned(), String::new());
    });
    let notes = notes.expect("the same experiment");
    assert!(
        notes.len() == 1 && notes[0].contains("cloud.npy"),
        "{notes:?}"
    );
}

fn names(error: &Error, file: &str) -> bool {
    let message = error.to_string();
    message.contains(file) && !message.chars().any(char::is_control)
}

/// A folder and its files as they were written: made once, because each is synchronised with the disk.
static FILLED: LazyLock<[(&str, Vec<u8>); 4]> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("folder");
    let store = filled(folder.path());
    [
        "cells/c0.json",
        "references/t.json",
        "clock/t-0.json",
        STATE,
    ]
    .map(|file| (file, std::fs::read(store.path(file)).expect("file")))
});

/// What a damaged file in the folder of a batch leads to: the record under its own id, or an error that names the file.
fn holds(damage: impl Fn(&[u8]) -> Vec<u8>) {
    let folder = tempfile::tempdir().expect("folder");
    let store = Store {
        folder: folder.path().to_owned(),
        state: state(),
    };
    for (file, bytes) in &*FILLED {
        let path = store.path(file);
        std::fs::create_dir_all(path.parent().expect("folder")).expect("folder");
        std::fs::write(&path, damage(bytes)).expect("written");
    }
    match store.cell("c0") {
        Ok(cell) => assert_eq!(cell.id, "c0"),
        Err(error) => assert!(names(&error, "c0.json"), "{error}"),
    }
    if let Err(error) = store.reference("t") {
        assert!(names(&error, "t.json"), "{error}");
    }
    if let Err(error) = store.clock("t") {
        assert!(names(&error, "t-0.json"), "{error}");
    }
    if let Err(error) = open(folder.path()) {
        assert!(
            names(&error, &folder.path().display().to_string()),
            "{error}"
        );
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn damaged_files_are_read_or_refused(edits in edits()) {
        holds(|bytes| damaged(bytes, &edits, usize::MAX));
    }

    #[test]
    fn changed_records_are_read_or_refused(changes in changes()) {
        holds(|bytes| {
            let value = serde_json::from_slice(bytes).expect("record");
            changed(value, &changes).to_string().into_bytes()
        });
    }
}

#[test]
fn a_cell_whose_id_is_a_path_is_refused_and_nothing_is_written_outside() {
    let outside = tempfile::tempdir().expect("folder");
    let store = filled(&outside.path().join("report"));
    let mut cell = store.cell("c0").expect("cell");
    cell.id = "../../escape".to_owned();
    let text = serde_json::to_vec(&cell).expect("text");
    std::fs::write(store.path("cells/c0.json"), text).expect("written");
    let error = store.cell("c0").expect_err("refused");
    assert!(names(&error, "c0.json") && error.to_string().contains("../../escape"));
    assert_eq!(
        std::fs::read_dir(outside.path()).expect("folder").count(),
        1
    );
}
