//! The device against its f64 twin, with a moving camera.

use super::common::{self, relative_rmse, setup, size};
use super::sequence::{blobs, flight, on_device, on_oracle, temporal, turned};
use occlab::frame::Frame;
use occlab::scene::{ImageSize, Integration, Scene, Sky};

/// √Σ(b − a)²/√Σa² of RGB and of alpha of both planes over all pixels, the largest of the four.
pub fn apart(a: &Frame, b: &Frame) -> f64 {
    let planes = [(&a.radiance, &b.radiance), (&a.sun, &b.sun)];
    let of = |(a, b): (&Vec<[f32; 4]>, &Vec<[f32; 4]>), channels: std::ops::Range<usize>| {
        let values = |p: &[f32; 4]| {
            p[channels.clone()]
                .iter()
                .map(|v| f64::from(*v))
                .collect::<Vec<_>>()
        };
        let (a, b) = (a.iter().flat_map(values), b.iter().flat_map(values));
        relative_rmse(b.zip(a))
    };
    let errors = planes.map(|pair| of(pair, 0..3).max(of(pair, 3..4)));
    errors[0].max(errors[1])
}

/// Frames of both: the full picture, the rebuilt one, and a control that must not agree.
fn check_twin(scenes: Vec<Scene>, image: ImageSize, params: &str, full_most: f64) {
    let setup = setup("srm", params);
    let twin = on_oracle(temporal(), &scenes, image, &setup);
    common::on_gpu(move |renderer| {
        let made = on_device(renderer, temporal(), &scenes, image, &setup);
        for n in 0..scenes.len() {
            let full = apart(&twin.full[n], &made.full[n]);
            let rebuilt = apart(&twin.rebuilt[n], &made.rebuilt[n]);
            let other = apart(&twin.rebuilt[n], &made.full[n]);
            println!("frame {n}: full {full:.1e}, rebuilt {rebuilt:.1e}, control {other:.1e}");
            assert!(full < full_most, "frame {n}: {full}");
            assert!(rebuilt < 1e-4, "frame {n}: {rebuilt}");
            assert!(other > 5e-2, "frame {n}: the control agrees too: {other}");
        }
    });
}

/// A flight past blobs, changed by `edit`.
fn check_flight(image: ImageSize, frames: u32, step_m: f64, params: &str, edit: fn(&mut Scene)) {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = blobs(folder.path(), true);
    edit(&mut scene);
    let scenes = (0..frames).map(|n| flight(&scene, n, step_m)).collect();
    // Preetham's sky in f32 is 5e-5 off, everything else 2e-6.
    let full_most = if scene.sky.is_some() { 1e-4 } else { 1e-5 };
    check_twin(scenes, image, params, full_most);
}

#[test]
fn the_device_and_its_twin_rebuild_the_same_frames() {
    needs_adapter!();
    check_flight(size(41, 30), 10, 12.0, "steps=6", |_| ());
}

#[test]
fn before_a_sky_too() {
    needs_adapter!();
    check_flight(size(41, 30), 6, 12.0, "steps=6", |scene| {
        scene.sky = Some(Sky::Preetham {
            turbidity: 3.0,
            ground_albedo: 0.1,
        });
    });
}

#[test]
fn and_integrated_as_the_thesis_prints_it() {
    needs_adapter!();
    check_flight(size(41, 30), 6, 12.0, "steps=6", |scene| {
        scene.march.integration = Integration::Thesis;
    });
}

/// So fast that near and far cloud part by several pixels a frame, and history shows something else.
#[test]
fn history_of_something_else_serves_neither() {
    needs_adapter!();
    check_flight(size(64, 48), 6, 150.0, "steps=6", |_| ());
}

/// So many light steps that a software adapter marches each view ray in several dispatches.
#[test]
fn a_ray_in_several_dispatches_keeps_its_depth() {
    needs_adapter!();
    check_flight(size(15, 10), 6, 12.0, "steps=1000", |_| ());
}

/// A view so narrow that cloud crosses every border.
#[test]
fn what_enters_at_each_border_has_no_history() {
    needs_adapter!();
    for (right_deg, up_deg) in [(1.2, 0.0), (-1.2, 0.0), (0.0, 1.2), (0.0, -1.2)] {
        let folder = tempfile::tempdir().unwrap();
        let mut scene = blobs(folder.path(), true);
        scene.camera.fov_y_deg = 12.0;
        let turn = |n: u32| turned(&scene, f64::from(n) * right_deg, f64::from(n) * up_deg);
        check_twin((0..5).map(turn).collect(), size(48, 32), "steps=6", 1e-5);
    }
}

/// A camera that looks back at the cloud from its other side, and one that has left it behind.
#[test]
fn history_from_the_other_side_or_from_behind_serves_neither() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    // Without jitter: that of the first pixel is 0, which puts a sample on the face where light is cut off.
    let before = blobs(folder.path(), false);
    let mut beyond = before.clone();
    beyond.camera.position_m = [217.0, 33.0, 1713.0];
    let mut inside = before.clone();
    inside.camera.position_m = [100.0, 50.0, 0.0];
    inside.camera.target_m = [100.0, 60.0, 1000.0];
    for after in [beyond, inside] {
        let scenes = [&before, &before, &after, &after, &before].map(Scene::clone);
        check_twin(scenes.to_vec(), size(41, 30), "steps=6", 1e-5);
    }
}
