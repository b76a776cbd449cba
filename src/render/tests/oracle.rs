//! The oracle against closed forms, in f64: no adapter is needed.

extern crate occlab_render as occlab;

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::formula::{Formula, mapped, marched};
use common::{
    box_scene, cube_density, cumulus, exact_settings, has_map, hashed, setup, size, write_cube,
};
use glam::DVec3;
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::oracle::{Options, Oracle};
use occlab::scene::{Ambient, Container, Density, Scene};
use std::f64::consts::PI;

const ISOTROPIC: f64 = 1.0 / (4.0 * PI);

fn close(what: &str, measured: f64, expected: f64, tolerance: f64) {
    let error = (measured - expected).abs() / expected.abs().max(1e-300);
    assert!(
        error <= tolerance,
        "{what}: {measured}, expected {expected} (relative error {error:.1e})"
    );
}

fn visibility(oracle: &Oracle, setup: &MethodSetup, p: DVec3) -> f64 {
    let occlusion = oracle.prepare(setup, Options::default()).unwrap();
    occlusion.visibility(p, 0.5)
}

/// A slab under an oblique sun, seen on a slanted ray: depth below the top grows linearly along it, so
///   L = p·E·σ∫e^(−σt) e^(−σ(d₀ − t·w_y/s_y)) dt = p·E·e^(−σd₀)(1 − e^(−σmℓ))/m,  m = 1 − w_y/s_y
/// (s toward the sun, w along the ray). Light is constant over a step: about (σmΔ)²/24 of the sum; pixels are f32.
#[test]
fn slab_radiance_under_an_oblique_sun() {
    let (sigma, top) = (0.004, 1000.0);
    let mut scene = box_scene([-5e5, 0.0, -5e5], [5e5, top, 5e5], sigma);
    scene.march.steps = 4096;
    for (elevation, azimuth, forward) in [
        (90.0, 0.0, DVec3::NEG_Y),
        (35.0, 70.0, DVec3::new(1.0, -0.7, 0.3)),
        (35.0, 70.0, DVec3::new(1.0, 0.4, 0.3)),
        (5.0, 200.0, DVec3::new(-0.2, -0.5, 0.9)),
    ] {
        (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (elevation, azimuth);
        let forward = forward.normalize();
        let start = DVec3::new(10.0, if forward.y > 0.0 { 0.0 } else { top }, -20.0);
        scene.camera.position_m = (start - forward * 100.0).into();
        scene.camera.target_m = (start + forward).into();
        scene.camera.up = [1.0, 0.3, 0.1];
        let oracle = Oracle::new(&scene, size(1, 1)).unwrap();
        let frame = oracle
            .render(&setup("srm", "steps=3"), Options::default())
            .unwrap();
        let sun = scene.sun.direction();
        let (ray_length, first_depth) = (top / forward.y.abs(), (top - start.y) / sun.y);
        let m = 1.0 - forward.y / sun.y;
        let expected =
            ISOTROPIC * (-sigma * first_depth).exp() * (1.0 - (-sigma * m * ray_length).exp()) / m;
        let step = sigma * m * ray_length / 4096.0;
        close(
            "radiance",
            frame.radiance[0][0].into(),
            expected,
            step * step / 20.0 + 2e-7,
        );
        close(
            "opacity",
            frame.radiance[0][3].into(),
            1.0 - (-sigma * ray_length).exp(),
            1e-6,
        );
    }
}

/// V in a box is e^(−σ·distance to the nearest wall ahead), to rounding, whatever the steps.
#[test]
fn box_visibility_is_exact() {
    let (low, high) = (
        DVec3::new(-300.0, 100.0, -200.0),
        DVec3::new(400.0, 600.0, 500.0),
    );
    let mut scene = box_scene(low.into(), high.into(), 0.003);
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    let oracle = Oracle::new(&scene, size(8, 8)).unwrap();
    let sun = scene.sun.direction();
    for i in 0..200 {
        let unit = DVec3::from([0, 1, 2].map(|axis| f64::from(hashed(i, axis, 7))));
        let p = low + unit * (high - low);
        let wall = ((high - p) / sun).max((low - p) / sun).min_element();
        let expected = (-0.003 * wall).exp();
        for method in ["srm", "truth"] {
            close(
                method,
                visibility(&oracle, &setup(method, ""), p),
                expected,
                1e-12,
            );
        }
        close("none", visibility(&oracle, &setup("none", ""), p), 1.0, 0.0);
    }
    // Negative control: a shift by half a metre shows.
    let p = low + 0.5 * (high - low);
    let v = |p| visibility(&oracle, &setup("truth", ""), p);
    assert!((v(p) / v(p + 0.5 * sun) - 1.0).abs() > 1e-3);
}

/// σ = σ₀e^(−s/h): τ(L) = σ₀h(1 − e^(−L/h)). Halved steps: midpoint rule (Δ²) 4 times better, end sampling (Δ) twice.
#[test]
fn exponential_atmosphere_and_refinement_order() {
    let (sigma, scale, length) = (0.002, 900.0, 4000.0_f64);
    let ray = Formula {
        length_m: length,
        extinction_per_m: |s: f64| sigma * (-s / scale).exp(),
    };
    let tau = sigma * scale * (1.0 - (-length / scale).exp());
    let error =
        |id: &str, params: &str| (-marched(&setup(id, params), &ray).ln() - tau).abs() / tau;
    assert!(error("truth", "step_m=1") < 1e-7);
    assert!(error("srm", "steps=1000 spacing=uniform") < 1e-6);
    for (id, coarse, fine, ratio) in [
        ("truth", "step_m=40", "step_m=20", 4.0),
        (
            "srm",
            "steps=50 spacing=uniform",
            "steps=100 spacing=uniform",
            4.0,
        ),
        ("srm", "steps=50", "steps=100", 4.0),
        (
            "srm",
            "steps=100 spacing=uniform sampling=end",
            "steps=200 spacing=uniform sampling=end",
            2.0,
        ),
    ] {
        let measured = error(id, coarse) / error(id, fine);
        assert!(
            (measured / ratio - 1.0).abs() < 0.05,
            "{id} {coarse}: {measured}"
        );
    }
    // The same for a map that stores the whole column, at its far end.
    let column = |params: &str| {
        let setup = setup("floor", params);
        (-mapped(&setup, &ray, length).ln() - tau).abs() / tau
    };
    let midpoint = column("steps=50") / column("steps=100");
    let end = column("steps=100 sampling=end") / column("steps=200 sampling=end");
    assert!((midpoint / 4.0 - 1.0).abs() < 0.05, "{midpoint}");
    assert!((end / 2.0 - 1.0).abs() < 0.05, "{end}");
}

/// The view march: constant extinction and linear light over a step, error Δ².
#[test]
fn view_steps_refine_quadratically() {
    let (sigma, height) = (0.004, 1000.0);
    let mut scene = box_scene([-5e3, 0.0, -5e3], [5e3, height, 5e3], sigma);
    scene.camera.position_m = [0.0, 2000.0, 0.0];
    scene.camera.target_m = [0.0, 0.0, 0.0];
    scene.camera.up = [1.0, 0.0, 0.0];
    let expected = ISOTROPIC * 0.5 * (1.0 - (-2.0 * sigma * height).exp());
    let error = |steps: u32| {
        let mut scene = scene.clone();
        scene.march.steps = steps;
        let oracle = Oracle::new(&scene, size(1, 1)).unwrap();
        let frame = oracle
            .render(&setup("srm", ""), Options::default())
            .unwrap();
        (f64::from(frame.radiance[0][0]) - expected).abs()
    };
    let ratio = error(16) / error(32);
    assert!((ratio / 4.0 - 1.0).abs() < 0.05, "{ratio}");
}

/// Furnace: albedo 1, uniform ambient radiance A, no sun, in front of black: L = A(1 − T), so that before a background of
/// A nothing would be gained or lost. (A scene's background is black or a sky; the identity is the sum of weights.)
#[test]
fn a_furnace_neither_gains_nor_loses() {
    for mut scene in [box_scene([0.0; 3], [800.0; 3], 0.004), cumulus()] {
        let ambient = [0.5, 1.0, 2.0];
        scene.sun.irradiance = Some([0.0; 3]);
        scene.ambient = Some(Ambient::Uniform { radiance: ambient });
        let oracle = Oracle::new(&scene, size(24, 14)).unwrap();
        let frame = oracle
            .render(&setup("srm", ""), Options::default())
            .unwrap();
        assert!(frame.radiance.iter().any(|p| p[3] > 0.5));
        for p in &frame.radiance {
            for (value, a) in p.iter().zip(ambient) {
                assert!(
                    (f64::from(*value) - a * f64::from(p[3])).abs() <= 2e-7 * a,
                    "{p:?}"
                );
            }
        }
    }
}

fn rough(folder: &std::path::Path) -> Scene {
    let mut scene = box_scene([-300.0, 100.0, -200.0], [400.0, 600.0, 500.0], 0.01);
    scene.density = cube_density(write_cube(folder, 12, hashed));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    scene
}

/// T(a → b) = T(b → a) along a light ray and its reverse, in steps that divide the distance.
#[test]
fn transmittance_is_reciprocal() {
    let folder = tempfile::tempdir().unwrap();
    let scene = rough(folder.path());
    let mut back = scene.clone();
    back.sun.elevation_deg *= -1.0;
    back.sun.azimuth_deg += 180.0;
    let oracle = Oracle::new(&scene, size(4, 4)).unwrap();
    let reverse = oracle.again(&back, size(4, 4)).unwrap();
    for i in 0..20 {
        let unit = DVec3::from([0, 1, 2].map(|axis| f64::from(hashed(i, axis, 3))));
        let middle = DVec3::new(-300.0, 100.0, -200.0) + unit * DVec3::new(700.0, 500.0, 700.0);
        let column = oracle.column_through(middle);
        let length = column.length_m();
        let step = format!("step_m={}", length / 499.5);
        let (top, bottom) = (column.point(0.0), column.point(length));
        let there = visibility(&oracle, &setup("truth", &step), bottom);
        let step = format!("step_m={}", length / 500.0);
        let exact = visibility(&oracle, &setup("truth", &step), bottom);
        let again = visibility(&reverse, &setup("truth", &step), top);
        assert!(exact < 0.9, "{exact}");
        close("back", again, exact, 1e-9);
        // Negative control: with other steps the value differs, so that the comparison depends on the samples.
        assert!((there / exact - 1.0).abs() > 1e-12);
    }
}

/// τ(a → c) = τ(a → b) + τ(b → c): marches from points a whole number of steps apart share their samples.
#[test]
fn optical_depth_is_additive() {
    let folder = tempfile::tempdir().unwrap();
    let scene = rough(folder.path());
    let oracle = Oracle::new(&scene, size(4, 4)).unwrap();
    let column = oracle.column_through(DVec3::new(50.0, 300.0, 150.0));
    let step = column.length_m() / 400.0;
    let truth = oracle
        .prepare(
            &setup("truth", &format!("step_m={step}")),
            Options::default(),
        )
        .unwrap();
    let depths = [100.0 * step, 250.0 * step, 380.0 * step];
    let tau: Vec<f64> = truth
        .along(&column, &depths)
        .iter()
        .map(|v| -v.ln())
        .collect();
    let between = |from: i32, to: i32| -> f64 {
        let sample = |k| oracle.extinction_per_m(column.point((f64::from(k) + 0.5) * step));
        (from..to).map(|k| sample(k) * step).sum()
    };
    close("a to b", tau[1], tau[0] + between(100, 250), 1e-9);
    close(
        "a to c",
        tau[2],
        tau[0] + between(100, 250) + between(250, 380),
        1e-9,
    );
    assert!(tau[0] > 0.1 && tau[2] > tau[1] && tau[1] > tau[0]);
}

/// Σ Δt of light rays through a shell, from V = e^(−σd), against chords of circles: grazing, and through the empty inside.
#[test]
fn light_rays_are_as_long_as_chords() {
    let (r, base, top) = (2e5, 1000.0, 4000.0);
    let mut scene = box_scene([0.0; 3], [1.0; 3], 1e-4);
    scene.container = Container::Shell {
        planet_radius_m: r,
        base_m: base,
        top_m: top,
    };
    let mut gaps = 0;
    for elevation in [90.0, 30.0, 5.0, 1.0, 0.1, 0.01_f64] {
        scene.sun.elevation_deg = elevation;
        let oracle = Oracle::new(&scene, size(1, 1)).unwrap();
        let sun = scene.sun.direction();
        for angle_deg in [0.0, -2.0, -5.0, -8.0, -9.0_f64] {
            let radius = r + 2500.0;
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let from_centre = DVec3::new(radius * sin, radius * cos, 0.0);
            let p = from_centre - DVec3::Y * r;
            let (along, chord) = (from_centre.dot(sun), |height: f64| {
                let b2 = radius * radius - from_centre.dot(sun).powi(2);
                ((r + height).powi(2) - b2).max(0.0).sqrt()
            });
            let inside = if along < 0.0 { 2.0 * chord(base) } else { 0.0 };
            let expected = chord(top) - along - inside;
            let blocked = along < 0.0 && chord(0.0) > 0.0;
            gaps += usize::from(inside > 0.0 && !blocked);
            for method in ["srm", "truth"] {
                let v = visibility(&oracle, &setup(method, ""), p);
                if blocked {
                    assert_eq!(v, 0.0, "the ground must block");
                } else {
                    let what = format!("{method}, sun {elevation}°, {angle_deg}° away");
                    close(&what, -v.ln() / 1e-4, expected, 1e-8);
                }
            }
        }
    }
    assert!(gaps > 0, "no ray crossed the inside");
}

/// A homogeneous column is the case that maps are exact for: V = e^(−σd) behind the front. ESM with c = σL. At single depths,
/// models without that function may be off by twice their relative RMSE over a picture.
#[test]
fn maps_are_exact_for_homogeneous_columns() {
    let (sigma, length) = (0.003, 1200.0);
    let ray = Formula {
        length_m: length,
        extinction_per_m: |_: f64| sigma,
    };
    let maps = REGISTRY.iter().filter(|method| has_map(method.info().id));
    let exact = maps.flat_map(|method| {
        let settings = exact_settings(method.info(), sigma * length).into_iter();
        settings.map(|params| (method.info().id, method.homogeneous_error(), params))
    });
    for (id, inexact, params) in exact {
        for depth in [0.0, 37.0, 600.0, 1200.0] {
            let v = mapped(&setup(id, &params), &ray, depth);
            let expected = (-sigma * depth).exp();
            let what = format!("{id} {params} at {depth} m");
            if inexact == 0.0 {
                close(&what, v, expected, 1e-9);
            } else {
                assert!(
                    (v - expected).abs() < 2.0 * inexact,
                    "{what}: {v}, not {expected}"
                );
            }
        }
    }
}

/// One dense step: the Fourier series of a spike at x₀ has a closed form, τ(x) = w[x + Σ (sin 2πk(x − x₀) + sin
/// 2πkx₀)/(πk)].
#[test]
fn fourier_series_of_a_spike() {
    let (length, steps, hit) = (1000.0, 50, 12);
    let step = length / f64::from(steps);
    let ray = Formula {
        length_m: length,
        extinction_per_m: |s: f64| if (s / step) as i32 == hit { 0.05 } else { 0.0 },
    };
    let (weight, x0) = (0.05 * step, (f64::from(hit) + 0.5) / f64::from(steps));
    let setup = setup("fom", "order=4 steps=50");
    for x in [0.1, 0.3, 0.62, 1.0] {
        let wave = |k: i32| {
            let turn = 2.0 * PI * f64::from(k);
            ((turn * (x - x0)).sin() + (turn * x0).sin()) / (PI * f64::from(k))
        };
        let tau: f64 = weight * (x + (1..=4).map(wave).sum::<f64>());
        let v = mapped(&setup, &ray, x * length);
        close("V", v, (-tau.max(0.0)).exp(), 1e-9);
    }
}

/// Skipping what is provably empty changes no bit.
#[test]
fn skipping_changes_nothing() {
    let scene = cumulus();
    assert!(matches!(scene.density, Density::Procedural(_)));
    let oracle = Oracle::new(&scene, size(24, 14)).unwrap();
    for (id, params) in [
        ("truth", "step_m=25"),
        ("srm", ""),
        ("floor", "resolution=64 steps=40"),
    ] {
        let setup = setup(id, params);
        let every = Options {
            skip: false,
            ..Options::default()
        };
        let frame = oracle.render(&setup, Options::default()).unwrap();
        assert!(frame.sun.iter().any(|p| p[0] > 0.0));
        assert_eq!(frame, oracle.render(&setup, every).unwrap(), "{id}");
    }
}
