//! Skipping of empty space changes no picture; noise repeats without seams; coverage is what the scene asks for.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{
    box_scene, count_view, cube_density, cumulus, hashed, on_gpu, procedural, reds, relative_rmse,
    render, render_view, setup, size, write_cube,
};
use occlab::frame::Frame;
use occlab::scene::{Density, Scene};

/// Compares picture and density samples with skipping on and off, for the three kinds of light sampling; the second
/// view uses the kernels of the first.
fn check_skipping(scene: Scene) {
    scene.validate().unwrap();
    on_gpu(move |renderer| {
        let mut view = renderer.view(&scene, size(20, 14)).unwrap();
        let empty = view.density.built.empty_fraction.unwrap();
        assert!(
            (0.05..0.95).contains(&empty),
            "{}: {empty} of the cells are empty",
            scene.name
        );
        for (id, params) in [
            ("truth", "step_m=20"),
            ("srm", "steps=12"),
            ("bsm", "resolution=64 steps=48"),
        ] {
            let method = setup(id, params);
            let [on, off] = [true, false].map(|skip| {
                view.set_skip(skip);
                (
                    render_view(renderer, &view, &method),
                    count_view(renderer, &view, &method).samples,
                )
            });
            let opaque = on.0.radiance.iter().filter(|p| p[3] > 0.1).count();
            assert!(
                opaque > 20 && on.0.radiance.iter().any(|p| p[0] > 0.0),
                "{}: nothing to see",
                scene.name
            );
            if renderer.gpu.info.device_type == wgpu::DeviceType::Cpu {
                assert!(
                    on.0 == off.0,
                    "{}: {id}: relative RMSE {:.1e}",
                    scene.name,
                    relative_rmse(reds(&on.0, &off.0))
                );
            } else {
                // Drivers may fuse operations differently on the two paths through a loop.
                let error = relative_rmse(reds(&on.0, &off.0));
                assert!(error <= 1e-6, "{}: {id}: {error:.1e}", scene.name);
            }
            let samples = |s: occlab::cost::Samples| [s.view, s.light, s.map];
            let (on, off) = (samples(on.1), samples(off.1));
            println!(
                "{} {id}: view, light, map samples {on:?} skipping, {off:?} not; {empty:.2} empty",
                scene.name
            );
            // Only the view march and the truth skip: elsewhere the grid look-up costs more than it saves.
            assert!(on[0] < off[0] && on[2] == off[2], "{}: {id}", scene.name);
            assert!(
                if id == "truth" {
                    on[1] < off[1]
                } else {
                    on[1] == off[1]
                },
                "{}: {id}",
                scene.name
            );
        }
    });
}

#[test]
fn skipping_is_exact_in_procedural_clouds() {
    needs_adapter!();
    let mut scene = cumulus();
    // Erosion shrinks clouds away from their bounds: without it, and with steps below a cell (32 m), a step skipped too
    // far shows.
    let Density::Procedural(field) = &mut scene.density else {
        unreachable!()
    };
    field.detail = None;
    scene.march.step_m = Some(24.0);
    check_skipping(scene);
}

/// Decks of a box may lie below height 0.
#[test]
fn skipping_is_exact_below_height_zero() {
    needs_adapter!();
    let mut scene = box_scene([-4000.0, -1500.0, -4000.0], [4000.0, -300.0, 4000.0], 0.04);
    scene.name = "below zero".into();
    let mut field = procedural(0.4);
    field.detail = None;
    (field.decks[0].base_m, field.decks[0].top_m) = (-1500.0, -300.0);
    scene.density = Density::Procedural(field);
    scene.camera.position_m = [0.0, -900.0, -9000.0];
    scene.camera.target_m = [0.0, -900.0, 0.0];
    scene.camera.fov_y_deg = 20.0;
    scene.sun.elevation_deg = 35.0;
    scene.march.step_m = Some(24.0);
    check_skipping(scene);
}

#[test]
fn skipping_is_exact_in_a_random_volume() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    // Clumps of 6³ cells with holes inside and out.
    let value = |x: usize, y: usize, z: usize| {
        let clump = hashed(x / 6, y / 6, z / 6) < 0.25;
        if clump && hashed(x, y, z) < 0.7 {
            hashed(z, x, y)
        } else {
            0.0
        }
    };
    let mut scene = box_scene([0.0; 3], [960.0, 640.0, 960.0], 0.05);
    scene.name = "random volume".into();
    scene.density = cube_density(write_cube(folder.path(), 24, value));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (33.0, 70.0);
    scene.march.jitter = true;
    check_skipping(scene);
}

const TILE_M: f64 = 8192.0;

/// One deck seen straight from above over a square of `width_m` about (x, z): rays lean by less than 1 in 100.
fn from_above(coverage: f64, [x, z]: [f64; 2], width_m: f64) -> Scene {
    let half = 2.0 * TILE_M;
    let mut scene = box_scene(
        [x - half, 1024.0, z - half],
        [x + half, 2048.0, z + half],
        0.03,
    );
    scene.density = Density::Procedural(procedural(coverage));
    let height = 100.0 * width_m;
    scene.camera.position_m = [x, 1536.0 + height, z];
    scene.camera.target_m = [x, 1536.0, z];
    scene.camera.up = [0.0, 0.0, 1.0];
    scene.camera.fov_y_deg = 2.0 * (0.5 * width_m / height).atan().to_degrees();
    scene.sun.elevation_deg = 50.0;
    scene.march.steps = 96;
    scene
}

/// The periods are powers of two: positions a period apart have the same fractions, but for the rounding of positions
/// (2⁻⁹ m at 16 km) which moves 8-bit filter weights: 1e-3.
#[test]
fn the_field_repeats_after_a_weather_tile() {
    needs_adapter!();
    let picture = |x: f64| {
        let mut scene = from_above(0.5, [x, 0.0], 4000.0);
        scene.camera.position_m = [x - 3000.0, 500.0, -2500.0];
        scene.camera.fov_y_deg = 40.0;
        scene.camera.up = [0.0, 1.0, 0.0];
        render(&scene, size(20, 14), &setup("srm", "steps=6"))
    };
    let home = picture(0.0);
    assert!(
        home.radiance.iter().filter(|p| p[3] > 0.2).count() > 20,
        "nothing to see"
    );
    let error = relative_rmse(reds(&picture(TILE_M), &home));
    println!("a tile away: relative RMSE {error:.1e}");
    assert!(error <= 1e-3, "a tile away: relative RMSE {error:.1e}");
    let mut turned = home.clone();
    turned.radiance.rotate_left(1);
    let other = relative_rmse(reds(&turned, &home));
    assert!(
        other > 0.05,
        "a pixel away the picture must differ: {other:.1e}"
    );
}

/// Mean change of opacity between neighbouring columns of pixels.
fn column_changes(frame: &Frame) -> Vec<f64> {
    let width = frame.width as usize;
    let change = |i: usize| {
        let rows = frame
            .radiance
            .chunks(width)
            .map(|row| f64::from((row[i + 1][3] - row[i][3]).abs()));
        rows.sum::<f64>() / f64::from(frame.height)
    };
    (0..width - 1).map(change).collect()
}

/// Change across the middle over the largest change elsewhere.
fn seam(frame: &Frame) -> f64 {
    let changes = column_changes(frame);
    let middle = frame.width as usize / 2 - 1;
    changes[middle]
        / changes
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != middle)
            .map(|(_, c)| *c)
            .fold(0.0, f64::max)
}

/// The tiles of weather, shape and detail meet at x = 0. Opacity must not change more across it than elsewhere.
#[test]
fn tiles_join_without_a_seam() {
    needs_adapter!();
    let mut one = render(
        &from_above(0.6, [0.0, 1000.0], 1500.0),
        size(64, 64),
        &setup("none", ""),
    );
    let measured = seam(&one);
    println!("seam: {measured:.2} of the largest change elsewhere");
    assert!(
        measured < 1.2,
        "the change across the seam is {measured:.2} times the largest elsewhere"
    );
    // Negative control: the right half turned upside down.
    let (radiance, width) = (one.radiance.clone(), 64);
    for (y, row) in one.radiance.chunks_mut(width).enumerate() {
        row[width / 2..].copy_from_slice(&radiance[(width - 1 - y) * width..][width / 2..width]);
    }
    assert!(seam(&one) > 1.5, "a cut was not noticed: {:.2}", seam(&one));
}

/// The calibration's own measure, and the share of half-opaque pixels over one tile seen from above (96 steps, 80²
/// pixels, rays lean by 1 in 200: within 0.04).
#[test]
fn coverage_is_what_the_scene_asks_for() {
    needs_adapter!();
    for coverage in [0.1, 0.4, 0.7] {
        let scene = from_above(coverage, [0.0, 0.0], TILE_M);
        scene.validate().unwrap();
        let (built, seen) = on_gpu(move |renderer| {
            let view = renderer.view(&scene, size(80, 80)).unwrap();
            let frame = render_view(renderer, &view, &setup("none", ""));
            let covered = frame.radiance.iter().filter(|p| p[3] > 0.5).count() as f64;
            (
                view.density.built.measured_coverage.clone(),
                covered / frame.radiance.len() as f64,
            )
        });
        println!("coverage {coverage}: calibration {built:?}, seen {seen:.3}");
        assert!(
            built.len() == 1 && (built[0] - coverage).abs() <= 0.03,
            "coverage {coverage}: calibrated to {built:?}"
        );
        assert!(
            (seen - coverage).abs() <= 0.04,
            "coverage {coverage}: {seen} of the picture is covered"
        );
    }
}
