//! Agreement of device pictures with the oracle's: the smallest error over the number formats a device may use.

use super::{box_scene, cube_density, hashed, relative_rmse, with_map, write_cube};
use occlab::frame::Frame;
use occlab::occlusion::MethodSetup;
use occlab::occlusion::rounding::{FloatFormat, Rounding};
use occlab::oracle::{Options, Oracle};
use occlab::scene::{ImageSize, Scene};

pub const IMAGE: ImageSize = ImageSize {
    width: 48,
    height: 27,
};

/// The method, with a small map if it has one.
pub fn small(id: &str, params: &str) -> MethodSetup {
    with_map(id, "resolution=128 steps=64", params)
}

/// Roundings of stored values that a device may use.
pub fn roundings(setup: &MethodSetup) -> Vec<Rounding> {
    let nearest = Rounding {
        storage: setup.stored_format().unwrap().unwrap_or(FloatFormat::F32),
        ..Rounding::device("f32", false)
    };
    let cut = Rounding {
        truncate_f16: true,
        ..nearest
    };
    if nearest.storage == FloatFormat::F16 {
        vec![nearest, cut]
    } else {
        vec![nearest]
    }
}

pub fn channels(frame: &Frame, of: fn(&Frame) -> &[[f32; 4]]) -> impl Iterator<Item = f64> + '_ {
    of(frame)
        .iter()
        .flat_map(|p| p[..3].iter().map(|v| f64::from(*v)))
}

pub fn error(device: &Frame, oracle: &Frame, of: fn(&Frame) -> &[[f32; 4]]) -> f64 {
    relative_rmse(channels(device, of).zip(channels(oracle, of)))
}

/// Relative RMSE of sunlight, the smallest over the oracles and the roundings that the device may use.
pub fn agreement(device: &Frame, oracles: &[Oracle], setup: &MethodSetup) -> f64 {
    let mut best = f64::INFINITY;
    for oracle in oracles {
        for rounding in roundings(setup) {
            let options = Options {
                rounding,
                ..Options::default()
            };
            let frame = oracle.render(setup, options).unwrap();
            best = best.min(error(device, &frame, |f| &f.sun));
        }
    }
    best
}

/// Changes the scene to a view from outside, a box in full view, under an oblique sun.
fn outside(scene: &mut Scene) {
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    scene.camera.position_m = [-500.0, 900.0, -1400.0];
}

pub fn rough_volume(folder: &std::path::Path) -> Scene {
    let mut scene = box_scene([-300.0, 100.0, -200.0], [400.0, 600.0, 500.0], 0.03);
    scene.name = "volume".into();
    scene.density = cube_density(write_cube(folder, 17, |x, y, z| {
        (hashed(x, y, z) - 0.6).max(0.0) * 2.5
    }));
    outside(&mut scene);
    scene
}
