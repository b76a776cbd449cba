//! Requirements on every occlusion method, checked over the registry.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "contract/descriptions.rs"]
mod descriptions;

use common::{
    box_scene, count_view, cube_density, cumulus, exact_settings, has_map, hashed, on_gpu,
    pixel_ray, relative_rmse, render, render_view, size, with_map, write_cube,
};
use occlab::frame::{Frame, is_nonfinite};
use occlab::occlusion::twin::{self, Twin};
use occlab::occlusion::{
    GEOMETRY, LightOcclusion, Marker, MethodInfo, MethodSetup, REGISTRY, Role, TEXELS, Trials,
};
use occlab::param::Params;
use occlab::scene::ImageSize;
use occlab::scene::{Ambient, Density, Scene, Sky};

const IMAGE: ImageSize = ImageSize {
    width: 16,
    height: 12,
};
/// Resolution of small maps: the scenes are smooth.
const SMALL_MAP: &str = "resolution=128 steps=64";

fn ids() -> impl Iterator<Item = &'static str> {
    REGISTRY.iter().map(|m| m.info().id)
}

/// The method with a small map if it has one, and `extra` parameters.
fn small(id: &str, extra: &str) -> MethodSetup {
    with_map(id, SMALL_MAP, extra)
}

/// A missing uniform member or binding is an error of `prepare`.
#[test]
fn every_binding_is_supplied_in_a_scene_with_every_feature() {
    needs_adapter!();
    let mut scene = cumulus();
    scene.sky = Some(Sky::Preetham {
        turbidity: 3.0,
        ground_albedo: 0.2,
    });
    scene.ambient = Some(Ambient::Sky {
        base: 0.5,
        top: 1.0,
    });
    let Density::Procedural(field) = &mut scene.density else {
        unreachable!()
    };
    let mut second = field.decks[0].clone();
    second.coverage = 0.2;
    field.decks.push(second);
    scene.validate().unwrap();
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, size(4, 3)).unwrap();
        for id in ids() {
            let frame = render_view(renderer, &view, &small(id, ""));
            assert_finite(id, &frame);
            let counts = count_view(renderer, &view, &small(id, ""));
            assert!(counts.samples.view > 0, "{id}");
            assert_eq!(
                counts.look_ups > 0,
                has_map(id) && counts.samples.view > 0 && frame.radiance.iter().any(|p| p[3] > 0.0),
                "{id}"
            );
        }
    });
}

/// A layer 1 km thick and wide enough that no ray that matters meets a side; the camera is inside.
fn layer(extinction: f64, elevation_deg: f64) -> Scene {
    let mut scene = box_scene(
        [-6000.0, 0.0, -6000.0],
        [6000.0, 1000.0, 6000.0],
        extinction,
    );
    scene.sun.elevation_deg = elevation_deg;
    scene.sun.azimuth_deg = 35.0;
    scene.camera.position_m = [10.0, 480.0, 20.0];
    scene.camera.target_m = [1000.0, 380.0, 400.0];
    scene.camera.fov_y_deg = 60.0;
    scene.camera.far_m = Some(2500.0);
    scene.march.steps = 256;
    scene
}

#[test]
fn nothing_is_shadowed_where_there_is_nothing() {
    needs_adapter!();
    for id in ids() {
        // σ·1 km = 1e-9 rounds away: V must be 1 (ESM: its front is never reached) but for the few ulp that WGSL grants
        // exp, (3 + 2|x|), and division, 2.5.
        let frame = render(&layer(1e-12, 40.0), IMAGE, &small(id, ""));
        let worst = frame
            .sun
            .iter()
            .map(|p| (p[3] - 1.0).abs())
            .fold(0.0, f32::max);
        assert!(worst <= 1e-6, "{id}: V in vacuum is off by {worst:e}");
        let vacuum = render(&layer(0.0, 40.0), IMAGE, &small(id, ""));
        assert!(
            vacuum
                .radiance
                .iter()
                .chain(&vacuum.sun)
                .flatten()
                .all(|v| *v == 0.0),
            "{id}: light from vacuum"
        );
    }
}

/// Mean V of a pixel of the homogeneous layer: midpoint quadrature in f64; the top is the only way out.
fn expected_v(scene: &Scene, column: u32, row: u32) -> f64 {
    let (ray, sun) = (pixel_ray(scene, IMAGE, column, row), scene.sun.direction());
    let (y, sigma) = (scene.camera.position_m[1], scene.medium.extinction_per_m);
    let wall = if ray.y > 0.0 {
        (1000.0 - y) / ray.y
    } else {
        -y / ray.y
    };
    let (length, n) = (wall.min(2500.0), 4000);
    let (mut sum, mut weights) = (0.0, 0.0);
    for k in 0..n {
        let t = (f64::from(k) + 0.5) * length / f64::from(n);
        let weight = (-sigma * t).exp();
        sum += weight * (-sigma * (1000.0 - y - t * ray.y) / sun.y).exp();
        weights += weight;
    }
    sum / weights
}

/// A homogeneous layer is exact in every method's model: V = exp(−σd). Tolerances, relative RMSE of V: 1e-4 (256 view
/// steps, f32 sums; measured 1e-5), with f16 texels 2e-3 (coefficients good to 2⁻¹¹, τ up to 4). ESM, of extinction
/// c/L_max, gets c = σ·L_max and, like BSM, the front at the near edge: the threshold 0.99 leaves out τ = 0.01. A model that
/// does not contain e^(−σd) says how far off it is: [`LightOcclusion::homogeneous_error`].
#[test]
fn a_homogeneous_layer_is_exact() {
    needs_adapter!();
    for elevation in [90.0, 30.0] {
        let sigma = 0.0023;
        let scene = layer(sigma, elevation);
        let longest_m = 1000.0 / elevation.to_radians().sin();
        for method in REGISTRY {
            let (info, inexact) = (method.info(), method.homogeneous_error());
            let id = info.id;
            for (extra, rounding) in exact_variants(info, sigma * longest_m) {
                let tolerance = rounding + inexact;
                let frame = render(&scene, IMAGE, &small(id, &extra));
                let pixels = (0..IMAGE.height).flat_map(|j| (0..IMAGE.width).map(move |i| (i, j)));
                let pairs = frame
                    .sun
                    .iter()
                    .zip(pixels)
                    .map(|(p, (i, j))| (f64::from(p[3]), expected_v(&scene, i, j)));
                let error = relative_rmse(pairs);
                println!("{id} {extra} sun {elevation}°: {error:.1e}");
                assert!(
                    error <= tolerance,
                    "{id} {extra}, sun {elevation}°: relative RMSE {error:.2e} of V"
                );
            }
        }
        let lit = render(&scene, IMAGE, &small("none", ""));
        let error = relative_rmse(
            lit.sun
                .iter()
                .map(|p| (f64::from(p[3]), expected_v(&scene, 8, 6))),
        );
        assert!(
            error > 0.5,
            "the comparison cannot tell V = 1 from the truth"
        );
    }
}

/// The method's exact settings with their tolerances; of a map the first at each look-up too, in f16.
fn exact_variants(info: &MethodInfo, tau: f64) -> Vec<(String, f64)> {
    let exact = exact_settings(info, tau);
    if !has_map(info.id) {
        return exact.into_iter().map(|own| (own, 1e-4)).collect();
    }
    let first = exact.iter().take(1);
    let half = first.flat_map(|own| {
        let look_ups = ["nearest", "hardware", "blend"];
        look_ups.map(|l| (format!("{own} storage=f16 lookup={l}"), 2e-3))
    });
    let single = exact
        .iter()
        .map(|own| (format!("{own} storage=f32 lookup=blend"), 1e-4));
    half.chain(single).collect()
}

fn assert_finite(what: &str, frame: &Frame) {
    let bad = frame
        .radiance
        .iter()
        .chain(&frame.sun)
        .flatten()
        .filter(|v| is_nonfinite(**v))
        .count();
    assert_eq!(bad, 0, "{what}: {bad} values are not finite");
    assert!(
        frame.sun.iter().all(|p| (0.0..=1.0 + 1e-5).contains(&p[3])),
        "{what}: V outside of [0, 1]"
    );
}

/// Only stable forms must be finite, at every option; the published ones are kept to show where they fail.
#[test]
fn extreme_media_give_finite_pictures() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let denormal = write_cube(folder.path(), 8, |x, y, z| {
        if hashed(x, y, z) < 0.5 {
            1e-40
        } else {
            f32::from_bits(1)
        }
    });
    let other = tempfile::tempdir().unwrap();
    let contrast = write_cube(other.path(), 8, |x, y, z| {
        if hashed(x, y, z) < 0.5 { 1e-40 } else { 1e30 }
    });
    for method in REGISTRY {
        let id = method.info().id;
        let mut extras = own_choices(method.info());
        if has_map(id) {
            extras.push("storage=f32 lookup=nearest".to_owned());
        }
        for extra in &extras {
            for extinction in [1e6, 1e-30] {
                assert_finite(
                    &format!("{id} {extra}, σ = {extinction}"),
                    &render(&layer(extinction, 30.0), IMAGE, &small(id, extra)),
                );
            }
            for (path, extinction) in [(&denormal, 1.0), (&denormal, 1e6), (&contrast, 1.0)] {
                let mut scene = layer(extinction, 30.0);
                scene.density = cube_density(path.clone());
                assert_finite(
                    &format!("{id} {extra}, {} at σ = {extinction}", path.display()),
                    &render(&scene, IMAGE, &small(id, extra)),
                );
            }
        }
    }
}

/// The method's defaults, and every option of the choices that not all maps share, one at a time.
fn own_choices(info: &'static MethodInfo) -> Vec<String> {
    let own = info.specs().filter(|spec| {
        let mut maps = GEOMETRY.iter().chain(TEXELS);
        let shared = maps.any(|map| map.name == spec.name);
        !shared && spec.is_everyday()
    });
    let set = own.flat_map(|spec| {
        let options = spec.everyday_options();
        options.map(|option| format!("{}={option}", spec.name))
    });
    [String::new()].into_iter().chain(set).collect()
}

/// V = ½, from a file that is not among the program's.
struct Half;

impl LightOcclusion for Half {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "half",
            title: "Half",
            summary: "V = 1/2",
            texel: "–",
            expect: "Every shadow is the same.",
            citation: "This test",
            role: Role::Unshadowed,
            colour: 0x80_80_80,
            marker: Marker::Down,
            shader: "elsewhere/half.wgsl",
            source: "fn light_transmittance(p: vec3f, rnd: f32) -> f32 { return 0.5; }",
            params: &[],
            monotone: true,
            bounded: false,
            tolerance: 1e-5,
            trials: Trials {
                pictures: &[],
                clouds: &[],
                texels: &[],
                exact: &[],
            },
        }
    }

    fn oracle(&self, _params: &Params) -> occlab::Result<Twin> {
        Ok(Twin::March(Box::new(Half)))
    }
}

impl twin::LightMarch for Half {
    fn transmittance(&self, _ray: &dyn twin::LightRay, _rnd: f64) -> f64 {
        0.5
    }
}

#[test]
fn a_method_that_is_not_registered_brings_its_own_shader() {
    needs_adapter!();
    let setup = MethodSetup::new(&Half);
    let frame = render(&layer(1e-3, 40.0), IMAGE, &setup);
    assert!(frame.sun.iter().all(|p| (p[3] - 0.5).abs() < 1e-6));
    assert!(frame.radiance.iter().any(|p| p[0] > 0.0));
}

/// V down one vertical light column, through a medium that varies from cell to cell but not along the view.
#[test]
fn monotone_methods_never_brighten_with_depth() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let gaps = |x: usize, y: usize| {
        if hashed(x, y, 7) < 0.4 {
            0.0
        } else {
            0.05 + hashed(x, y, 9)
        }
    };
    let mut scene = box_scene([0.0; 3], [1000.0; 3], 0.01);
    scene.density = cube_density(write_cube(folder.path(), 16, |x, y, _| gaps(x, y)));
    // From 100 km a ray rises by at most 5 m on its way through the box, less than a third of a pixel: no two pixels of
    // a column see the same heights.
    scene.camera.fov_y_deg = 0.57;
    scene.march.steps = 32;
    let mut tested = 0;
    for x in [437.0, 561.0, 689.0] {
        (scene.camera.position_m, scene.camera.target_m) = ([x, 500.0, -1e5], [x, 500.0, 500.0]);
        for method in REGISTRY.iter().filter(|m| m.info().monotone) {
            let id = method.info().id;
            for extra in own_choices(method.info()) {
                let lookup = if has_map(id) { "lookup=nearest" } else { "" };
                let frame = render(
                    &scene,
                    size(1, 64),
                    &small(id, &format!("{extra} {lookup}")),
                );
                let v: Vec<f32> = frame
                    .sun
                    .iter()
                    .zip(&frame.radiance)
                    .filter(|(_, p)| p[3] > 0.0)
                    .map(|(s, _)| s[3])
                    .collect();
                assert!(
                    v.len() > 30,
                    "{id}: the column must hold medium, {} pixels do",
                    v.len()
                );
                // Rounding of exp and of the weighted mean.
                assert!(
                    v.windows(2).all(|w| w[1] <= w[0] + 1e-6),
                    "{id} {extra} at x = {x}: {v:?}"
                );
                assert!(
                    method.info().role == Role::Unshadowed || v[v.len() - 1] < 0.9 * v[0],
                    "{id} {extra}: nothing to see, {v:?}"
                );
                tested += 1;
            }
        }
    }
    assert!(tested >= 3 * 6, "only {tested} columns were tested");
}
