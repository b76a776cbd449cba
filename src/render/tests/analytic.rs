//! Pictures against closed forms and against small f64 quadratures written here.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{
    box_scene, cumulus, henyey_greenstein, pixel_ray, relative_rmse, render, setup, size,
};
use glam::DVec3;
use occlab::scene::{Ambient, Container, Density, Lobe, Scene, Uniform};

const ISOTROPIC: f64 = 1.0 / (4.0 * std::f64::consts::PI);

fn close(what: &str, measured: f32, expected: f64, tolerance: f64) {
    let error = (f64::from(measured) - expected).abs() / expected.abs();
    assert!(
        error <= tolerance,
        "{what}: {measured}, expected {expected} (relative error {error:.1e})"
    );
}

/// One pixel that looks along `forward` from `position`.
fn single_pixel(scene: &mut Scene, position: DVec3, forward: DVec3) {
    scene.camera.position_m = position.into();
    scene.camera.target_m = (position + forward * 1000.0).into();
    scene.camera.up = if forward.y.abs() > 0.9 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
}

/// Sun overhead, homogeneous layer of thickness H.
///   horizontal ray at depth d: L = p·E·e^(−σd)·(1 − e^(−σℓ))     (V constant: exact in every step, f32 rounding only)
///   straight down:             L = p·E·(1 − e^(−2σH))/2           (midpoint rule: (σΔ)²/24 < 1e-6 at 512 steps)
#[test]
fn homogeneous_slab_has_its_closed_form() {
    needs_adapter!();
    let (sigma, height) = (0.004, 1000.0);
    let mut scene = box_scene([0.0; 3], [800.0, height, 800.0], sigma);
    scene.march.steps = 512;
    for method in ["truth", "srm"] {
        for depth in [1.0, 100.0, 500.0, 950.0] {
            single_pixel(
                &mut scene,
                DVec3::new(-300.0, height - depth, 400.0),
                DVec3::X,
            );
            let frame = render(&scene, size(1, 1), &setup(method, ""));
            let opacity = 1.0 - (-sigma * 800.0_f64).exp();
            let v = (-sigma * depth).exp();
            close(
                "radiance",
                frame.radiance[0][0],
                ISOTROPIC * v * opacity,
                1e-4,
            );
            close("V", frame.sun[0][3], v, 1e-4);
            close("opacity", frame.radiance[0][3], opacity, 1e-5);
        }
        single_pixel(&mut scene, DVec3::new(400.0, 5000.0, 400.0), DVec3::NEG_Y);
        let frame = render(&scene, size(1, 1), &setup(method, ""));
        close(
            "from above",
            frame.radiance[0][0],
            ISOTROPIC * 0.5 * (1.0 - (-2.0 * sigma * height).exp()),
            1e-4,
        );
    }
}

/// Distance from `p` (inside) to the surface of the box, by the nearest wall ahead.
fn wall_distance(p: DVec3, direction: DVec3, low: DVec3, high: DVec3) -> f64 {
    let ahead = |i: usize| {
        if direction[i] > 0.0 {
            (high[i] - p[i]) / direction[i]
        } else {
            (low[i] - p[i]) / direction[i]
        }
    };
    (0..3)
        .filter(|i| direction[*i] != 0.0)
        .map(ahead)
        .fold(f64::INFINITY, f64::min)
}

/// Where a ray enters the box, if it does.
fn entry(o: DVec3, direction: DVec3, low: DVec3, high: DVec3) -> Option<f64> {
    let (a, b) = ((low - o) / direction, (high - o) / direction);
    let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
    (leave > enter).then_some(enter)
}

/// L/(p·E) = ∫σ e^(−σt) e^(−σ·(distance to the wall toward the sun)) dt, 2000 midpoints.
fn box_reference(scene: &Scene, ray: DVec3, low: DVec3, high: DVec3) -> f64 {
    let (origin, sun, sigma) = (
        DVec3::from(scene.camera.position_m),
        scene.sun.direction(),
        scene.medium.extinction_per_m,
    );
    let Some(enter) = entry(origin, ray, low, high) else {
        return 0.0;
    };
    let length = wall_distance(origin + ray * (enter + 1e-9), ray, low, high);
    let step = length / 2000.0;
    let sum = |k: i32| {
        let t = (f64::from(k) + 0.5) * step;
        sigma
            * (-sigma * (t + wall_distance(origin + ray * (enter + t), sun, low, high))).exp()
            * step
    };
    (0..2000).map(sum).sum()
}

/// An oblique sun leaves through three walls. 128 view steps and up to 350 light steps: the kinks between walls
/// cost O(Δ²), below 1e-3.
#[test]
fn homogeneous_box_agrees_with_ray_box_distances() {
    needs_adapter!();
    let (low, high) = (
        DVec3::new(-300.0, 100.0, -200.0),
        DVec3::new(400.0, 600.0, 500.0),
    );
    let mut scene = box_scene(low.into(), high.into(), 0.006);
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    scene.camera.position_m = [-500.0, 900.0, -1400.0];
    scene.camera.fov_y_deg = 45.0;
    scene.march.steps = 128;
    let image = size(20, 14);
    let frame = render(&scene, image, &setup("truth", "step_m=2.5"));
    let expected: Vec<f64> = (0..image.width * image.height)
        .map(|i| {
            ISOTROPIC
                * box_reference(
                    &scene,
                    pixel_ray(&scene, image, i % image.width, i / image.width),
                    low,
                    high,
                )
        })
        .collect();
    assert!(
        expected.iter().filter(|v| **v > 0.0).count() > 30 && expected[0] == 0.0,
        "the box must be inside the picture"
    );
    let pairs = |shift: usize| {
        frame
            .radiance
            .iter()
            .zip(expected[shift..].iter())
            .map(|(a, b)| (f64::from(a[0]), *b))
    };
    let error = relative_rmse(pairs(0));
    println!("box: relative RMSE {error:.1e}");
    assert!(error <= 1e-3, "relative RMSE {error:.2e}");
    assert!(
        relative_rmse(pairs(1)) > 0.05,
        "a picture shifted by a pixel passed"
    );
}

/// Furnace: albedo 1 in uniform ambient light and no sun, against black, gives ambient × opacity. Both are sums of the
/// same weights: 64 roundings of 2⁻²⁴.
#[test]
fn a_furnace_returns_what_it_receives() {
    needs_adapter!();
    let mut plain = box_scene([0.0; 3], [800.0; 3], 0.004);
    plain.march.jitter = true;
    for mut scene in [plain, cumulus()] {
        let ambient = [0.5, 1.0, 2.0];
        scene.sun.irradiance = Some([0.0; 3]);
        scene.ambient = Some(Ambient::Uniform { radiance: ambient });
        let frame = render(&scene, size(12, 8), &setup("none", ""));
        assert!(
            frame.radiance.iter().any(|p| p[3] > 0.3),
            "{}: nothing in the furnace",
            scene.name
        );
        for pixel in &frame.radiance {
            for (value, received) in pixel.iter().zip(ambient) {
                let expected = received as f32 * pixel[3];
                assert!(
                    (value - expected).abs() <= 1e-5 * received as f32,
                    "{}: {value} for {expected}",
                    scene.name
                );
            }
        }
    }
}

/// Length of a light ray through a shell, from V = e^(−σd) in a uniform medium, against f64 intervals; steps of 10 m
/// over up to 35 km. f32 grants n·2⁻²³ of the sum, 4e-4, and V of about e⁻¹ a few ulp.
#[test]
fn light_rays_are_as_long_as_the_layer() {
    needs_adapter!();
    let shell = Container::Shell {
        planet_radius_m: 2e5,
        base_m: 1000.0,
        top_m: 4000.0,
    };
    let mut scene = box_scene([0.0; 3], [1.0; 3], 1.0);
    scene.container = shell.clone();
    scene.camera.far_m = Some(1.0);
    scene.march.steps = 1;
    let mut gaps = 0;
    // Away from the sun the ground tilts by 1° each 3.5 km: rays dip, and the last ones cross the empty inside.
    for (elevation, x) in [
        (90.0, 0.0),
        (30.0, 0.0),
        (5.0, 0.0),
        (0.5, 0.0),
        (0.5, -1e4),
        (1.0, -2.5e4),
        (1.0, -2.9e4),
        (1.0, -3.0e4),
    ] {
        scene.sun.elevation_deg = elevation;
        let radius: f64 = 2e5 + 2500.0;
        let position = DVec3::new(x, (radius * radius - x * x).sqrt() - 2e5, 0.0);
        let sample = position + DVec3::Z * 0.5;
        let intervals = shell.intervals(sample, scene.sun.direction(), 0.0, 1e30);
        let length: f64 = intervals.iter().map(|(a, b)| (b - a).max(0.0)).sum();
        gaps += usize::from(intervals.iter().all(|(a, b)| b - a > 1.0));
        single_pixel(&mut scene, position, DVec3::Z);
        scene.medium.extinction_per_m = 1.0 / length;
        let frame = render(&scene, size(1, 1), &setup("truth", "step_m=10"));
        let measured = -f64::from(frame.sun[0][3]).ln() * length;
        println!("sun {elevation}°, x = {x} m: {measured:.1} m, expected {length:.1} m");
        assert!(
            (measured / length - 1.0).abs() <= 1e-3,
            "sun {elevation}°, x = {x} m: {measured} m, expected {length} m"
        );
    }
    assert!(gaps >= 1, "no ray crossed the gap");
    // Negative control: the shadow of the ground.
    scene.sun.elevation_deg = 0.5;
    single_pixel(&mut scene, DVec3::new(-4.2e4, -2000.0, 0.0), DVec3::Z);
    let frame = render(&scene, size(1, 1), &setup("truth", ""));
    assert!(
        frame.radiance[0][3] > 0.0 && frame.sun[0][3] == 0.0,
        "the ground must block the sun"
    );
}

/// p(θ) = L/(opacity·E·V) in a thin medium around the camera. Near the peak of g = 0.99 an f32 cosine, good to about
/// 1e-7, is worth up to 1e-7·3g/(1 − g)² = 3e-3 of p.
#[test]
fn rendered_light_follows_the_phase_function() {
    needs_adapter!();
    for lobes in [
        &[(0.0, 1.0)][..],
        &[(0.6, 1.0)],
        &[(0.99, 1.0)],
        &[(-0.99, 1.0)],
        &[(0.7, 0.6), (-0.2, 0.4)],
    ] {
        let density = |cosine: f64| {
            lobes
                .iter()
                .map(|(g, w)| w * henyey_greenstein(*g, cosine))
                .sum::<f64>()
        };
        // ∫p dω = 2π∫p d(cos θ); cos θ = 1 − 2u⁴ (or −1 + 2u⁴) puts the nodes where a sharp peak is.
        let backward = lobes[0].0 < 0.0;
        let n = 20_000;
        let node = |k: i32| {
            let u = (f64::from(k) + 0.5) / f64::from(n);
            let cosine = if backward {
                2.0 * u.powi(4) - 1.0
            } else {
                1.0 - 2.0 * u.powi(4)
            };
            2.0 * std::f64::consts::PI * density(cosine) * 8.0 * u.powi(3) / f64::from(n)
        };
        let total: f64 = (0..n).map(node).sum();
        assert!(
            (total - 1.0).abs() < 1e-4,
            "{lobes:?} integrates to {total}"
        );

        let mut scene = box_scene([-100.0; 3], [100.0; 3], 1e-5);
        scene.medium.phase = lobes
            .iter()
            .map(|(g, weight)| Lobe {
                g: *g,
                weight: *weight,
            })
            .collect();
        (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (25.0, 10.0);
        scene.march.steps = 4;
        let sun = scene.sun.direction();
        let mut extremes = (1.0_f64, -1.0_f64);
        for forward in [sun, -sun, DVec3::Z] {
            single_pixel(&mut scene, DVec3::ZERO, forward);
            scene.camera.fov_y_deg = 100.0;
            let image = size(9, 9);
            let frame = render(&scene, image, &setup("none", ""));
            for (i, (radiance, lit)) in (0..).zip(frame.radiance.iter().zip(&frame.sun)) {
                let cosine = pixel_ray(&scene, image, i % 9, i / 9).dot(sun);
                extremes = (extremes.0.min(cosine), extremes.1.max(cosine));
                let measured = lit[0] / (radiance[3] * lit[3]);
                // Opacity is 1 − T, known to 2⁻²⁴ of 1: take the exact one of this ray, σℓ ≪ 1.
                let length = wall_distance(
                    DVec3::ZERO,
                    pixel_ray(&scene, image, i % 9, i / 9),
                    DVec3::splat(-100.0),
                    DVec3::splat(100.0),
                );
                let exact = lit[0] / (1.0 - (-1e-5 * length).exp()) as f32;
                assert!((measured / exact - 1.0).abs() < 1e-3, "opacity");
                close(
                    &format!("{lobes:?} at cos θ = {cosine}"),
                    exact,
                    density(cosine),
                    5e-3,
                );
            }
        }
        assert!(extremes.0 < -0.9999 && extremes.1 > 0.9999, "{extremes:?}");
    }
}

/// Opacity does not depend on how long the light rays are. 400 view × 400 light steps are 160 000 turns of a loop in one
/// invocation: Mesa's llvmpipe ends the loops of an invocation after 65 535 turns in all (LP_MAX_TGSI_LOOP_ITERATIONS).
#[test]
fn long_marches_are_not_cut_short() {
    needs_adapter!();
    let mut scene = box_scene([0.0; 3], [800.0; 3], 0.001);
    scene.march.steps = 400;
    single_pixel(&mut scene, DVec3::new(-300.0, 400.0, 400.0), DVec3::X);
    for steps in [100, 170, 400, 1000] {
        let frame = render(
            &scene,
            size(1, 1),
            &setup("srm", &format!("steps={steps} spacing=uniform")),
        );
        println!(
            "{steps} light steps: opacity {}, V {}",
            frame.radiance[0][3], frame.sun[0][3]
        );
        close(
            &format!("opacity at {steps} light steps"),
            frame.radiance[0][3],
            1.0 - (-0.8_f64).exp(),
            1e-4,
        );
        close(
            &format!("V at {steps} light steps"),
            frame.sun[0][3],
            (-0.4_f64).exp(),
            1e-4,
        );
    }
}

/// Extinction is density × `extinction_per_m`: density 2 at σ/2 is the same medium.
#[test]
fn density_and_extinction_multiply() {
    needs_adapter!();
    let mut scene = box_scene([0.0; 3], [800.0; 3], 0.004);
    let one = render(&scene, size(6, 4), &setup("srm", ""));
    scene.density = Density::Uniform(Uniform { value: 2.0 });
    scene.medium.extinction_per_m = 0.002;
    assert_eq!(render(&scene, size(6, 4), &setup("srm", "")), one);
}
