//! Damaged scene and experiment files.

use super::damage::{cases, changed, changes, damaged, edits, json, text};
use super::is_one_paragraph;
use occlab::config::{
    MAX_CELLS, MAX_FILE_BYTES, describe, expand, load_experiment, load_scene, parse_experiment,
    schema,
};
use occlab::reconstruct::Registry;
use occlab::scene::{CameraTrack, Container, ImageSize, Scene, SkyModel, Track};
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Every scene that comes with the program, as JSON.
fn scenes() -> Vec<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/scenes");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    paths.sort();
    let scenes = paths
        .iter()
        .map(|path| serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap());
    scenes.collect()
}

fn experiment() -> Value {
    json!({
        "name": "e", "image": [{"width": 16, "height": 9}, {"width": 8, "height": 8}], "runs": 3, "discard": 2,
        "scenes": ["one.json", {"scene": "one.json", "set": {"/march/steps": [4, 8], "/camera/far_m": 9e3}}],
        "sun_elevation_deg": [60, 12], "flicker": ["pan", "sun", "dolly"],
        "reconstruct": ["full", "temporal_2x2"], "ghosting": ["pan", "dolly"],
        "methods": ["none", {"method": "srm", "steps": [6, 10]}, {"method": "bsm", "resolution": 64, "mean": "fitted"}]
    })
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("one.json", scenes()[1].to_string());
        folder
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

/// A scene that was accepted satisfies its own checks, and all values derived from it are finite, on the device too.
fn is_usable(scene: &Scene) {
    assert_eq!(scene.validate(), Ok(()));
    let (right, up, forward) = scene.camera.basis();
    for axis in [right, up, forward] {
        assert!((axis.length() - 1.0).abs() < 1e-6, "{:?}", scene.camera);
    }
    let step_m = scene.truth_step_m();
    assert!(step_m > 0.0 && step_m <= 10.0);
    let longest_m = scene.container.longest_path_m();
    assert!(longest_m > 0.0 && longest_m.is_finite());
    let image = ImageSize {
        width: 16,
        height: 9,
    };
    let ghosting = CameraTrack::ALL.map(|t| t.step_deg(scene, image).or(t.step_m(scene, image)));
    let flicker = Track::ALL.map(|t| t.step_deg(scene, image).or(t.step_m(scene, image)));
    for step in ghosting.into_iter().chain(flicker.map(|s| s.map(f64::abs))) {
        assert!(
            step.is_some_and(|step| step > 0.0 && step.is_finite()),
            "{step:?}"
        );
    }
    let sun = scene.sun.direction();
    assert!((sun.length() - 1.0).abs() < 1e-12);
    if let Some(sky) = &scene.sky {
        let occlab::scene::Sky::Preetham {
            turbidity,
            ground_albedo,
        } = sky;
        let model = SkyModel::new(*turbidity, sun, *ground_albedo);
        let mut numbers = model.perez().zenith.to_vec();
        numbers.extend(model.mean_radiance());
        numbers.extend(model.sun_irradiance_klx());
        assert!(numbers.iter().all(|v| v.is_finite()), "{sky:?}");
    }
    let value = serde_json::to_value(scene).unwrap();
    no_infinite_float(&value);
    let again: Scene = serde_json::from_value(value).unwrap();
    assert_eq!(&again, scene);
    let (low_m, high_m) = scene.container.height_range_m();
    assert!(high_m > low_m);
    if let Container::Shell {
        planet_radius_m, ..
    } = scene.container
    {
        assert!(planet_radius_m >= 1e4);
    }
}

fn no_infinite_float(value: &Value) {
    match value {
        Value::Number(n) => assert!(n.as_f64().is_none_or(|v| (v as f32).is_finite()), "{n}"),
        Value::Array(list) => list.iter().for_each(no_infinite_float),
        Value::Object(map) => map.values().for_each(no_infinite_float),
        _ => {}
    }
}

fn scene_holds(folder: &Folder, text: impl AsRef<[u8]>) {
    let path = folder.write("scene.json", text);
    match load_scene(&path) {
        Ok(scene) => is_usable(&scene),
        Err(error) => assert!(is_one_paragraph(&error.to_string(), &path), "{error}"),
    }
}

fn experiment_holds(folder: &Folder, text: impl AsRef<[u8]>) {
    let path = folder.write("small.json", text);
    match load_experiment(&path).and_then(|e| expand(&e, &Registry)) {
        Ok(matrix) => {
            assert!(matrix.cell_count() <= MAX_CELLS && matrix.cell_count() > 0);
            matrix.views.iter().for_each(|view| is_usable(&view.scene));
            assert!(describe(&matrix).lines().count() > matrix.cell_count());
        }
        // The message names the experiment or a scene that it refers to, at whatever path.
        Err(error) => {
            let message = error.to_string();
            let folder = folder.0.path();
            assert!(is_one_paragraph(&message, folder), "{message}");
        }
    }
}

/// Bytes that begin like JSON.
fn almost_json() -> impl Strategy<Value = Vec<u8>> {
    let tokens = [
        "{", "}", "[", "]", ",", ":", "\"", "\\", "\"a\"", "\"name\"", "1", "-", "1e999", "NaN",
        "null", "tru", "\\u00", "\\ud800", "//", "/*", "\u{feff}", "é", " ", "\n",
    ];
    let token = prop_oneof![
        9 => select(tokens.to_vec()).prop_map(|t| t.as_bytes().to_vec()),
        1 => proptest::collection::vec(any::<u8>(), 0..4),
    ];
    proptest::collection::vec(token, 0..60).prop_map(|parts| parts.concat())
}

fn duplicate_keys(value: &Value, times: usize) -> String {
    let text = value.to_string();
    let inside = &text[1..text.len() - 1];
    format!("{{{inside}{}}}", format!(",{inside}").repeat(times))
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn any_bytes_as_a_scene(bytes in almost_json()) {
        scene_holds(&Folder::new(), &bytes);
    }

    #[test]
    fn any_json_as_a_scene(value in json()) {
        scene_holds(&Folder::new(), value.to_string());
    }

    #[test]
    fn changed_scenes(scene in select(scenes()), changes in changes()) {
        scene_holds(&Folder::new(), changed(scene, &changes).to_string());
    }

    #[test]
    fn damaged_scene_files(scene in select(scenes()), edits in edits()) {
        let text = serde_json::to_vec_pretty(&scene).unwrap();
        scene_holds(&Folder::new(), damaged(&text, &edits, usize::MAX));
    }

    #[test]
    fn keys_given_twice_are_refused(scene in select(scenes()), times in 1_usize..4) {
        let folder = Folder::new();
        let path = folder.write("scene.json", duplicate_keys(&scene, times));
        let message = load_scene(&path).unwrap_err().to_string();
        prop_assert!(message.contains("twice") && is_one_paragraph(&message, &path));
    }

    #[test]
    fn nesting_of_any_depth(depth in 1_usize..20_000, object in any::<bool>(), closed in any::<bool>()) {
        let (open, close) = if object { ("{\"a\":", "}") } else { ("[", "]") };
        let mut text = open.repeat(depth);
        if closed {
            text += &format!("1{}", close.repeat(depth));
        }
        let folder = Folder::new();
        scene_holds(&folder, &text);
        experiment_holds(&folder, &text);
    }

    #[test]
    fn any_json_as_an_experiment(value in json()) {
        experiment_holds(&Folder::new(), value.to_string());
    }

    #[test]
    fn changed_experiments(changes in changes()) {
        experiment_holds(&Folder::new(), changed(experiment(), &changes).to_string());
    }

    #[test]
    fn changed_scenes_in_experiments(scene in select(scenes()), changes in changes()) {
        let folder = Folder::new();
        folder.write("one.json", changed(scene, &changes).to_string());
        experiment_holds(&folder, experiment().to_string());
    }

    #[test]
    fn any_pointer_and_value_in_set(pointer in text(), value in json(), known in select(vec![
        "/name", "/camera/position_m", "/camera/position_m/0", "/camera/position_m/9", "/density", "/march", "",
        "/density/procedural/decks/0", "/sun/elevation_deg", "/medium/phase/0/g", "/container",
    ]), own in any::<bool>()) {
        let mut e = experiment();
        let pointer = if own { known.to_owned() } else { format!("/{pointer}") };
        e["scenes"][1]["set"] = json!({ pointer: value });
        experiment_holds(&Folder::new(), e.to_string());
    }
}

#[test]
fn the_schema_and_the_experiment_used_here_are_good() {
    let folder = Folder::new();
    let path = folder.write("small.json", experiment().to_string());
    assert!(expand(&load_experiment(&path).unwrap(), &Registry).is_ok());
    assert!(schema(&Registry).is_object());
    for scene in scenes() {
        let path = folder.write("scene.json", scene.to_string());
        is_usable(&load_scene(&path).unwrap());
    }
}

#[test]
fn names_with_control_characters_are_refused_and_not_printed() {
    let folder = Folder::new();
    for name in ["a\nb", "\u{1b}[2Jx", "\u{0}", "\u{9b}31m"] {
        let mut scene = scenes()[1].clone();
        scene["name"] = json!(name);
        let path = folder.write("scene.json", scene.to_string());
        let message = load_scene(&path).unwrap_err().to_string();
        assert!(
            message.contains("control character") && is_one_paragraph(&message, &path),
            "{message}"
        );
        let mut e = experiment();
        e["name"] = json!(name);
        let path = folder.write("small.json", e.to_string());
        let message = load_experiment(&path).unwrap_err().to_string();
        assert!(
            message.contains("control character") && is_one_paragraph(&message, &path),
            "{message}"
        );
    }
}

#[test]
fn fields_whose_grid_would_not_fit_memory_are_refused() {
    let folder = Folder::new();
    let refused = |edit: &dyn Fn(&mut Value)| {
        let mut scene = scenes()[1].clone();
        edit(&mut scene);
        let path = folder.write("scene.json", scene.to_string());
        let message = load_scene(&path).unwrap_err().to_string();
        assert!(
            message.contains("shape_tile_m") && message.contains("shape tiles"),
            "{message}"
        );
    };
    // 6.4 million layers of 1024 × 1024 cells: 6.7e12 bytes.
    refused(&|s| {
        s["container"] = json!({"shell": {"planet_radius_m": 1e9, "base_m": 1, "top_m": 1e7}});
        s["density"]["procedural"]["shape_tile_m"] = json!(100);
        s["density"]["procedural"]["weather_tile_m"] = json!(1600);
        s["density"]["procedural"]["decks"][0]["base_m"] = json!(1);
        s["density"]["procedural"]["decks"][0]["top_m"] = json!(1e7);
    });
    // 16 × 16 × 20 tiles.
    refused(&|s| {
        s["density"]["procedural"]["shape_tile_m"] = json!(100);
        s["density"]["procedural"]["weather_tile_m"] = json!(1600);
    });
}

#[test]
fn lists_that_multiply_are_refused_before_they_are_copied() {
    let folder = Folder::new();
    let mut e = experiment();
    e["scenes"] = json!(vec!["one.json"; 1000]);
    e["sun_elevation_deg"] = json!(
        (0..100_000)
            .map(|i| 1.0 + f64::from(i) * 1e-4)
            .collect::<Vec<_>>()
    );
    let path = folder.write("small.json", e.to_string());
    let message = load_experiment(&path).unwrap_err().to_string();
    assert!(
        message.contains("1000 scenes × 100000 sun_elevation_deg"),
        "{message}"
    );
    assert!(is_one_paragraph(&message, &path));
}

#[test]
fn scene_files_have_a_limit_together() {
    let folder = Folder::new();
    let mut text = scenes()[1].to_string();
    text += &" ".repeat(MAX_FILE_BYTES as usize / 2);
    folder.write("one.json", text);
    let mut e = experiment();
    e["scenes"] = json!(["one.json"]);
    assert!(load_experiment(&folder.write("small.json", e.to_string())).is_ok());
    e["scenes"] = json!(["one.json", "one.json"]);
    let path = folder.write("small.json", e.to_string());
    let message = load_experiment(&path).unwrap_err().to_string();
    assert!(
        message.contains("/scenes/1") && message.contains("16 MiB together"),
        "{message}"
    );
}

#[test]
fn a_path_of_a_megabyte_is_refused() {
    let folder = Folder::new();
    let mut scene = scenes()[1].clone();
    scene["container"] = json!({"box": {"min_m": [0, 0, 0], "max_m": [1, 1, 1]}});
    scene["density"] = json!({"volume": {"path": "x".repeat(1 << 20), "up_axis": 1}});
    let path = folder.write("scene.json", scene.to_string());
    let message = load_scene(&path).unwrap_err().to_string();
    assert!(
        message.contains("4096") && is_one_paragraph(&message, &path),
        "{message}"
    );
}

#[test]
fn a_value_of_a_megabyte_is_quoted_in_part() {
    let folder = Folder::new();
    let path = folder.write("small.json", "");
    for text in [
        format!("{{\"{}\": 1}}", "k".repeat(1 << 20)),
        format!(
            "{{\"name\": \"e\", \"image\": {{\"width\": 1, \"height\": 1}}, \"scenes\": [[\"{}\"]], \"methods\": []}}",
            "v".repeat(1 << 20)
        ),
    ] {
        let message = parse_experiment(&path, text).unwrap_err().to_string();
        assert!(
            is_one_paragraph(&message, &path),
            "{} characters",
            message.len()
        );
    }
}
