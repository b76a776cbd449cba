//! Moving scenes, and sequences of their frames.

use super::common::{self, box_scene};
use glam::DVec3;
use occlab::cost::Counting;
use occlab::frame::Frame;
use occlab::occlusion::MethodSetup;
use occlab::oracle::{Options, Oracle};
use occlab::progress::unwatched;
use occlab::raymarch::Renderer;
use occlab::reconstruct::{Reconstruction, find};
use occlab::scene::{Ambient, ImageSize, Scene};
use std::path::Path;

/// Blobs in a box, seen with some medium-free rays around them; `jitter` as real scenes have it.
pub fn blobs(folder: &Path, jitter: bool) -> Scene {
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
pub fn flight(scene: &Scene, frame: u32, step_m: f64) -> Scene {
    let mut moved = scene.clone();
    let way_m = step_m * f64::from(frame);
    moved.camera.position_m[0] += way_m;
    moved.camera.position_m[2] += 0.7 * way_m;
    moved.camera.target_m[0] -= 0.4 * way_m;
    moved
}

/// The scene after a turn of the camera in place, degrees to the right and upwards.
pub fn turned(scene: &Scene, right_deg: f64, up_deg: f64) -> Scene {
    let mut moved = scene.clone();
    let (right, up, forward) = scene.camera.basis();
    let [(x, ahead), (y, level)] = [right_deg, up_deg].map(|a| a.to_radians().sin_cos());
    let direction = (forward * ahead + right * x) * level + up * y;
    moved.camera.target_m = (DVec3::from(scene.camera.position_m) + 1000.0 * direction).into();
    moved
}

/// Full renders and reconstructed frames of a sequence.
pub struct Sequence {
    pub full: Vec<Frame>,
    pub rebuilt: Vec<Frame>,
}

/// Temporal integration.
pub fn temporal() -> &'static dyn Reconstruction {
    find("temporal_2x2").unwrap()
}

pub fn on_device(
    renderer: &Renderer,
    by: &dyn Reconstruction,
    scenes: &[Scene],
    image: ImageSize,
    setup: &MethodSetup,
) -> Sequence {
    let sequence = by.on_device(&renderer.gpu, image).unwrap();
    let mut frames = Sequence {
        full: Vec::new(),
        rebuilt: Vec::new(),
    };
    for scene in scenes {
        let view = renderer.view(scene, image).unwrap();
        frames
            .full
            .push(common::render_view(renderer, &view, setup));
        let next = renderer
            .prepare(&view, setup, &sequence, Counting::Off)
            .unwrap();
        let times = next.run(&renderer.gpu, &mut unwatched).unwrap();
        let passes = times.march.is_some() && !by.info().is_full();
        assert_eq!(times.reconstruct.is_some(), passes);
        // Both passes lie inside the wall time.
        assert!(times.total().is_none_or(|total| total <= times.wall));
        frames.rebuilt.push(next.picture(&renderer.gpu).unwrap());
    }
    frames
}

pub fn on_oracle(
    by: &dyn Reconstruction,
    scenes: &[Scene],
    image: ImageSize,
    setup: &MethodSetup,
) -> Sequence {
    let mut sequence = by.on_oracle(image);
    let mut frames = Sequence {
        full: Vec::new(),
        rebuilt: Vec::new(),
    };
    let mut last: Option<Oracle> = None;
    for scene in scenes {
        let oracle = match &last {
            Some(oracle) => oracle.again(scene, image).unwrap(),
            None => Oracle::new(scene, image).unwrap(),
        };
        let method = oracle.prepare(setup, Options::default()).unwrap();
        frames.full.push(method.render(&mut unwatched).unwrap().0);
        sequence.render(&method, &mut unwatched).unwrap();
        frames.rebuilt.push(sequence.picture().unwrap());
        drop(method);
        last = Some(oracle);
    }
    frames
}

pub fn bits(frame: &Frame) -> Vec<[u32; 4]> {
    let pixels = frame.radiance.iter().chain(&frame.sun);
    pixels.map(|p| p.map(f32::to_bits)).collect()
}
