//! A study from its file to its pages: what it decides, what it leaves open, that it resumes, and that a wrong file is
//! refused with its place.

#[macro_use]
mod common;
#[path = "common/program.rs"]
mod program;

use program::{modified, occlab, refused, stderr, workplace};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

fn pick(experiment: &str, series: &str, at: Value) -> Value {
    json!({"experiment": experiment, "series": series, "at": at})
}

fn bytes(experiment: &str, series: &str) -> Value {
    json!({"metric": "payload_bytes", "of": pick(experiment, series, json!({"resolution": 16}))})
}

fn study() -> Value {
    let ratio = |limits: [f64; 2]| json!({"says": "three times", "test": {"ratio": {"of": bytes("maps", "bsm"), "to": bytes("maps", "esm"), "between": limits}}});
    let gain = json!({"says": "no gain", "test": {"gain": {"metric": "rel_rmse", "of": pick("steps", "srm", json!({})), "along": "steps", "from": 4, "to": 8, "at_most": 1}}});
    let failed = json!({"says": "too large", "test": {"range": {"of": {"metric": "map_bytes", "of": pick("maps", "esm", json!({"resolution": 65536}))}, "between": [0, null]}}});
    let claim = |id: &str, check: Value| json!({"id": id, "place": "nowhere", "says": "It is so.", "checks": [check]});
    json!({
        "name": "tiny", "title": "A tiny study <&>", "source": "nobody",
        "profiles": {
            "quick": {"about": "Small.", "values": {"image": {"width": 24, "height": 16}, "runs": 3}},
            "full": {"about": "Larger.", "values": {"image": {"width": 48, "height": 32}, "runs": 5}}
        },
        "series": {"srm": {"method": "srm"}, "srm4": {"method": "srm", "at": {"steps": 4}}, "esm": {"method": "esm"}, "bsm": {"method": "bsm"}},
        "experiments": [
            {"id": "steps", "title": "Steps", "matrix": {"image": "$image", "runs": "$runs", "scenes": "slab.json",
                "methods": [{"method": "srm", "steps": [4, 6, 8]}]}},
            {"id": "maps", "title": "Maps", "matrix": {"image": "$image", "runs": "$runs", "scenes": "slab.json",
                "methods": [{"method": "esm", "resolution": [16, 65536], "steps": 8}, {"method": "bsm", "resolution": 16, "steps": 8}]}}
        ],
        "charts": [{"id": "time", "figure": "Figure 1", "title": "Time", "experiment": "steps", "along": "steps", "along_title": "steps", "metric": "total_ms",
            "metric_title": "ratio", "relative_to": "srm4", "series": ["srm"], "published": [{"series": "srm", "points": [[4, 2], [8, 3]], "unit": 2}], "note": "A note."}],
        "pictures": ["steps"],
        "claims": [claim("T1", ratio([2.9, 3.1])), claim("T2", ratio([4.0, 5.0])), claim("T3", failed), claim("T4", gain)],
        "errata": [{"place": "Table 1", "printed": "8 kB", "meant": "0.5 KiB", "evidence": {"number": {"published": 8, "unit": "KiB", "per": 1024, "measured": bytes("maps", "esm")}}}],
        "guide": [{"along": {"title": "By steps", "words": "error", "metric": "rel_rmse", "experiment": "steps", "along": "steps", "along_words": "steps of", "series": ["srm"]}}]
    })
}

fn workplace_of(edit: impl FnOnce(&mut Value)) -> tempfile::TempDir {
    let folder = workplace(|_, _| ());
    let mut study = study();
    edit(&mut study);
    let text = serde_json::to_string_pretty(&study).unwrap();
    std::fs::write(folder.path().join("tiny.json"), text).unwrap();
    folder
}

fn run(folder: &Path) -> Output {
    occlab(folder)
        .args(["study", "tiny.json", "--out", "out"])
        .output()
        .unwrap()
}

fn cells(folder: &Path) -> Vec<PathBuf> {
    let folders = ["steps", "maps"].map(|id| folder.join(format!("out/experiments/{id}/cells")));
    let entries = folders.iter().filter_map(|f| std::fs::read_dir(f).ok());
    let paths = entries.flatten().map(|e| e.unwrap().path());
    paths
        .filter(|p| p.extension().is_some_and(|e| e == "json"))
        .collect()
}

fn json_file(path: PathBuf) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_second_run_of_a_study_is_refused_before_it_writes_anything() {
    let folder = workplace_of(|_| ());
    let lock = folder.path().join("out/batch.lock");
    std::fs::create_dir(folder.path().join("out")).unwrap();
    let elsewhere = json!({
        "host": "renderfarm-07", "process": 4711, "since_utc": "2026-11-28 09:07:01 UTC", "token": "t",
        "started": null, "system": null
    });
    std::fs::write(&lock, elsewhere.to_string()).unwrap();
    refused(
        &run(folder.path()),
        &["another run", "renderfarm-07", "out/batch.lock"],
    );
    assert!(!folder.path().join("out/experiments").exists());
    std::fs::remove_file(&lock).unwrap();
    let output = run(folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(!lock.exists() && cells(folder.path()).len() == 6);
}

#[test]
fn a_study_decides_what_it_can_and_resumes_after_a_kill() {
    needs_adapter!();
    let folder = workplace_of(|study| study["profiles"]["quick"]["values"]["runs"] = json!(40));
    let mut child = occlab(folder.path())
        .args(["study", "tiny.json", "--out", "out", "--quiet"])
        .stderr(Stdio::null())
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

    let output = run(folder.path());
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "a cell fails: {text}");
    let kept = before.iter().map(|(path, _)| path.clone());
    assert_eq!(modified(kept), before, "cells were measured again");
    let last_line = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    assert!(last_line.ends_with("index.html"), "{last_line}");
    assert!(text.contains("100 % of the study"), "{text}");

    let out = folder.path().join("out");
    let found = json_file(out.join("study.json"));
    let verdicts: Vec<_> = found["claims"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["verdict"].as_str().unwrap())
        .collect();
    assert_eq!(verdicts, ["holds", "fails", "undecidable", "holds"]);
    assert!(
        found["claims"][2]["parts"][0]["numbers"]
            .as_str()
            .unwrap()
            .contains("65536")
    );
    assert!(
        found["errata"][0]["numbers"]
            .as_str()
            .unwrap()
            .contains("16.0 times"),
        "{}",
        found["errata"]
    );
    assert_eq!(found["failed"], 1);
    let report = json_file(out.join("experiments/maps/report.json"));
    assert_eq!(report["claims"].as_array().unwrap().len(), 3);
    assert_eq!(report["claims"][0]["verdict"], "holds");
    let page = std::fs::read_to_string(out.join("index.html")).unwrap();
    for words in [
        "A tiny study &lt;&amp;&gt;",
        "not decidable here",
        "Figure 1",
        "./guide.html",
        "#cell-0",
    ] {
        assert!(page.contains(words), "`{words}` is not on the page");
    }
    assert!(!page.contains("<&>"));
    assert!(
        std::fs::read_to_string(out.join("guide.html"))
            .unwrap()
            .contains("By steps")
    );
    assert!(out.join("charts/figure-time.svg").exists());
}

#[test]
fn wrong_study_files_are_refused_with_their_place() {
    type Edit = fn(&mut Value);
    let cases: [(Edit, &[&str]); 13] = [
        (
            |s| s["claim"] = json!([]),
            &["tiny.json:", "unknown field `claim`", "claims"],
        ),
        (
            |s| s["experiments"][0]["matrix"]["image"] = json!("$imag"),
            &["tiny.json:", "`imag`", "Did you mean `image`"],
        ),
        (
            |s| s["profiles"]["quick"]["values"]["spare"] = json!(1),
            &["tiny.json:", "nothing uses `$spare`"],
        ),
        (
            |s| s["profiles"]["quick"]["values"]["image"] = json!({"width": 0, "height": 9}),
            &[
                "(at /profiles/quick/values/image/width, used at /experiments/0/matrix/image/width)",
                "allowed is 1…8192",
            ],
        ),
        (
            |s| s["experiments"][1]["matrix"]["methods"][0]["step"] = json!(1),
            &["tiny.json:", "/experiments/1/matrix/methods/0/step"],
        ),
        (
            |s| {
                s["claims"][0]["checks"][0]["test"]["ratio"]["of"]["of"]["experiment"] =
                    json!("map")
            },
            &["tiny.json:", "there is no experiment `map`", "maps"],
        ),
        (
            |s| s["charts"][0]["series"][0] = json!("sr"),
            &["tiny.json:", "there is no series `sr`"],
        ),
        (
            |s| s["pictures"] = json!(["step"]),
            &["tiny.json:", "/pictures/0"],
        ),
        (
            |s| s["experiments"][1]["id"] = json!("../up"),
            &["tiny.json:", "cannot name a folder"],
        ),
        (
            |s| {
                let chart = json!({"id": "../up", "title": "x", "prices": "one"});
                s["cost_model"] = json!({"figure": "x", "says": "x", "charts": [chart]});
            },
            &["(at /cost_model/charts/0/id)", "cannot name a file"],
        ),
        (
            |s| s["profiles"] = json!({"slow": {"about": "x"}}),
            &[
                "error: --profile: ",
                "no profile `quick`",
                "tiny.json: slow",
            ],
        ),
        (
            |s| s["claims"][3]["checks"][0]["test"]["gain"]["metric"] = json!("rel_rms"),
            &[
                "study `tiny`, claim T4",
                "`rel_rms`",
                "Did you mean `rel_rmse`",
            ],
        ),
        (
            |s| s["series"]["srm4"]["at"]["steps"] = json!(5),
            &[
                "study `tiny`, profile quick, chart `time`",
                "no cell fits srm4",
            ],
        ),
    ];
    for (edit, words) in cases {
        let folder = workplace_of(edit);
        refused(&run(folder.path()), words);
        assert!(!folder.path().join("out").exists(), "{words:?}");
    }
}

#[test]
fn studies_are_listed_and_an_unknown_one_is_refused() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let listed = occlab(root).arg("study").output().unwrap();
    let text = String::from_utf8_lossy(&listed.stdout).into_owned();
    assert!(
        text.starts_with("m ") && text.contains("full, quick"),
        "{text}"
    );
    refused(
        &occlab(root).args(["study", "n"]).output().unwrap(),
        &["n:", "neither here nor in configs/studies", "Built in: m"],
    );
    let folder = tempfile::tempdir().unwrap();
    let studies = folder.path().join("configs/studies");
    std::fs::create_dir_all(&studies).unwrap();
    std::fs::write(studies.join("broken.json"), "{").unwrap();
    std::fs::copy(root.join("configs/studies/m.json"), studies.join("m.json")).unwrap();
    let listed = occlab(folder.path()).arg("study").output().unwrap();
    let text = String::from_utf8_lossy(&listed.stdout).into_owned();
    assert!(
        text.contains("cannot be read") && text.contains("\nm "),
        "{text}"
    );
}

#[test]
fn both_profiles_of_every_shipped_study_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/studies");
    let paths = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    for path in paths.filter(|p| p.extension().is_some_and(|e| e == "json")) {
        for profile in ["quick", "full"] {
            let study = occlab::config::load_study(&path, profile).unwrap();
            for entry in study.experiments {
                occlab::config::expand(&entry.experiment, &occlab::reconstruct::Registry).unwrap();
            }
        }
    }
}
