//! Report folders: one run at a time, one content of every file, and a report suffices to measure its cells again.

#[macro_use]
mod common;
#[path = "common/program.rs"]
mod program;
#[path = "folder/volumes.rs"]
mod volumes;

use occlab::backend::{Backend, Choice};
use occlab::batch;
use occlab::config::load_experiment;
use program::{batch, cells, modified, occlab, refused, report, scene, stderr, workplace};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

/// A long batch under way, which holds its folder.
fn under_way(folder: &Path) -> Child {
    let mut child = occlab(folder)
        .args(["batch", "small.json", "--out", "out", "--quiet"])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !folder.join("out/batch.lock").exists() {
        assert!(start.elapsed() < Duration::from_secs(120), "no lock");
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

#[test]
fn a_second_batch_in_a_folder_is_refused_at_once_and_the_first_loses_nothing() {
    needs_adapter!();
    let folder = workplace(|_, e| e["runs"] = json!(40));
    let mut first = under_way(folder.path());
    let second = batch(folder.path());
    assert!(first.try_wait().unwrap().is_none(), "the first was over");
    let process = format!("process {} on host", first.id());
    refused(&second, &["another run", &process, "UTC", "--out"]);
    let (text, line) = (
        stderr(&second),
        "error: out: another run has been using this folder",
    );
    assert!(text.lines().last().unwrap().starts_with(line), "{text}");
    assert_eq!(text.matches("another run").count(), 1, "{text}");
    assert!(second.stdout.is_empty());
    assert!(first.wait().unwrap().success());
    let report = report(folder.path());
    let found = report["cells"].as_array().unwrap();
    assert_eq!(found.len(), 9);
    let whole = |c: &Value| c["result"]["time_ms"]["wall"]["n"] == 40;
    assert!(found.iter().all(whole));
    assert!(!folder.path().join("out/batch.lock").exists());
    assert!(batch(folder.path()).status.success(), "free again");
}

#[cfg(target_os = "linux")]
#[test]
fn the_lock_of_a_killed_batch_is_taken_over() {
    needs_adapter!();
    let folder = workplace(|_, e| e["runs"] = json!(40));
    let mut first = under_way(folder.path());
    first.kill().unwrap();
    first.wait().unwrap();
    let lock = folder.path().join("out/batch.lock");
    assert!(lock.exists(), "a killed process cannot clean up");
    let second = batch(folder.path());
    assert!(second.status.success(), "{}", stderr(&second));
    assert!(!lock.exists());
}

#[test]
fn a_lock_that_cannot_be_judged_is_refused_until_it_is_removed() {
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(60));
    let lock = folder.path().join("out/batch.lock");
    std::fs::create_dir(folder.path().join("out")).unwrap();
    let elsewhere = json!({
        "host": "renderfarm-07", "process": 4711, "since_utc": "2026-11-28 09:07:01 UTC", "token": "t",
        "started": 1, "system": {"boot": "b", "process_namespace": "pid:[1]", "machine": null}
    });
    for (text, words) in [
        (
            elsewhere.to_string(),
            &["4711", "renderfarm-07", "2026-11-28"][..],
        ),
        ("{\"host\": ".to_owned(), &["cannot be read"]),
    ] {
        std::fs::write(&lock, &text).unwrap();
        let output = batch(folder.path());
        refused(&output, words);
        refused(&output, &["out/batch.lock", "remove"]);
        assert_eq!(std::fs::read_to_string(&lock).unwrap(), text);
    }
    std::fs::remove_file(&lock).unwrap();
    assert!(batch(folder.path()).status.success());
}

#[test]
fn a_batch_that_is_stopped_or_fails_frees_its_folder() {
    let folder = workplace(|_, _| {});
    let experiment = load_experiment(&folder.path().join("small.json")).unwrap();
    let backend = Backend::open(Choice::Cpu, None).unwrap();
    let out = folder.path().join("out");
    let stop = &mut |_| ControlFlow::Break(());
    let stopped = batch::run(&experiment, &backend, &out, None, stop);
    assert!(matches!(stopped, Err(occlab::Error::Stopped)));
    assert!(out.is_dir() && !out.join("batch.lock").exists());
    std::fs::write(out.join("batch.json"), "no state").unwrap();
    let failed = batch::run(&experiment, &backend, &out, None, &mut |_| {
        ControlFlow::Continue(())
    });
    assert!(failed.unwrap_err().to_string().contains("batch.json"));
    assert!(!out.join("batch.lock").exists());
}

/// A volume of one density except for a hole, whatever its time of modification.
fn write_volume(folder: &Path, density: f32) {
    common::write_cube(folder, 4, |x, y, _| match (x, y) {
        (1, 1) => 0.0,
        _ => density,
    });
}

fn with_volume(scene: &mut Value) {
    scene["density"] = json!({"volume": {"path": "cube.npy", "up_axis": 1}});
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    occlab(folder)
        .arg("batch")
        .args(arguments)
        .output()
        .unwrap()
}

fn errors(report: &Value) -> Vec<&Value> {
    let cells = report["cells"].as_array().unwrap();
    cells.iter().map(|c| &c["result"]["error"]).collect()
}

fn ids(report: &Value) -> Vec<&str> {
    let cells = report["cells"].as_array().unwrap();
    cells.iter().map(|c| c["id"].as_str().unwrap()).collect()
}

fn report_in(folder: &Path, out: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join(out).join("report.json")).unwrap()).unwrap()
}

/// Two scenes, one of them a volume with a varied extinction, two suns.
fn varied() -> tempfile::TempDir {
    let folder = workplace(|_, e| {
        e["scenes"] = json!(["slab.json", {"scene": "sub/cube.json", "set": {
            "/medium/extinction_per_m": [0.003, 0.006], "/density/volume/path": ["../cube.npy"]}}]);
        e["sun_elevation_deg"] = json!([60, 20]);
        e["methods"] = json!([{"method": "srm", "steps": [2, 4]}, {"method": "bsm", "resolution": 16, "steps": 8}]);
    });
    let mut cube = scene();
    cube["name"] = json!("cube");
    with_volume(&mut cube);
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/cube.json"), cube.to_string()).unwrap();
    write_volume(folder.path(), 1.0);
    folder
}

#[test]
fn a_report_is_measured_again_from_itself_alone() {
    let folder = varied();
    assert!(batch(folder.path()).status.success());
    let first = report(folder.path());
    assert_eq!(first["scenes"].as_array().unwrap().len(), 6, "each once");
    assert_eq!(first["inputs"].as_array().unwrap().len(), 1);
    assert_eq!(first["inputs"][0]["path"], "../cube.npy");
    for file in ["small.json", "slab.json", "sub/cube.json"] {
        std::fs::remove_file(folder.path().join(file)).unwrap();
    }
    let plan = run(folder.path(), &["out", "--dry-run"]);
    let text = String::from_utf8_lossy(&plan.stdout).into_owned();
    assert!(
        text.contains("18 cells in 6 views"),
        "{text}{}",
        stderr(&plan)
    );

    // The report and its volume move, and the report is given by its file.
    let moved = tempfile::tempdir().unwrap();
    for name in ["out", "cube.npy"] {
        std::fs::rename(folder.path().join(name), moved.path().join(name)).unwrap();
    }
    for (report, out) in [("out", "again"), ("again/report.json", "deeper/still")] {
        let output = run(moved.path(), &[report, "--out", out, "--quiet"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let again = report_in(moved.path(), out);
        assert_eq!(errors(&again), errors(&first));
        assert_eq!(ids(&again), ids(&first));
        for key in ["experiment", "sources"] {
            assert_eq!(again[key], first[key], "{key}");
        }
        let told = |report: &Value| {
            let cells = report["cells"].as_array().unwrap();
            let told = cells
                .iter()
                .map(|c| json!([c["index"], c["scene_set"], c["params"]]));
            told.collect::<Vec<_>>()
        };
        assert_eq!(told(&again), told(&first));
    }
}

#[test]
fn a_report_whose_files_are_others_is_refused_with_their_names() {
    let folder = varied();
    assert!(batch(folder.path()).status.success());
    let again = || run(folder.path(), &["out", "--out", "again", "--quiet"]);
    let volume = folder.path().join("cube.npy");
    let whole = std::fs::read(&volume).unwrap();
    write_volume(folder.path(), 2.0);
    refused(
        &again(),
        &["out/report.json", "`../cube.npy` has another content"],
    );
    std::fs::write(&volume, &whole[1..]).unwrap();
    refused(&again(), &["`../cube.npy` has", "bytes"]);
    std::fs::remove_file(&volume).unwrap();
    refused(
        &again(),
        &["`../cube.npy` is not there", "beside the report"],
    );
    assert!(!folder.path().join("again").exists(), "nothing was begun");
    std::fs::write(folder.path().join("out/cube.npy"), &whole).unwrap();
    let output = again();
    assert!(output.status.success(), "{}", stderr(&output));
    let (first, second) = (report(folder.path()), report_in(folder.path(), "again"));
    assert_eq!(ids(&first), ids(&second));
}

#[test]
fn a_report_that_cannot_be_measured_again_says_why() {
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(60));
    assert!(batch(folder.path()).status.success());
    let path = folder.path().join("out/report.json");
    refused(
        &run(folder.path(), &["out"]),
        &["folder of its own", "--out"],
    );
    for out in ["out", "./out"] {
        refused(
            &run(folder.path(), &["out/report.json", "--out", out]),
            &["--out"],
        );
    }
    let whole = report(folder.path());
    let edited = |edit: &dyn Fn(&mut Value), words: &[&str]| {
        let mut value = whole.clone();
        edit(&mut value);
        std::fs::write(&path, value.to_string()).unwrap();
        refused(&run(folder.path(), &["out", "--out", "again"]), words);
    };
    let old = |report: &mut Value| {
        let members = report.as_object_mut().unwrap();
        members.retain(|key, _| !["scenes", "inputs", "sources"].contains(&key.as_str()));
        let cells = report["cells"].as_array_mut().unwrap();
        cells
            .iter_mut()
            .for_each(|c| drop(c.as_object_mut().unwrap().remove("scene_id")));
    };
    edited(&old, &["does not hold its scenes", "experiment file"]);
    let rebuilt = occlab(folder.path())
        .args(["report", "out"])
        .output()
        .unwrap();
    assert!(
        rebuilt.status.success(),
        "a report of an earlier version is shown"
    );
    edited(
        &|r| r["cells"][0]["image"]["width"] = json!(5),
        &["somebody edited it"],
    );
    edited(
        &|r| r["scenes"][0]["scene"]["camera"]["fov"] = json!(3),
        &["report.json:", "fov"],
    );
    edited(&|r| r["cells"][0]["method"] = json!("bms"), &["bms", "bsm"]);
    assert!(!folder.path().join("again").exists());
}

#[test]
fn a_folder_measured_by_other_sources_is_refused() {
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(60));
    assert!(batch(folder.path()).status.success());
    let kept = modified(cells(folder.path()));
    let path: PathBuf = folder.path().join("out/batch.json");
    let mut state: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    state["sources"] = json!("0123456789abcdef");
    state["environment"]["commit"] = json!("occlab 0.0.1 (c0ffee)");
    std::fs::write(&path, state.to_string()).unwrap();
    let words = [
        "occlab 0.0.1 (c0ffee)",
        "0123456789ab",
        "this program is occlab",
        "--out",
    ];
    refused(&batch(folder.path()), &words);
    let paths = kept.iter().map(|(path, _)| path.clone());
    assert_eq!(modified(paths), kept);
}
