//! Damaged `report.json` files.

use super::damage::{cases, changed, changes, damaged, edits, json, text};
use super::is_one_paragraph;
use occlab::batch::record::Report;
use occlab::batch::{BatchPlan, planned_cell};
use occlab::config::{describe, expand, parse_experiment};
use occlab::reconstruct::Registry;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A report of four cells, the last of which failed.
pub fn report() -> Value {
    serde_json::from_str(include_str!("report.json")).unwrap()
}

/// Every file below `folder`, relative to it.
pub fn files(folder: &Path) -> BTreeSet<PathBuf> {
    fn walk(folder: &Path, root: &Path, out: &mut BTreeSet<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => walk(&path, root, out),
                false => drop(out.insert(path.strip_prefix(root).unwrap().to_owned())),
            }
        }
    }
    let mut out = BTreeSet::new();
    walk(folder, folder, &mut out);
    out
}

/// A record becomes a page, tables and charts inside its folder, or is refused.
pub fn holds(bytes: &[u8]) {
    let outside = tempfile::tempdir().unwrap();
    let folder = outside.path().join("report");
    std::fs::create_dir(&folder).unwrap();
    let path = folder.join("report.json");
    std::fs::write(&path, bytes).unwrap();
    match Report::read(&path) {
        Err(error) => assert!(is_one_paragraph(&error.to_string(), &path), "{error}"),
        Ok(report) => {
            occlab::report::write(&folder, &report).unwrap();
            let known = ["index.html", "report.json", "cells.csv"];
            for file in files(outside.path()) {
                let inside = file
                    .strip_prefix("report")
                    .unwrap_or_else(|_| panic!("{} is outside", file.display()));
                let name = inside.to_str().unwrap();
                let chart = name.strip_prefix("charts/").is_some_and(|n| {
                    n.ends_with(".svg")
                        && n.chars()
                            .all(|c| c.is_ascii_alphanumeric() || "-.".contains(c))
                });
                assert!(known.contains(&name) || chart, "{name}");
            }
            Report::read(&path).unwrap();
            is_inert(&std::fs::read_to_string(folder.join("index.html")).unwrap());
        }
    }
}

/// The page contains its own script, loads nothing from outside, and has no markup from the record.
pub fn is_inert(html: &str) {
    assert_eq!(html.matches("<script").count(), 1, "a name became a script");
    for bad in [
        "<b>",
        "onerror=\"",
        "href=\"javascript",
        "href=\"..",
        "href=\"/",
        "src=\"/",
        "src=\"..",
        "src=\"http",
        "href=\"http",
    ] {
        assert!(!html.contains(bad), "the page contains {bad}");
    }
}

/// Experiment of a slab and a volume, and the report of it.
fn measured() -> (Value, Value) {
    let scene = |name: &str, density: Value| {
        json!({
            "name": name,
            "container": {"box": {"min_m": [0, 0, 0], "max_m": [1000, 1000, 1000]}},
            "density": density,
            "medium": {"extinction_per_m": 0.005},
            "sun": {"elevation_deg": 60, "azimuth_deg": 30, "irradiance": [1, 1, 1]},
            "camera": {"position_m": [500, 500, -2500], "target_m": [500, 500, 500], "fov_y_deg": 30}
        })
    };
    let scenes = [
        scene("slab", json!({"uniform": {"value": 1}})),
        scene(
            "cube",
            json!({"volume": {"path": "cube.npy", "up_axis": 1}}),
        ),
    ];
    let experiment = json!({
        "name": "small", "image": [{"width": 24, "height": 16}, {"width": 12, "height": 8}], "runs": 3,
        "scenes": scenes.clone().map(|scene| json!({"scene": scene})),
        "methods": [{"method": "srm", "steps": [4, 8]}, "none"], "reconstruct": ["full", "temporal_2x2"],
        "ghosting": "pan"
    });
    let mut report = report();
    let mut cells = Vec::new();
    for view in matrix(&experiment).views {
        for spec in &view.cells {
            let mut cell = json!(planned_cell(&view, spec));
            cell["scene_id"] = json!(view.scene.name);
            cells.push(cell);
        }
    }
    report["experiment"] = experiment.clone();
    report["scenes"] = json!(scenes.map(|scene| json!({"id": scene["name"], "scene": scene})));
    let hash = blake3::hash(b"x").to_hex().to_string();
    report["inputs"] = json!([{"path": "cube.npy", "bytes": 1, "blake3": hash}]);
    report["cells"] = json!(cells);
    (experiment, report)
}

fn matrix(experiment: &Value) -> occlab::config::Matrix {
    let experiment = parse_experiment(Path::new("e.json"), experiment.to_string()).unwrap();
    expand(&experiment, &Registry).unwrap()
}

/// What is planned from a report with its volume beside it.
fn plan(report: &Value) -> Result<BatchPlan, (occlab::Error, PathBuf)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.json");
    std::fs::write(folder.path().join("cube.npy"), "x").unwrap();
    std::fs::write(&path, report.to_string()).unwrap();
    BatchPlan::of_report(&path).map_err(|error| (error, path))
}

#[test]
fn a_report_plans_the_matrix_of_its_experiment() {
    let (experiment, mut report) = measured();
    let planned = plan(&report).unwrap_or_else(|(error, _)| panic!("{error}"));
    assert_eq!(describe(planned.matrix()), describe(&matrix(&experiment)));
    report["cells"].as_array_mut().unwrap().pop();
    let (error, _) = plan(&report).unwrap_err();
    assert!(error.to_string().contains("edited"), "{error}");
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_changed_report_is_planned_or_refused(changes in changes()) {
        let report = changed(measured().1, &changes);
        if let Err((error, path)) = plan(&report) {
            prop_assert!(is_one_paragraph(&error.to_string(), &path), "{error}");
        }
    }

    #[test]
    fn any_json_as_records(value in json()) {
        holds(value.to_string().as_bytes());
    }

    #[test]
    fn changed_records(changes in changes()) {
        holds(changed(report(), &changes).to_string().as_bytes());
    }

    #[test]
    fn damaged_records(edits in edits()) {
        let text = serde_json::to_vec_pretty(&report()).unwrap();
        holds(&damaged(&text, &edits, usize::MAX));
    }

    /// Names that people, or attackers, choose.
    #[test]
    fn any_names(scene in text(), method in text(), key in text(), value in json(), adapter in text(), file in text()) {
        let mut report = report();
        report["environment"]["adapter"] = json!(adapter);
        report["experiment"]["name"] = json!(file);
        for cell in report["cells"].as_array_mut().unwrap() {
            cell["scene"] = json!(scene);
            cell["method"] = json!(method);
            cell["scene_set"][key.as_str()] = value.clone();
            cell["params"][key.as_str()] = value.clone();
            if cell["result"].is_object() {
                cell["result"]["files"]["png"] = json!(file);
            }
        }
        report["cells"][1]["scene"] = json!("other");
        holds(report.to_string().as_bytes());
    }
}

#[test]
fn the_report_used_here_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.json");
    std::fs::write(&path, report().to_string()).unwrap();
    let read = Report::read(&path).unwrap();
    assert_eq!(read.cells.len(), 4);
    occlab::report::write(folder.path(), &read).unwrap();
    assert!(files(folder.path()).len() > 5, "charts are drawn");
}
