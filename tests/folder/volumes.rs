//! A volume that changes in place, between two runs or during one.

use super::program::{batch, cells, modified, refused, report, stderr, workplace};
use super::{errors, report_in, run, with_volume, write_volume};
use occlab::backend::{Backend, Choice};
use occlab::batch::{self, Event};
use occlab::config::load_experiment;
use serde_json::{Value, json};
use std::ops::ControlFlow;

/// One view of a volume of density 1.
fn volume_workplace() -> tempfile::TempDir {
    let folder = workplace(|s, e| {
        with_volume(s);
        e["sun_elevation_deg"] = json!(60);
        e["methods"] = json!([{"method": "srm", "steps": 2}, "none"]);
    });
    write_volume(folder.path(), 1.0);
    folder
}

#[test]
fn a_volume_changed_in_place_is_measured_again_and_found_again_when_it_is_put_back() {
    let folder = volume_workplace();
    let volume = folder.path().join("cube.npy");
    let touched = std::fs::metadata(&volume).unwrap().modified().unwrap();
    assert!(batch(folder.path()).status.success());
    let first = report(folder.path());
    let kept = modified(cells(folder.path()));

    write_volume(folder.path(), 3.0);
    let file = std::fs::File::options().write(true).open(&volume).unwrap();
    file.set_modified(touched).unwrap();
    let output = run(folder.path(), &["small.json", "--out", "out"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let notes = stderr(&output);
    assert!(
        notes.contains("cube.npy has changed since the last run"),
        "{notes}"
    );
    let second = report(folder.path());
    assert!(
        run(folder.path(), &["small.json", "--out", "fresh"])
            .status
            .success()
    );
    let fresh = report_in(folder.path(), "fresh");
    assert_eq!(errors(&second), errors(&fresh));
    assert_ne!(errors(&second), errors(&first), "the first file's errors");
    assert_ne!(second["references"][0]["id"], first["references"][0]["id"]);
    let hash = blake3::hash(&std::fs::read(&volume).unwrap()).to_string();
    assert_eq!(second["inputs"][0]["blake3"], json!(hash));

    write_volume(folder.path(), 1.0);
    assert!(batch(folder.path()).status.success());
    assert_eq!(report(folder.path())["cells"], first["cells"]);
    let paths = kept.iter().map(|(path, _)| path.clone());
    assert_eq!(modified(paths), kept, "cells were measured again");
}

#[test]
fn a_volume_that_is_deleted_or_truncated_between_two_runs_is_an_error_that_loses_nothing() {
    let folder = volume_workplace();
    assert!(batch(folder.path()).status.success());
    let (before, kept) = (report(folder.path()), modified(cells(folder.path())));
    let volume = folder.path().join("cube.npy");
    let whole = std::fs::read(&volume).unwrap();
    std::fs::remove_file(&volume).unwrap();
    refused(
        &batch(folder.path()),
        &["cube.npy: cannot read", "put it back", "are kept"],
    );
    std::fs::write(&volume, &whole[..whole.len() - 7]).unwrap();
    refused(&batch(folder.path()), &["cube.npy"]);
    std::fs::write(&volume, &whole).unwrap();
    assert!(batch(folder.path()).status.success());
    assert_eq!(report(folder.path())["cells"], before["cells"]);
    let paths = kept.iter().map(|(path, _)| path.clone());
    assert_eq!(modified(paths), kept, "cells were measured again");
}

#[test]
fn a_volume_that_changes_while_it_is_measured_is_not_recorded() {
    let folder = volume_workplace();
    let path = folder.path().join("small.json");
    let mut small: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    small["image"] = json!({"width": 6, "height": 4});
    std::fs::write(&path, small.to_string()).unwrap();
    let experiment = load_experiment(&path).unwrap();
    let backend = Backend::open(Choice::Cpu, None).unwrap();
    let out = folder.path().join("out");
    let mut changed = false;
    let result = batch::run(&experiment, &backend, &out, None, &mut |event| {
        let in_rounds = matches!(&event, Event::Stage { what, .. } if what.contains("round"));
        if in_rounds && !changed {
            changed = true;
            write_volume(folder.path(), 2.0);
        }
        ControlFlow::Continue(())
    });
    let error = result.unwrap_err().to_string();
    assert!(
        error.contains("cube.npy") && error.contains("changed while"),
        "{error}"
    );
    assert!(cells(folder.path()).is_empty(), "a record of two contents");
}
