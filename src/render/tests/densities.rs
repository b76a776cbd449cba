//! Requirements on every kind of density, checked over the registry with the examples of each kind.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::agreement::{channels, error};
use common::{box_scene, containers, cumulus, on_gpu, relative_rmse, render_view, setup, size};
use occlab::config::schema;
use occlab::density::{ControlValue, Density};
use occlab::frame::Frame;
use occlab::oracle::{Options, Oracle};
use occlab::reconstruct::Registry;
use occlab::scene::{Container, Scene};
use std::collections::HashSet;
use std::path::Path;

/// A scene around `density`: a box seen from outside, a shell from the ground.
fn scene(name: &str, container: &Container, density: Density) -> Scene {
    let mut scene = match container {
        Container::Box { min_m, max_m } => {
            let mut scene = box_scene(*min_m, *max_m, 0.03);
            scene.camera.position_m = [-1500.0, 1900.0, -2600.0];
            scene
        }
        Container::Shell { .. } => cumulus(),
    };
    scene.name = name.to_owned();
    scene.container = container.clone();
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    scene.density = density;
    scene
}

/// Scenes with every example of a kind: of the box, where it has some there, else of the shell. One list a kind.
fn scenes(folder: &Path) -> Vec<Vec<Scene>> {
    let [shell, solid] = containers().map(|(_, container)| container);
    let kinds = Density::KINDS.iter().map(|kind| {
        let examples = |container| (kind.examples)(container, folder).unwrap();
        let (container, examples) = match examples(&solid) {
            none if none.is_empty() => (&shell, examples(&shell)),
            some => (&solid, some),
        };
        assert!(!examples.is_empty(), "{} gives no example", kind.name);
        let scenes = examples.into_iter().enumerate();
        let named = |(i, density)| scene(&format!("{} {i}", kind.name), container, density);
        scenes.map(named).collect()
    });
    kinds.collect()
}

#[test]
fn kinds_are_registered_once_and_read_what_they_write() {
    let folder = tempfile::tempdir().unwrap();
    let validator = jsonschema::draft202012::new(&schema(&Registry)).unwrap();
    let mut names = HashSet::new();
    for (kind, scenes) in Density::KINDS.iter().zip(scenes(folder.path())) {
        let name = kind.name;
        assert!(names.insert(name), "two kinds are called {name}");
        for scene in scenes {
            scene.validate().unwrap();
            assert_eq!(scene.density.name(), name);
            let json = serde_json::to_value(&scene).unwrap();
            let keys: Vec<_> = json["density"].as_object().unwrap().keys().collect();
            assert_eq!(keys, [name]);
            assert!(validator.is_valid(&json), "{json}");
            assert_eq!(
                serde_json::from_value::<Scene>(json.clone()).unwrap(),
                scene
            );
            let mut misspelt = json;
            misspelt["density"][name]["nobody_reads_this"] = 1.into();
            assert!(!validator.is_valid(&misspelt), "{misspelt}");
            assert!(serde_json::from_value::<Scene>(misspelt).is_err());
        }
    }
}

/// Files, seeds and numbers that the command line and the window change are members of the field itself.
#[test]
fn files_seeds_and_controls_are_members_of_the_field() {
    let folder = tempfile::tempdir().unwrap();
    for scene in scenes(folder.path()).into_iter().flatten() {
        let mut changed = scene.density.clone();
        if let Some(seed) = changed.field_mut().seed_mut() {
            *seed += 1;
            assert_ne!(changed, scene.density);
        }
        let mut changed = scene.density.clone();
        match (changed.field().input_file(), scene.input_file()) {
            (Some(file), Some(same)) if file == same => assert!(file.is_file()),
            (None, None) => {}
            other => panic!("{}: {other:?}", scene.name),
        }
        if let Some(path) = changed.field_mut().input_file_mut() {
            path.push("x");
            assert_ne!(changed, scene.density);
        }
        for control in changed.field_mut().controls() {
            assert!(!control.name.is_empty() && control.doc.ends_with('.'));
            let inside = match control.value {
                ControlValue::Real(value, range) => range.contains(value),
                ControlValue::Whole(value, range) => range.contains(value),
            };
            assert!(inside, "{}: {}", scene.name, control.name);
        }
    }
}

/// Sunlight, radiance and opacity of two pictures.
fn distance(a: &Frame, b: &Frame) -> f64 {
    let opacity = |f: &Frame| {
        f.radiance
            .iter()
            .map(|p| f64::from(p[3]))
            .collect::<Vec<_>>()
    };
    [
        error(a, b, |f| &f.sun),
        error(a, b, |f| &f.radiance),
        relative_rmse(opacity(a).into_iter().zip(opacity(b))),
    ]
    .into_iter()
    .fold(0.0, f64::max)
}

/// The device's picture, with and without skipping of empty space, equals the twin's: to the rounding of f32, or, where
/// hardware filters textures of 8 bits, to 1e-2 with the nearest filter. A sun 5° higher must differ by more. The
/// oracle refuses a kind without a twin.
#[test]
fn device_and_twin_agree() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    for mut scenes in scenes(folder.path()) {
        // Noise takes the twin seconds to make: of such a kind the example with the most structure stands for all.
        if scenes[0].density.field().filters().len() > 1 {
            scenes.drain(..scenes.len() - 1);
        }
        scenes.into_iter().for_each(compare);
    }
}

fn compare(scene: Scene) {
    on_gpu(move |renderer| {
        let (image, setup) = (size(32, 18), setup("srm", ""));
        let field = scene.density.field();
        let mut view = renderer.view(&scene, image).unwrap();
        let device = render_view(renderer, &view, &setup);
        view.set_skip(false);
        let unskipped = render_view(renderer, &view, &setup);
        assert!(
            channels(&device, |f| &f.sun).any(|v| v > 0.0),
            "{}",
            scene.name
        );
        // Drivers may fuse operations differently on the two paths through a loop.
        assert!(distance(&device, &unskipped) <= 1e-6, "{}", scene.name);
        let tolerance = match field.filters().len() {
            1 => setup.method.info().tolerance,
            _ => 1e-2,
        };
        let mut higher = scene.clone();
        higher.sun.elevation_deg += 5.0;
        let near = field.filters().iter().any(|filter| {
            let oracle = match Oracle::filtered(&scene, image, *filter) {
                Ok(oracle) => oracle,
                Err(refused) => {
                    let name = scene.density.name();
                    let expected = format!("a density of kind `{name}` has no f64 twin");
                    assert!(refused.to_string().contains(&expected), "{refused}");
                    return true;
                }
            };
            let against = |oracle: &Oracle| {
                let frame = oracle.render(&setup, Options::default()).unwrap();
                distance(&device, &frame)
            };
            let (right, wrong) = (
                against(&oracle),
                against(&oracle.again(&higher, image).unwrap()),
            );
            println!(
                "{} {}: {right:.1e}; control {wrong:.1e}",
                scene.name,
                filter.name()
            );
            assert!(
                wrong > 2.0 * tolerance,
                "{}: a wrong sun passed",
                scene.name
            );
            right <= tolerance
        });
        assert!(
            near,
            "{}: no filter comes within {tolerance:.0e}",
            scene.name
        );
    });
}
