//! Stability sweep: stable forms hold where published ones fail. All but one test run on the oracle alone.

#[macro_use]
mod common;

use common::{box_scene, has_map, on_gpu, setup, size};
use occlab::config::{Stability, load_stability, parse_stability};
use occlab::occlusion::{Methods, REGISTRY};
use occlab::oracle::{Options, Oracle};
use occlab::progress::unwatched;
use occlab::scene::Density;
use occlab::stability::{FormVerdict, Profile, Sweep, SweepEvent, run, thresholds};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::Path;

const CONFIG: &str = "configs/stability.json";

fn shipped(folder: &Path) -> Stability {
    load_stability(Path::new(CONFIG), folder, &Methods).unwrap()
}

/// Runs on the oracle; also returns how many cases were found, and how many were measured.
fn on_oracle(stability: &Stability, folder: &Path) -> (Sweep, usize, usize) {
    let (mut found, mut measured) = (0, 0);
    let sweep = run(stability, Profile::Quick, None, folder, &mut |event| {
        match event {
            SweepEvent::Planned { done, .. } => found = done,
            SweepEvent::Case(_) => measured += 1,
            SweepEvent::Begins(_) => {}
        }
        ControlFlow::Continue(())
    });
    (sweep.unwrap(), found, measured)
}

#[test]
fn published_forms_end_where_predicted() {
    let folder = tempfile::tempdir().unwrap();
    let all = thresholds(None, folder.path()).unwrap();
    assert!(all.len() >= 14);
    for t in &all {
        println!("{t:?}");
        match (t.predicted, t.measured) {
            (Some(predicted), Some(measured)) => {
                let tolerance = 1e-5 * predicted.abs().max(1e-8);
                assert!((measured - predicted).abs() <= tolerance, "{t:?}");
            }
            (None, None) => assert!(t.form.ends_with("stable"), "{t:?}"),
            _ => panic!("{t:?}"),
        }
    }
}

/// Every extreme but those that calibrate procedural clouds, which take seconds each.
#[test]
fn stable_forms_hold_at_every_extreme() {
    let folder = tempfile::tempdir().unwrap();
    let mut stability = shipped(folder.path());
    stability.extremes.retain(|extreme| {
        let scene = extreme.scene.as_ref();
        !scene.is_ok_and(|scene| matches!(scene.density, Density::Procedural(_)))
    });
    let (sweep, _, measured) = on_oracle(&stability, folder.path());
    assert_eq!(sweep.cases.len(), measured);
    for (case, row) in sweep.defects() {
        println!("{} {}: {row:?}", case.group, case.name);
    }
    assert!(sweep.defects().is_empty());
    let refused = sweep.cases.iter().filter(|case| case.refused.is_some());
    assert_eq!(refused.count(), 2, "|g| > 0.999");
    // Negative control: a form that is kept to show where it fails does fail.
    let broken = |group: &str, name: &str, method: &str, storage: &str| {
        let case = sweep
            .cases
            .iter()
            .find(|c| c.group == group && c.name == name)
            .unwrap();
        let rows = case.rows.iter().filter(|row| {
            let s = &row.setting;
            s.method == method && s.storage == storage && s.form == "published"
        });
        rows.filter(|row| row.oracle().verdict == FormVerdict::Breaks)
            .count()
    };
    assert_eq!(broken("ESM c·z", "104", "esm", "f32"), 3);
    assert_eq!(broken("ESM c·z", "11.09", "esm", "f32"), 0);
    assert_eq!(broken("ESM c·z", "16", "esm", "f16"), 3);
    let steps = "τ of a step";
    assert_eq!(broken(steps, "17.4", "fom", "f32"), 3);
    assert_eq!(broken(steps, "16.5", "fom", "f32"), 0);
}

#[test]
fn a_sweep_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let mut stability = shipped(folder.path());
    stability.extremes.truncate(3);
    let (first, found, measured) = on_oracle(&stability, folder.path());
    assert_eq!((found, measured), (0, 3));
    let (again, found, measured) = on_oracle(&stability, folder.path());
    assert_eq!((found, measured), (3, 0));
    assert_eq!(json!(first.cases), json!(again.cases));
    let record = |i: usize| {
        let name = format!("records/{}.json", first.cases[i].id);
        folder.path().join(name)
    };
    std::fs::remove_file(record(0)).unwrap();
    std::fs::write(record(1), "{\"id\": \"half").unwrap();
    let (_, found, measured) = on_oracle(&stability, folder.path());
    assert_eq!((found, measured), (1, 2));
    // Another extreme gives another record.
    stability.extremes[2].image = size(3, 3);
    let (_, found, measured) = on_oracle(&stability, folder.path());
    assert_eq!((found, measured), (2, 1));
}

#[test]
fn a_page_is_whole_and_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let mut stability = shipped(folder.path());
    stability.extremes.truncate(6);
    stability.extremes[0].group = "<script>alert(1)</script>".to_owned();
    let (sweep, ..) = on_oracle(&stability, folder.path());
    let page = occlab::report::write_stability(folder.path(), &sweep).unwrap();
    let text = std::fs::read_to_string(page).unwrap();
    assert!(!text.contains("<script") && text.contains("&lt;script&gt;"));
    assert!(text.contains("esm published f16 nearest") && text.contains("<svg"));
    assert!(!text.contains("http://") || text.contains("http://www.w3.org"));
}

#[test]
fn faults_of_the_file_are_located() {
    type Edit = fn(&mut Value);
    let cases: [(Edit, &[&str]); 9] = [
        (|v| v["extremes"] = json!([]), &["/extremes", "empty"]),
        (
            |v| v["extremes"][1]["scene"] = json!("bax"),
            &["/extremes/1/scene", "`box`"],
        ),
        (
            |v| v["extremes"][1]["stes"] = json!({}),
            &["/extremes/1", "stes"],
        ),
        (
            |v| v["extremes"][1]["params"] = json!({"resolutoin": 3}),
            &["/extremes/1/params", "`resolution`"],
        ),
        (
            |v| v["extremes"][1]["params"] = json!({"resolution": 0}),
            &["/extremes/1/params/resolution", "1…65536"],
        ),
        (
            |v| v["extremes"][1]["set"] = json!({"/medium/phase/0/g": 1.5}),
            &["/extremes/1/set", "0.999"],
        ),
        (
            |v| v["extremes"][1]["refused"] = json!(true),
            &["/extremes/1/refused", "valid"],
        ),
        (
            |v| v["volumes"]["spike"]["fill"][0]["to"] = json!([99, 1, 1]),
            &["/volumes/spike/fill/0"],
        ),
        (
            |v| v["volumes"]["../spike"] = v["volumes"]["spike"].clone(),
            &["/volumes/", "cannot name a file"],
        ),
    ];
    let text = std::fs::read_to_string(CONFIG).unwrap();
    for (edit, words) in cases {
        let mut value: Value = serde_json::from_str(&text).unwrap();
        edit(&mut value);
        let text = serde_json::to_string_pretty(&value).unwrap();
        let parsed = parse_stability(Path::new("s.json"), text, Path::new("."), &Methods);
        let message = parsed.unwrap_err().to_string();
        assert!(message.starts_with("s.json:"), "{message}");
        for word in words {
            assert!(message.contains(word), "{message} lacks {word}");
        }
    }
}

/// A map of few texels still covers what is seen: no look-up falls outside.
#[test]
fn maps_of_few_texels_cover_the_view() {
    let scene = box_scene([-700.0, 0.0, -300.0], [500.0, 600.0, 900.0], 0.003);
    let mut scene = scene;
    scene.sun.elevation_deg = 40.0;
    let oracle = Oracle::new(&scene, size(12, 8)).unwrap();
    for resolution in [1, 2, 3, 4, 5, 8] {
        let setup = setup("esm", &format!("resolution={resolution}"));
        let occlusion = oracle.prepare(&setup, Options::default()).unwrap();
        let (_, counts) = occlusion.render(&mut unwatched).unwrap();
        assert!(counts.look_ups > 0);
        assert_eq!(counts.fallbacks, 0, "{resolution} texels");
    }
}

/// A view that sees nothing of the layer has L_max = 0: fronts must not be stored as 0/0.
#[test]
fn a_map_of_nothing_is_stored_finite() {
    needs_adapter!();
    let mut scene = box_scene([0.0; 3], [800.0; 3], 0.01);
    scene.camera.target_m = [400.0, 400.0, -9e3];
    let scenes = [scene];
    let stored = on_gpu(move |renderer| {
        let view = renderer.view(&scenes[0], size(8, 8)).unwrap();
        let maps = REGISTRY
            .iter()
            .map(|m| m.info().id)
            .filter(|id| has_map(id));
        let stored = maps.map(|id| {
            let setup = setup(id, "resolution=8 storage=f32 steps=16");
            let prepared = renderer.prepare_full(&view, &setup).unwrap();
            prepared.run(&renderer.gpu, &mut unwatched).unwrap();
            let texels = prepared.map_texels(&renderer.gpu).unwrap();
            (id, texels.expect("a map").nonfinite())
        });
        stored.collect::<Vec<_>>()
    });
    assert!(
        stored.len() >= 4 && stored.iter().all(|(_, n)| *n == 0),
        "{stored:?}"
    );
}
