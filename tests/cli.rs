//! The program as a user meets it: errors that name file, place and remedy with exit code 2, a batch that survives a
//! kill, a failed cell that does not take the others with it.

#[macro_use]
mod common;
#[path = "cli/diff.rs"]
mod diff;
#[path = "common/program.rs"]
mod program;

use program::{
    batch, cells, experiment, modified, occlab, refused, report, stderr, without_adapter, workplace,
};
use serde_json::{Value, json};
use std::process::Stdio;
use std::time::{Duration, Instant};

#[test]
fn bad_configurations_are_one_paragraph_with_place_and_remedy() {
    type Edit = fn(&mut Value, &mut Value);
    let cases: [(Edit, &[&str]); 8] = [
        (
            |_, e| e["methods"][0]["step"] = json!(3),
            &["small.json:", "step"],
        ),
        (
            |_, e| e["methods"][0]["steps"] = json!("many"),
            &["small.json:", "1…1000"],
        ),
        (
            |_, e| e["methods"][0]["steps"] = json!([]),
            &["small.json:", "steps"],
        ),
        (
            |_, e| e["methods"][0]["method"] = json!("bms"),
            &["small.json:", "bsm"],
        ),
        (
            |_, e| e["image"]["width"] = json!(0),
            &["small.json:", "width"],
        ),
        (
            |_, e| e["sun_elevation_deg"] = json!([-3]),
            &["small.json:", "horizon"],
        ),
        (|s, _| s["camera"]["fov"] = json!(3), &["slab.json:", "fov"]),
        (
            |s, _| s["density"] = json!({"volume": {"path": "absent.npy", "up_axis": 1}}),
            &["absent.npy"],
        ),
    ];
    for (edit, words) in cases {
        let folder = workplace(edit);
        refused(&batch(folder.path()), words);
        assert!(cells(folder.path()).is_empty());
    }
}

#[test]
fn a_killed_batch_resumes_and_repeats_nothing() {
    needs_adapter!();
    let folder = workplace(|_, e| e["runs"] = json!(40));
    let mut child = occlab(folder.path())
        .args(["batch", "small.json", "--out", "out", "--quiet"])
        .spawn()
        .unwrap();
    let start = Instant::now();
    while cells(folder.path()).is_empty() && child.try_wait().unwrap().is_none() {
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "no cell was recorded"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = modified(cells(folder.path()));
    assert!(!before.is_empty());
    assert!(
        !folder.path().join("out/index.html").exists(),
        "the batch was over before it could be killed"
    );

    let second = batch(folder.path());
    assert!(second.status.success(), "{}", stderr(&second));
    let kept = before.iter().map(|(path, _)| path.clone());
    assert_eq!(modified(kept), before, "cells were measured again");
    let report = report(folder.path());
    let found = report["cells"].as_array().unwrap();
    assert_eq!(found.len(), 9);
    assert!(
        found
            .iter()
            .all(|c| c["result"]["time_ms"]["wall"]["n"] == 40)
    );
    let last_line = String::from_utf8_lossy(&second.stdout).trim().to_owned();
    assert!(last_line.ends_with("index.html"), "{last_line}");

    let rebuilt = occlab(folder.path())
        .args(["report", "out"])
        .output()
        .unwrap();
    assert!(rebuilt.status.success(), "{}", stderr(&rebuilt));
}

#[test]
fn a_cell_beyond_the_adapter_is_recorded_and_the_rest_goes_on() {
    needs_adapter!();
    let folder = workplace(|_, e| {
        e["sun_elevation_deg"] = json!(60);
        e["methods"][1]["resolution"] = json!([16, 65536]);
    });
    let output = batch(folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let report = report(folder.path());
    let found = report["cells"].as_array().unwrap();
    assert_eq!(found.len(), 4, "no cell is dropped");
    let failed: Vec<_> = found.iter().filter_map(|c| c["failed"].as_str()).collect();
    assert_eq!(failed.len(), 1);
    assert!(
        failed[0].contains("65536") && failed[0].contains("limit"),
        "{}",
        failed[0]
    );
}

#[test]
fn a_folder_of_another_experiment_is_refused_and_kept() {
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(60));
    assert!(batch(folder.path()).status.success());
    let kept = cells(folder.path()).len();
    let mut other = experiment();
    other["runs"] = json!(3);
    std::fs::write(folder.path().join("small.json"), other.to_string()).unwrap();
    refused(&batch(folder.path()), &["another experiment", "--out"]);
    assert_eq!(cells(folder.path()).len(), kept);
}

#[test]
fn a_volume_deleted_or_cut_between_two_runs_is_an_error_that_loses_nothing() {
    let folder = workplace(|s, e| {
        s["density"] = json!({"volume": {"path": "v.npy", "up_axis": 1}});
        e["sun_elevation_deg"] = json!([60]);
    });
    let volume = folder.path().join("v.npy");
    let header = "{'descr': '>u2', 'fortran_order': True, 'shape': (2, 2, 2), }\n";
    let mut whole = b"\x93NUMPY\x01\x00".to_vec();
    whole.extend((header.len() as u16).to_le_bytes());
    whole.extend(header.as_bytes());
    whole.extend([0, 1].repeat(8));
    let run = || {
        let mut command = occlab(folder.path());
        command.args(["batch", "small.json", "--out", "out", "--quiet"]);
        command.args(["--backend", "cpu"]).output().unwrap()
    };
    std::fs::write(&volume, &whole).unwrap();
    let first = run();
    assert!(first.status.success(), "{}", stderr(&first));
    let lost = cells(folder.path()).remove(0);
    std::fs::remove_file(&lost).unwrap();
    let kept = modified(cells(folder.path()));
    assert_eq!(kept.len(), 2);

    std::fs::remove_file(&volume).unwrap();
    refused(&run(), &["v.npy", "cannot read"]);
    std::fs::write(&volume, &whole[..whole.len() - 3]).unwrap();
    refused(
        &run(),
        &["v.npy", "announces 16 bytes", "only 13", "truncated"],
    );
    assert_eq!(modified(cells(folder.path())), kept);

    std::fs::write(&volume, &whole).unwrap();
    let last = run();
    assert!(last.status.success(), "{}", stderr(&last));
    assert!(lost.exists(), "the missing cell was measured");
    let paths = kept.iter().map(|(path, _)| path.clone());
    assert_eq!(modified(paths), kept, "finished cells were measured again");
}

#[test]
fn a_value_of_the_command_line_is_answered_by_the_name_of_its_option() {
    let folder =
        workplace(|s, _| s["density"] = json!({"volume": {"path": "v.npy", "up_axis": 1}}));
    let render = |arguments: &[&str]| {
        let render = ["render", "--scene", "slab.json", "-o", "a.png"];
        let mut command = occlab(folder.path());
        command.args(render).args(arguments).output().unwrap()
    };
    let long = "x".repeat(5000);
    let cases: [(&[&str], &[&str]); 5] = [
        (
            &["--sun-elevation=-3"],
            &["error: --sun-elevation: ", "above the horizon"],
        ),
        (&["--volume", &long], &["error: --volume: ", "4096"]),
        (&["-m", "smr"], &["error: --method: ", "`smr`", "srm"]),
        (
            &["-m", "srm", "--set", "steps=0"],
            &["error: --set steps=0: ", "1…1000"],
        ),
        (
            &["-m", "srm", "--set", "stops=3"],
            &["error: --set stops=3: "],
        ),
    ];
    for (arguments, words) in cases {
        let output = render(arguments);
        refused(&output, words);
        assert!(!stderr(&output).contains("slab.json"), "{words:?}");
    }
    // The note comes before the error that the volume is absent; the order of the parameters does not matter.
    let idle = render(&["-m", "srm", "--set", "reach_m=300", "spacing=uniform"]);
    let note = "note: `reach_m` has no effect: it applies where spacing = uniform_reach";
    assert!(stderr(&idle).contains(note), "{}", stderr(&idle));
    let used = render(&["-m", "srm", "--set", "reach_m=300", "spacing=uniform_reach"]);
    assert!(!stderr(&used).contains("note:"), "{}", stderr(&used));
    let broken = workplace(|s, _| s["sun"]["elevation_deg"] = json!(-3));
    let output = occlab(broken.path())
        .args(["render", "--scene", "slab.json", "-o", "a.png"])
        .args(["--sun-elevation", "30"])
        .output();
    refused(&output.unwrap(), &["slab.json:", "/sun/elevation_deg"]);
}

#[test]
fn lists_are_complete() {
    let folder = tempfile::tempdir().unwrap();
    let output = occlab(folder.path())
        .args(["methods", "--json"])
        .output()
        .unwrap();
    let methods: Value = serde_json::from_slice(&output.stdout).unwrap();
    let ids: Vec<_> = methods
        .as_array()
        .unwrap()
        .iter()
        .map(|m| m["id"].as_str().unwrap())
        .collect();
    assert_eq!(
        ids,
        occlab::occlusion::REGISTRY
            .iter()
            .map(|m| m.info().id)
            .collect::<Vec<_>>()
    );
    let output = occlab(folder.path()).arg("schema").output().unwrap();
    assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
}

#[test]
fn the_readmes_table_of_methods_is_the_programs() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["methods", "--markdown"];
    let output = occlab(folder.path()).args(arguments).output().unwrap();
    let table = String::from_utf8(output.stdout).unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| `"));
    assert_eq!(rows.count(), occlab::occlusion::REGISTRY.len());
    let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    let readme = std::fs::read_to_string(readme).unwrap();
    assert!(
        readme.contains(&format!("-->\n{table}\n")),
        "put this into README.md:\n{table}"
    );
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = occlab(folder.path())
        .arg("schema")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty());
}

#[test]
fn without_an_adapter_the_error_names_the_package_to_install() {
    let folder = workplace(|_, _| {});
    let output = without_adapter(&mut occlab(folder.path()))
        .args(["batch", "small.json", "--out", "out", "--backend", "gpu"])
        .output()
        .unwrap();
    refused(&output, &["no Vulkan", "mesa-vulkan-drivers"]);
}

#[cfg(all(feature = "ui", target_os = "linux"))]
#[test]
fn without_a_display_the_window_says_how_to_go_on() {
    let folder = workplace(|_, _| {});
    for arguments in [&["view", "slab.json"][..], &[]] {
        let mut command = occlab(folder.path());
        for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(name);
        }
        let output = command.args(arguments).output().unwrap();
        refused(&output, &["no display", "occlab render", "occlab batch"]);
        assert_eq!(stderr(&output).trim_end().lines().count(), 1);
        assert!(output.stdout.is_empty());
    }
}
