//! `report.json`.

use super::damage::{changed, changes, damaged, edits, json, text};
use super::{cases, is_one_paragraph};
use occlab::batch::record::{Report, SCHEMA};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A report of three cells: measured, measured, failed.
pub fn report() -> Value {
    let stats = |v: f64| json!({"median": v, "min": v * 0.9, "p95": v * 1.2, "cv": 0.02, "n": 3});
    let measured = |v: f64, map: u64| {
        json!({
            "reference": "t", "cloud_pixel_fraction": 0.4, "fallback_fraction": 0.01,
            "memory": {"payload_bytes": map, "map_bytes": map, "allocator_bytes": null},
            "time_ms": {"generate": stats(v), "march": stats(10.0 * v), "total": stats(11.0 * v), "wall": stats(12.0 * v)},
            "rounds_total_ms": [11.0, 12.0],
            "samples": {"view": 100, "light": 200, "map": map},
            "error": {
                "rel_rmse": v, "bias": -v, "leak": v, "darken": -v, "p99_abs": v, "max_abs": v, "transmittance_rmse": v,
                "floor_rel_rmse": 0.01, "flicker": null, "flicker_sun": 0.2, "flip_mean": 0.1, "flip_p99": 0.2,
                "psnr_db": 30.0, "ssim": 0.9, "nonfinite": 0
            },
            "notes": [],
            "files": {"exr": "images/a.exr", "png": "images/a.png", "diff_png": "images/a-diff.png", "diff_scale": 1.0}
        })
    };
    let cell = |index: usize, method: &str, params: Value, rest: Value| {
        let mut cell = json!({
            "id": format!("c{index}"), "index": index, "scene": "slab", "scene_set": {"/march/steps": 64},
            "sun_elevation_deg": 60.0, "method": method, "params": params, "backend": "Vulkan Cpu",
            "image": {"width": 24, "height": 16}
        });
        cell.as_object_mut()
            .unwrap()
            .extend(rest.as_object().unwrap().clone());
        cell
    };
    json!({
        "schema": SCHEMA,
        "environment": {
            "adapter": "llvmpipe", "driver": "Mesa", "backend": "Vulkan", "device_type": "Cpu", "commit": "0.1.0",
            "host": "linux"
        },
        "experiment": {"name": "small"},
        "cells": [
            cell(0, "srm", json!({"steps": 6}), json!({"result": measured(0.3, 0)})),
            cell(1, "srm", json!({"steps": 10}), json!({"result": measured(0.1, 0)})),
            cell(2, "bsm", json!({"resolution": 64}), json!({"result": measured(0.2, 4096)})),
            cell(3, "bsm", json!({"resolution": 99}), json!({"failed": "adapter: too large"})),
        ],
        "references": [{
            "id": "t", "scene": "slab", "sun_elevation_deg": 60.0, "image": {"width": 24, "height": 16},
            "march_ms": 100.0, "light_samples": 1000, "view_samples": 100, "cached": false, "view_steps": 64,
            "view_step_rel_rmse": 0.01, "tracks": [{"track": "pan", "frames": 16, "step_deg": 0.1}],
            "files": {"png": "images/t.png"}
        }],
        "claims": [],
        "wall": {"total_s": 1.0, "passes_s": 0.5, "compile_s": 0.2}
    })
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

/// What a record says becomes a page, tables and charts inside its folder, or is refused.
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

/// The page has its own script and nothing that asks for anything outside or came in as markup.
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

proptest! {
    #![proptest_config(cases())]

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
