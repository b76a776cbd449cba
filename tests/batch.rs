//! Batches with a damaged cache, on a full disk and after an interruption; and numbers that are known beforehand.

#[macro_use]
mod common;
#[path = "common/program.rs"]
mod program;

use occlab::cost::Counting;
use occlab::frame::read_frame;
use occlab::progress::unwatched;
use occlab::truth::{Truth, TruthCache, on_device};
use program::{batch, cells, modified, refused, report, stderr, workplace};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn cached_truth(cache: &Path, counting: Counting) -> Truth {
    let cache = TruthCache::new(cache, u64::MAX);
    common::on_gpu(move |renderer| {
        let scene = common::box_scene([0.0; 3], [1000.0; 3], 0.003);
        let view = renderer.view(&scene, common::size(24, 16)).unwrap();
        on_device(renderer, &view, Some(&cache), counting, &mut unwatched).unwrap()
    })
}

fn with_extension(folder: &Path, extension: &str) -> PathBuf {
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    let mut found = entries.filter(|p| p.extension().is_some_and(|e| e == extension));
    found.next().unwrap()
}

fn change(path: &Path, edit: impl FnOnce(&mut Vec<u8>)) {
    let mut bytes = std::fs::read(path).unwrap();
    edit(&mut bytes);
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_damaged_truth_is_rendered_again_with_a_note_and_equals_a_fresh_one() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path();
    let fresh = cached_truth(cache, Counting::On);
    assert!(!fresh.cached && fresh.note.is_none());
    let again = cached_truth(cache, Counting::On);
    assert!(again.cached && again.note.is_none() && again.cost == fresh.cost);
    assert_eq!(again.frame, fresh.frame);

    type Damage = fn(&Path, &Path);
    let damages: [(&str, Damage); 6] = [
        ("truncated picture", |picture, _| {
            change(picture, |bytes| bytes.truncate(bytes.len() / 2));
        }),
        ("flipped byte", |picture, _| {
            change(picture, |bytes| {
                let middle = bytes.len() * 2 / 3;
                bytes[middle] ^= 1;
            });
        }),
        ("unreadable picture", |picture, _| {
            std::fs::remove_file(picture).unwrap();
            std::fs::create_dir(picture).unwrap();
        }),
        ("missing picture", |picture, _| {
            std::fs::remove_dir(picture).unwrap()
        }),
        ("empty sheet", |_, sheet| change(sheet, Vec::clear)),
        ("another time in the sheet", |_, sheet| {
            let text = std::fs::read_to_string(sheet).unwrap();
            let text = text.replacen("\"wall_ms\": ", "\"wall_ms\": 1", 1);
            std::fs::write(sheet, text).unwrap();
        }),
    ];
    let (picture, sheet) = (with_extension(cache, "exr"), with_extension(cache, "json"));
    for (name, damage) in damages {
        damage(&picture, &sheet);
        let rebuilt = cached_truth(cache, Counting::On);
        assert!(!rebuilt.cached, "{name} was trusted");
        assert!(rebuilt.note.is_some(), "{name} was not reported");
        assert_eq!(rebuilt.frame, fresh.frame, "{name}");
    }
    assert!(cached_truth(cache, Counting::On).cached);
}

#[test]
fn a_truth_without_counts_serves_only_who_does_not_want_them() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(
        cached_truth(folder.path(), Counting::Off).cost.samples,
        None
    );
    assert!(cached_truth(folder.path(), Counting::Off).cached);
    let counted = cached_truth(folder.path(), Counting::On);
    assert!(!counted.cached && counted.note.is_none());
    assert!(
        counted
            .cost
            .samples
            .is_some_and(|s| s.light > 0 && s.view > 0)
    );
}

/// One view of 24 × 16 pixels and one of 192 × 128, whose pictures exceed the limit.
fn growing() -> tempfile::TempDir {
    workplace(|_, e| {
        e["image"] = json!([{"width": 24, "height": 16}, {"width": 192, "height": 128}]);
        e["sun_elevation_deg"] = json!(60);
        e["methods"] = json!(["none", {"method": "srm", "steps": 4}]);
    })
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
    {
        if entry.is_dir() {
            found.extend(files(&entry));
        } else {
            found.push(entry);
        }
    }
    found
}

/// RLIMIT_FSIZE makes a write fail (EFBIG) in the middle of a file, as a full disk does (ENOSPC).
#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_that_loses_nothing_and_a_resumed_run_completes() {
    let folder = growing();
    let script = "trap '' XFSZ; ulimit -f 64; exec \"$0\" batch small.json --out out";
    let output = std::process::Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_occlab")])
        .current_dir(folder.path())
        .env("OCCLAB_CACHE", folder.path().join("cache"))
        .output()
        .unwrap();
    refused(
        &output,
        &[
            "out/images/truth-",
            ".exr: cannot write",
            "Free space",
            "run the same command again",
        ],
    );
    let text = stderr(&output);
    let error = text.split("error: ").nth(1).unwrap();
    assert_eq!(error.trim().lines().count(), 1, "not one paragraph: {text}");
    assert_eq!(error.matches("os error").count(), 1, "said twice: {error}");
    assert!(text.contains("note: a truth is not kept"), "{text}");

    let before = modified(cells(folder.path()));
    assert_eq!(before.len(), 2, "the cells of the first view are kept");
    for path in files(folder.path()) {
        let name = path.display().to_string();
        assert!(!name.contains(".occlab-"), "{name} was left behind");
        match path.extension().and_then(|e| e.to_str()) {
            Some("exr") => drop(read_frame(&path).unwrap()),
            Some("json") => {
                serde_json::from_slice::<Value>(&std::fs::read(&path).unwrap()).unwrap();
            }
            _ => {}
        }
    }

    let resumed = batch(folder.path());
    assert!(resumed.status.success(), "{}", stderr(&resumed));
    let kept = before.iter().map(|(path, _)| path.clone());
    assert_eq!(modified(kept), before, "cells were measured again");
    let report = report(folder.path());
    let found = report["cells"].as_array().unwrap();
    assert_eq!(found.len(), 4);
    assert!(found.iter().all(|c| c["failed"].is_null()));
}

fn moving() -> tempfile::TempDir {
    workplace(|_, e| {
        e["flicker"] = json!(["pan", "sun", "dolly"]);
        e["sun_elevation_deg"] = json!(60);
        let step_m = 3f64.sqrt();
        e["methods"] =
            json!([{"method": "truth", "step_m": step_m}, {"method": "srm", "steps": 4}, "none"]);
    })
}

fn error_of<'a>(report: &'a Value, method: &str) -> &'a Value {
    let cells = report["cells"].as_array().unwrap();
    let cell = cells.iter().find(|c| c["method"] == method).unwrap();
    &cell["result"]["error"]
}

#[test]
fn flicker_is_zero_for_the_truth_rounding_for_an_exact_method_and_real_without_shadow() {
    let folder = moving();
    let output = batch(folder.path());
    assert!(output.status.success(), "{}", stderr(&output));
    let report = report(folder.path());
    assert_eq!(error_of(&report, "truth")["rel_rmse"], json!(0.0));
    for key in [
        "flicker",
        "flicker_sun",
        "flicker_dolly",
        "rel_rmse_pan",
        "rel_rmse_sun",
        "rel_rmse_dolly",
    ] {
        let of = |method| error_of(&report, method)[key].as_f64().unwrap();
        assert_eq!(of("truth"), 0.0, "{key}");
        // In a homogeneous medium any number of steps sums to the same optical depth.
        assert!(of("srm") < 1e-4, "{key} {}", of("srm"));
        assert!(of("none") > 1e-3, "{key} {}", of("none"));
    }
    let reference = &report["references"][0];
    assert_eq!(reference["tracks"][0]["track"], json!("pan"));
    assert_eq!(reference["tracks"][1]["frames"], json!(16));
    let step_deg = reference["tracks"][1]["step_deg"].as_f64().unwrap();
    assert!((step_deg * 15.0 - 1.0).abs() < 1e-12, "{step_deg}");
    assert!(reference["tracks"][2]["step_m"].as_f64().unwrap() > 0.0);
    assert_eq!(reference["view_steps"], json!(64));
    let view_error = reference["view_step_rel_rmse"].as_f64().unwrap();
    assert!(view_error > 0.0 && view_error < 0.1, "{view_error}");
}

#[test]
fn a_run_that_ended_before_its_flicker_adds_it_and_repeats_nothing_else() {
    let folder = moving();
    assert!(batch(folder.path()).status.success());
    let before = report(folder.path());
    let all = modified(cells(folder.path()));
    let srm = all
        .iter()
        .map(|(path, _)| path)
        .find(|path| std::fs::read_to_string(path).unwrap().contains("\"srm\""))
        .unwrap();
    let mut record: Value = serde_json::from_slice(&std::fs::read(srm).unwrap()).unwrap();
    record["result"]["error"]["flicker_sun"] = Value::Null;
    std::fs::write(srm, record.to_string()).unwrap();

    assert!(batch(folder.path()).status.success());
    let others = |(path, _): &&(PathBuf, _)| path != srm;
    for (path, time) in all.iter().filter(others) {
        let now = std::fs::metadata(path).unwrap().modified().unwrap();
        assert_eq!(now, *time, "{} was measured again", path.display());
    }
    let after = report(folder.path());
    assert_eq!(
        after["cells"], before["cells"],
        "times and numbers are the old ones"
    );
    assert_eq!(after["references"], before["references"]);
}

#[test]
fn a_map_filled_over_frames_is_measured_in_motion_and_noted_at_rest() {
    let slow = |flicker: Option<&str>| {
        workplace(|_, e| {
            e["sun_elevation_deg"] = json!(60);
            if let Some(track) = flicker {
                e["flicker"] = json!(track);
            }
            e["methods"] =
                json!([{"method": "esm", "resolution": 64, "steps": 8, "fill_frames": [1, 8]}]);
        })
    };
    let aloud = |folder: &Path| {
        let run = ["batch", "small.json", "--out", "out"];
        program::occlab(folder).args(run).output().unwrap()
    };
    let rest = slow(None);
    let output = aloud(rest.path());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("Name movements in `flicker`"));

    let moving = slow(Some("sun"));
    let output = aloud(moving.path());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(!stderr(&output).contains("Name movements"));
    let report = report(moving.path());
    let of = |frames: u64| {
        let cells = report["cells"].as_array().unwrap().iter();
        let mut cells = cells.filter(|c| c["params"]["fill_frames"] == frames);
        cells.next().unwrap()["result"].clone()
    };
    let (fresh, old) = (of(1), of(8));
    assert_eq!(fresh["error"]["rel_rmse"], old["error"]["rel_rmse"]);
    assert_ne!(fresh["error"]["rel_rmse_sun"], old["error"]["rel_rmse_sun"]);
    let bytes = |cell: &Value| cell["memory"]["map_bytes"].as_u64().unwrap();
    assert_eq!(bytes(&old), 2 * bytes(&fresh));
}

#[test]
fn without_the_key_there_is_no_flicker() {
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(60));
    assert!(batch(folder.path()).status.success());
    let report = report(folder.path());
    let error = error_of(&report, "bsm");
    assert_eq!(
        (&error["flicker"], &error["flicker_sun"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(report["references"][0].get("tracks"), None);
}
