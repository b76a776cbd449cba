//! What a batch records of temporal cells.

use super::common;
use super::program::{batch, occlab, report, scene, stderr, workplace};
use super::sequence::{on_device, temporal};
use occlab::frame::Frame;
use occlab::scene::{CameraTrack, ImageSize, Scene};
use serde_json::{Value, json};

fn both() -> tempfile::TempDir {
    workplace(|_, e| {
        e["sun_elevation_deg"] = json!(60);
        e["reconstruct"] = json!(["full", "temporal_2x2"]);
        e["ghosting"] = json!(["pan", "dolly"]);
    })
}

/// Cells without what differs from run to run.
fn cells_of(report: &Value) -> Vec<&Value> {
    report["cells"].as_array().unwrap().iter().collect()
}

/// The records of both kinds, on the backend that `arguments` name.
fn check_records(arguments: &[&str]) {
    let folder = both();
    let mut command = occlab(folder.path());
    let output = command
        .args(["batch", "small.json", "--out", "out", "--quiet"])
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let found = report(folder.path());
    let cells = cells_of(&found);
    assert_eq!(cells.len(), 6);
    for pair in cells.chunks(2) {
        let (full, temporal) = (pair[0], pair[1]);
        assert_eq!(full.get("reconstruct"), None);
        assert_eq!(temporal["reconstruct"], json!("temporal_2x2"));
        let (full, temporal) = (&full["result"], &temporal["result"]);
        assert_eq!(full["error"], temporal["error"], "at rest it costs nothing");
        assert_eq!(full.get("reconstruction"), None);
        assert_eq!(full["time_ms"].get("reconstruct"), None);
        let timed = |pass: &str| temporal["time_ms"][pass].is_object();
        assert_eq!(timed("reconstruct"), timed("march"));
        let view = |cell: &Value| cell["samples"]["view"].as_u64().unwrap();
        assert!(
            4 * view(temporal) < view(full) + view(full) / 4
                && 3 * view(full) < 16 * view(temporal)
        );
        let map = |cell: &Value| cell["samples"]["map"].as_u64().unwrap();
        // A device fills the map in every frame; the oracle only the texels that are looked up.
        let whole = arguments == ["--backend", "gpu"];
        assert!(map(temporal) == map(full) || !whole && map(temporal) <= map(full));
        let numbers = &temporal["reconstruction"];
        assert_eq!(numbers["full_rel_rmse"], json!(0.0));
        assert_eq!(numbers["history_bytes"], json!(24 * 16 * 72));
        for (track, step, other) in [
            ("pan", "step_deg", "step_m"),
            ("dolly", "step_m", "step_deg"),
        ] {
            let ghosting = &numbers["ghosting"][track];
            assert!(ghosting[step].is_f64() && ghosting.get(other).is_none());
            let curve = ghosting["rel_rmse"].as_array().unwrap();
            assert_eq!((curve.len(), &curve[0]), (16, &json!(0.0)));
            assert!(curve[1..].iter().all(|e| e.as_f64().unwrap() > 0.0));
        }
    }
    let csv = std::fs::read_to_string(folder.path().join("out/cells.csv")).unwrap();
    let header = csv.lines().next().unwrap();
    assert!(header.contains(",reconstruct,") && header.contains("reconstruction.full_rel_rmse"));
    assert!(header.contains("reconstruction.ghosting.dolly.step_m"));
    for track in ["pan", "dolly"] {
        let chart = format!("out/charts/ghosting-{track}-1-slab-sun60.svg");
        assert!(folder.path().join(chart).is_file());
    }
}

#[test]
fn both_kinds_are_recorded_from_a_device() {
    needs_adapter!();
    check_records(&["--backend", "gpu"]);
}

#[test]
fn both_kinds_are_recorded_from_the_oracle() {
    check_records(&["--backend", "cpu"]);
}

#[test]
fn full_cells_keep_their_ids_and_an_experiment_that_names_nothing_records_nothing_of_it() {
    needs_adapter!();
    let (plain, mixed) = (workplace(|_, e| e["sun_elevation_deg"] = json!(60)), both());
    assert!(batch(plain.path()).status.success());
    assert!(batch(mixed.path()).status.success());
    let (plain_report, mixed_report) = (report(plain.path()), report(mixed.path()));
    let ids = |cells: Vec<&Value>| cells.iter().map(|c| c["id"].clone()).collect::<Vec<_>>();
    let (plain_ids, mixed_ids) = (ids(cells_of(&plain_report)), ids(cells_of(&mixed_report)));
    assert!(
        mixed_ids.iter().step_by(2).eq(&plain_ids),
        "{plain_ids:?}, {mixed_ids:?}"
    );
    let mut out = vec![plain_report.to_string()];
    for file in ["cells.csv", "index.html"] {
        out.push(std::fs::read_to_string(plain.path().join("out").join(file)).unwrap());
    }
    for text in out {
        assert!(!text.contains("reconstruct") && !text.contains("temporal"));
    }
}

#[test]
fn without_the_key_there_is_no_ghosting() {
    needs_adapter!();
    let folder = workplace(|_, e| {
        e["sun_elevation_deg"] = json!(60);
        e["reconstruct"] = json!("temporal_2x2");
    });
    assert!(batch(folder.path()).status.success());
    for cell in cells_of(&report(folder.path())) {
        let numbers = json!({"full_rel_rmse": 0.0, "history_bytes": 24 * 16 * 72});
        assert_eq!(cell["result"]["reconstruction"], numbers);
    }
    let charts = std::fs::read_dir(folder.path().join("out/charts")).unwrap();
    let mut names = charts.map(|e| e.unwrap().file_name().into_string().unwrap());
    assert!(names.all(|name| !name.starts_with("ghosting")));
}

#[test]
fn a_run_that_ended_before_a_movement_adds_it_and_repeats_nothing_else() {
    needs_adapter!();
    let folder = both();
    assert!(batch(folder.path()).status.success());
    let before = report(folder.path());
    for (cell, track) in [(1, "pan"), (3, "dolly")] {
        let id = before["cells"][cell]["id"].as_str().unwrap();
        let path = folder.path().join(format!("out/cells/{id}.json"));
        let mut record: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let curves = record["result"]["reconstruction"]["ghosting"].as_object_mut();
        curves.unwrap().remove(track).unwrap();
        std::fs::write(&path, record.to_string()).unwrap();
    }
    assert!(batch(folder.path()).status.success());
    assert_eq!(report(folder.path())["cells"], before["cells"]);
}

/// √Σ(L̂ − L)²/√ΣL² over the pixels where either opacity exceeds 0.01.
fn error_by_hand(full: &Frame, rebuilt: &Frame) -> f64 {
    let seen = |i: &usize| full.radiance[*i][3] > 0.01 || rebuilt.radiance[*i][3] > 0.01;
    let channel = |i: usize| (0..3).map(move |c| (i, c));
    let pairs = (0..full.sun.len()).filter(seen).flat_map(channel);
    common::relative_rmse(
        pairs.map(|(i, c)| (f64::from(rebuilt.sun[i][c]), f64::from(full.sun[i][c]))),
    )
}

#[test]
fn curves_and_steps_are_those_of_frames_rendered_by_hand() {
    needs_adapter!();
    let folder = both();
    assert!(batch(folder.path()).status.success());
    let found = report(folder.path());
    let cell = &found["cells"][1];
    assert_eq!(cell["params"]["steps"], json!(4));
    let ghosting = &cell["result"]["reconstruction"]["ghosting"];
    let scene: Scene = serde_json::from_value(scene()).unwrap();
    let image = ImageSize {
        width: 24,
        height: 16,
    };
    // The optical axis meets the box from 2500 to 3500 m; 16 rows see 30°.
    let pixel = 2.0 * 15.0_f64.to_radians().tan() / 16.0;
    for (track, step, expected) in [
        (CameraTrack::Pan, "step_deg", pixel.atan().to_degrees()),
        (CameraTrack::Dolly, "step_m", 3000.0 * pixel),
    ] {
        let recorded = &ghosting[track.name()];
        assert!((recorded[step].as_f64().unwrap() / expected - 1.0).abs() < 1e-12);
        let frames = [0, 0, 0].into_iter().chain(0..16);
        let scenes: Vec<Scene> = frames.map(|n| track.scene(&scene, image, n)).collect();
        let setup = common::setup("srm", "steps=4");
        let made =
            common::on_gpu(move |renderer| on_device(renderer, temporal(), &scenes, image, &setup));
        let curve = recorded["rel_rmse"].as_array().unwrap();
        for (n, value) in curve.iter().enumerate() {
            let own = error_by_hand(&made.full[n + 3], &made.rebuilt[n + 3]);
            let value = value.as_f64().unwrap();
            assert!(
                (value - own).abs() <= 1e-9 * own,
                "{track:?} {n}: {value}, {own}"
            );
        }
    }
}

#[test]
fn a_picture_without_a_block_fails_its_temporal_cells_alone() {
    needs_adapter!();
    let folder = workplace(|_, e| {
        e["sun_elevation_deg"] = json!(60);
        e["image"] = json!({"width": 1, "height": 24});
        e["methods"] = json!(["none"]);
        e["reconstruct"] = json!(["full", "temporal_2x2"]);
    });
    assert_eq!(batch(folder.path()).status.code(), Some(1));
    let found = report(folder.path());
    assert!(found["cells"][0]["result"].is_object());
    let reason = found["cells"][1]["failed"].as_str().unwrap();
    assert!(
        reason.contains("needs 2 × 2 pixels") && reason.contains("Choose a larger image"),
        "{reason}"
    );
}
