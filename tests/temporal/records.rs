//! Temporal integration: nothing at rest, reprojection on the move, the device against its f64 twin, the records.

#[macro_use]
mod common;
#[path = "common/program.rs"]
mod program;

use common::{box_scene, setup, size};
use occlab::frame::Frame;
use occlab::metrics::relative_rmse;
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::oracle::{self, Options, Oracle};
use occlab::raymarch::{History, Renderer, unwatched};
use occlab::scene::{Ambient, ImageSize, Reconstruct, Scene, Track};
use program::{batch, occlab, report, stderr, workplace};
use serde_json::{Value, json};
use std::path::Path;

/// Blobs in a box, seen with some medium-free rays around them; `jitter` as real scenes have it.
fn blobs(folder: &Path, jitter: bool) -> Scene {
    let mut scene = box_scene([-500.0; 3], [500.0; 3], 0.02);
    let smooth = |x: usize, y: usize, z: usize| {
        let wave = |v: usize, k: f32, p: f32| (v as f32 * k + p).sin();
        let sum = wave(x, 0.7, 0.0) + wave(y, 0.9, 1.0) + wave(z, 0.8, 2.0) + wave(x + z, 0.4, 0.5);
        (0.6 * sum).clamp(0.0, 1.0)
    };
    scene.density = common::cube_density(common::write_cube(folder, 24, smooth));
    scene.sun.elevation_deg = 40.0;
    scene.march.jitter = jitter;
    scene.ambient = Some(Ambient::Uniform {
        radiance: [0.02, 0.03, 0.05],
    });
    scene.camera.position_m = [0.0, 100.0, -1800.0];
    scene.camera.target_m = [0.0; 3];
    scene.camera.fov_y_deg = 36.0;
    scene
}

/// A camera that flies past, turning: far enough for parallax of several pixels between near and far.
fn flight(scene: &Scene, frame: u32, step_m: f64) -> Scene {
    let mut moved = scene.clone();
    let way_m = step_m * f64::from(frame);
    moved.camera.position_m[0] += way_m;
    moved.camera.position_m[2] += 0.7 * way_m;
    moved.camera.target_m[0] -= 0.4 * way_m;
    moved
}

/// Full renders and temporal frames of a sequence.
struct Sequence {
    full: Vec<Frame>,
    temporal: Vec<Frame>,
}

fn on_device(
    renderer: &Renderer,
    scenes: &[Scene],
    image: ImageSize,
    setup: &MethodSetup,
) -> Sequence {
    let history = History::new(&renderer.gpu, image).unwrap();
    let mut frames = Sequence {
        full: Vec::new(),
        temporal: Vec::new(),
    };
    for scene in scenes {
        let view = renderer.view(scene, image).unwrap();
        frames
            .full
            .push(common::render_view(renderer, &view, setup));
        let temporal = renderer.prepare_temporal(&view, setup, &history).unwrap();
        let times = temporal.run(&renderer.gpu, &mut unwatched).unwrap();
        assert_eq!(times.reconstruct.is_some(), times.march.is_some());
        frames
            .temporal
            .push(temporal.picture(&renderer.gpu).unwrap());
    }
    frames
}

fn on_oracle(scenes: &[Scene], image: ImageSize, setup: &MethodSetup) -> Sequence {
    let mut history = oracle::History::new(image).unwrap();
    let mut frames = Sequence {
        full: Vec::new(),
        temporal: Vec::new(),
    };
    let mut last: Option<Oracle> = None;
    for scene in scenes {
        let oracle = match &last {
            Some(oracle) => oracle.again(scene, image).unwrap(),
            None => Oracle::new(scene, image).unwrap(),
        };
        let method = oracle.prepare(setup, Options::default()).unwrap();
        frames.full.push(method.render(&mut unwatched).unwrap().0);
        method.render_next(&mut history, &mut unwatched).unwrap();
        frames.temporal.push(history.picture().unwrap());
        drop(method);
        last = Some(oracle);
    }
    frames
}

/// What the same frames would be if history stayed where it was on the screen.
fn without_reprojection(full: &[Frame]) -> Vec<Frame> {
    let mut picture = full[0].clone();
    let pictures = full.iter().enumerate().map(|(n, frame)| {
        let [x, y] = Reconstruct::BAYER_2X2[n % 4];
        for row in (y..frame.height).step_by(2) {
            for column in (x..frame.width).step_by(2) {
                let i = (row * frame.width + column) as usize;
                (picture.radiance[i], picture.sun[i]) = (frame.radiance[i], frame.sun[i]);
            }
        }
        picture.clone()
    });
    pictures.collect()
}

/// Mean ghosting of the frames after the first four.
fn ghosting(full: &[Frame], rebuilt: &[Frame]) -> f64 {
    let errors: Vec<f64> = full
        .iter()
        .zip(rebuilt)
        .skip(4)
        .map(|(full, rebuilt)| relative_rmse(full, full, rebuilt).unwrap())
        .collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

fn bits(frame: &Frame) -> Vec<[u32; 4]> {
    let pixels = frame.radiance.iter().chain(&frame.sun);
    pixels.map(|p| p.map(f32::to_bits)).collect()
}

#[test]
fn at_rest_four_frames_of_every_method_are_the_full_picture_bit_for_bit() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    common::on_gpu(move |renderer| {
        for method in REGISTRY {
            let setup = common::with_map(method.info().id, "resolution=32 steps=12", "");
            let made = on_device(renderer, &vec![scene.clone(); 6], size(33, 22), &setup);
            let equal = |n: usize| bits(&made.temporal[n]) == bits(&made.full[n]);
            let id = method.info().id;
            assert!(!equal(2), "{id}: three frames cannot know all of it");
            assert!((3..6).all(equal), "{id}");
        }
    });
}

#[test]
fn at_rest_the_oracle_repeats_its_picture_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    let made = on_oracle(&vec![scene; 5], size(17, 12), &setup("srm", "steps=4"));
    assert_ne!(bits(&made.temporal[2]), bits(&made.full[2]));
    for n in 3..5 {
        assert_eq!(bits(&made.temporal[n]), bits(&made.full[n]));
    }
}

#[test]
fn reprojection_beats_a_history_that_stays_on_the_screen() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), false);
    let image = size(96, 64);
    let pan: Vec<Scene> = (0..12)
        .map(|n| Track::Pan.scene(&scene, image, n))
        .collect();
    let fly: Vec<Scene> = (0..12).map(|n| flight(&scene, n, 12.0)).collect();
    // One depth a ray cannot follow both sides of a translucent cloud past which the camera flies.
    for (name, scenes, most) in [("pan", pan, 0.15), ("flight", fly, 0.7)] {
        common::on_gpu(move |renderer| {
            let made = on_device(renderer, &scenes, image, &setup("srm", "steps=6"));
            let ours = ghosting(&made.full, &made.temporal);
            let control = ghosting(&made.full, &without_reprojection(&made.full));
            println!("{name}: ghosting {ours}, without reprojection {control}");
            assert!(
                ours > 0.0 && ours < most * control,
                "{name}: {ours} of {control}"
            );
        });
    }
}

/// Frames of a flight on both: relative RMSE of the full picture, of the rebuilt one, and of a control that must not agree.
fn check_twin(image: ImageSize, frames: u32, step_m: f64, params: &str) {
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    let scenes: Vec<Scene> = (0..frames).map(|n| flight(&scene, n, step_m)).collect();
    let setup = setup("srm", params);
    let twin = on_oracle(&scenes, image, &setup);
    common::on_gpu(move |renderer| {
        let made = on_device(renderer, &scenes, image, &setup);
        for n in 0..scenes.len() {
            let differs = |a: &Frame, b: &Frame| relative_rmse(a, a, b).unwrap();
            let full = differs(&twin.full[n], &made.full[n]);
            let rebuilt = differs(&twin.temporal[n], &made.temporal[n]);
            let other = differs(&twin.temporal[n], &made.full[n]);
            println!("frame {n}: full {full:.1e}, rebuilt {rebuilt:.1e}, control {other:.1e}");
            assert!(full < 1e-5, "frame {n}: {full}");
            assert!(rebuilt < 3e-4, "frame {n}: {rebuilt}");
            assert!(other > 5e-2, "frame {n}: the control agrees too: {other}");
        }
    });
}

#[test]
fn the_device_and_its_twin_rebuild_the_same_frames() {
    needs_adapter!();
    check_twin(size(41, 30), 10, 12.0, "steps=6");
}

/// Fast enough that near and far part by several pixels a frame, and history shows something else.
#[test]
fn history_of_something_else_serves_neither_the_device_nor_its_twin() {
    needs_adapter!();
    check_twin(size(64, 48), 6, 150.0, "steps=6");
}

/// So many light steps that a software adapter marches each view ray in several dispatches.
#[test]
fn a_ray_in_several_dispatches_keeps_its_depth() {
    needs_adapter!();
    check_twin(size(15, 10), 6, 12.0, "steps=1000");
}

#[test]
fn the_march_of_a_full_picture_holds_nothing_of_it() {
    use occlab::gpu::{Defs, Program, Sources, compose};
    let names = |defs: Defs| {
        let roles = vec![
            ("container", "container/box.wgsl"),
            ("density", "density/uniform.wgsl"),
            ("occlusion", "occlusion/none.wgsl"),
        ];
        let module = compose(
            &Sources::embedded(),
            &Program {
                entry: "raymarch.wgsl",
                roles,
                defs,
            },
        )
        .unwrap();
        let variables = module.global_variables.iter();
        let bound = variables.filter(|(_, v)| v.binding.is_some());
        let names = bound.filter_map(|(_, v)| v.name.clone());
        names.collect::<Vec<String>>().join(" ")
    };
    let (full, temporal) = (
        names(Defs::new()),
        names(Defs::from([("TEMPORAL_2X2".into(), None)])),
    );
    for name in ["nearness_out", "quarter"] {
        assert!(
            !full.contains(name) && temporal.contains(name),
            "{full} | {temporal}"
        );
    }
}

fn both() -> tempfile::TempDir {
    workplace(|_, e| {
        e["sun_elevation_deg"] = json!(60);
        e["reconstruct"] = json!(["full", "temporal_2x2"]);
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
        // A device fills the map in every frame; the oracle the texels that are looked up.
        let whole = arguments == ["--backend", "gpu"];
        assert!(map(temporal) == map(full) || !whole && map(temporal) <= map(full));
        let numbers = &temporal["reconstruction"];
        assert_eq!(numbers["full_rel_rmse"], json!(0.0));
        let curve = numbers["ghosting_rel_rmse"].as_array().unwrap();
        assert_eq!((curve.len(), &curve[0]), (16, &json!(0.0)));
        assert!(curve[1..].iter().all(|e| e.as_f64().unwrap() > 0.0));
        assert_eq!(numbers["history_bytes"], json!(24 * 16 * 72));
    }
    let csv = std::fs::read_to_string(folder.path().join("out/cells.csv")).unwrap();
    let header = csv.lines().next().unwrap();
    assert!(header.contains(",reconstruct,") && header.contains("reconstruction.full_rel_rmse"));
    assert!(
        folder
            .path()
            .join("out/charts/ghosting-1-slab-sun60.svg")
            .is_file()
    );
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
fn a_run_that_ended_before_its_pan_adds_it_and_repeats_nothing_else() {
    needs_adapter!();
    let folder = both();
    assert!(batch(folder.path()).status.success());
    let before = report(folder.path());
    let id = before["cells"][1]["id"].as_str().unwrap();
    let path = folder.path().join(format!("out/cells/{id}.json"));
    let mut record: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    record["result"]
        .as_object_mut()
        .unwrap()
        .remove("reconstruction")
        .unwrap();
    std::fs::write(&path, record.to_string()).unwrap();
    assert!(batch(folder.path()).status.success());
    assert_eq!(report(folder.path())["cells"], before["cells"]);
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
