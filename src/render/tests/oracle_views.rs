//! Device against oracle, whole views: sky, ambient, decks, gaps of a shell, columns without a front.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::agreement::{IMAGE, agreement, error, rough_volume, small};
use common::{box_scene, cumulus, on_gpu, relative_rmse, render_view, setup};
use occlab::frame::Frame;
use occlab::oracle::{Filter, Options, Oracle};
use occlab::scene::{Ambient, Container, Density, Integration, Scene, Sky};

/// A scene with every feature of the view march, and a background.
fn rich(integration: Integration, step_m: Option<f64>) -> Scene {
    let mut scene = cumulus();
    scene.name = format!("{integration:?} {step_m:?}");
    let Density::Procedural(field) = &mut scene.density else {
        unreachable!()
    };
    field.decks[0].top_m = 1600.0;
    let mut second = field.decks[0].clone();
    (second.base_m, second.top_m, second.coverage) = (1700.0, 2048.0, 0.3);
    second.cloud_type = [0.2, 0.5];
    field.decks.push(second);
    scene.sun.irradiance = None;
    scene.sky = Some(Sky::Preetham {
        turbidity: 3.0,
        ground_albedo: 0.2,
    });
    scene.ambient = Some(Ambient::Sky {
        base: 0.5,
        top: 1.0,
    });
    scene.medium.albedo = 0.9;
    scene.march.integration = integration;
    scene.march.jitter = true;
    scene.march.step_m = step_m;
    scene
}

/// Sun, whole radiance and opacity, to 1e-2: noise is filtered as in `procedural_clouds`. An albedo 5 % off must fail.
#[test]
fn views_with_sky_ambient_and_two_decks() {
    needs_adapter!();
    for (integration, step_m) in [
        (Integration::Analytic, None),
        (Integration::Thesis, Some(150.0)),
    ] {
        let scene = rich(integration, step_m);
        scene.validate().unwrap();
        on_gpu(move |renderer| {
            let view = renderer.view(&scene, IMAGE).unwrap();
            let oracles = [Filter::EightBit, Filter::Exact]
                .map(|filter| Oracle::filtered(&scene, IMAGE, filter).unwrap());
            let mut other = scene.clone();
            other.medium.albedo *= 1.05;
            let wrong = oracles
                .each_ref()
                .map(|oracle| oracle.again(&other, IMAGE).unwrap());
            let opacity = |f: &Frame| {
                f.radiance
                    .iter()
                    .map(|p| f64::from(p[3]))
                    .collect::<Vec<_>>()
            };
            for id in ["none", "srm"] {
                let setup = setup(id, "");
                let device = render_view(renderer, &view, &setup);
                let compare = |oracle: &Oracle| {
                    let frame = oracle.render(&setup, Options::default()).unwrap();
                    [
                        error(&device, &frame, |f| &f.sun),
                        error(&device, &frame, |f| &f.radiance),
                        relative_rmse(opacity(&device).into_iter().zip(opacity(&frame))),
                    ]
                };
                let worst = |errors: [f64; 3]| errors.into_iter().fold(0.0, f64::max);
                let nearest = |oracles: &[Oracle]| {
                    let each = oracles.iter().map(compare);
                    each.min_by(|a, b| worst(*a).total_cmp(&worst(*b))).unwrap()
                };
                let (right, control) = (nearest(&oracles), nearest(&wrong));
                println!(
                    "{} {id}: sun {:.1e}, radiance {:.1e}, opacity {:.1e}; control: sun {:.1e}",
                    scene.name, right[0], right[1], right[2], control[0],
                );
                assert!(worst(right) <= 1e-2, "{} {id}: {right:?}", scene.name);
                assert!(
                    control[0] > 2e-2,
                    "{} {id}: a wrong albedo passed",
                    scene.name
                );
            }
        });
    }
}

/// The sky without medium; a device holds its coefficients in f32.
#[test]
fn sky_behind_nothing() {
    needs_adapter!();
    let mut scene = box_scene([-1.0; 3], [1.0; 3], 0.0);
    scene.sun.elevation_deg = 25.0;
    scene.camera.fov_y_deg = 100.0;
    scene.sky = Some(Sky::Preetham {
        turbidity: 2.5,
        ground_albedo: 0.2,
    });
    on_gpu(move |renderer| {
        let setup = setup("none", "");
        let device = render_view(renderer, &renderer.view(&scene, IMAGE).unwrap(), &setup);
        let compare = |scene: &Scene| {
            let oracle = Oracle::new(scene, IMAGE).unwrap();
            let frame = oracle.render(&setup, Options::default()).unwrap();
            error(&device, &frame, |f| &f.radiance)
        };
        let right = compare(&scene);
        let mut other = scene.clone();
        other.sky = Some(Sky::Preetham {
            turbidity: 2.6,
            ground_albedo: 0.2,
        });
        println!("sky: {right:.1e}, control {:.1e}", compare(&other));
        assert!(right <= 1e-4, "{right:.1e}");
        assert!(compare(&other) > 5e-3, "a wrong turbidity passed");
    });
}

/// Columns without a front: in a medium too thin for any threshold, and beside a box, where a column has no length.
#[test]
fn columns_that_never_begin_agree() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = rough_volume(folder.path());
    on_gpu(move |renderer| {
        for (extinction_per_m, id, params) in [
            (1e-5, "bsm", "form=published mean=fitted"),
            (1e-5, "bsm", "mean=fitted"),
            (scene.medium.extinction_per_m, "esm", "front=first"),
        ] {
            let mut thin = scene.clone();
            thin.medium.extinction_per_m = extinction_per_m;
            let view = renderer.view(&thin, IMAGE).unwrap();
            let oracle = [Oracle::new(&thin, IMAGE).unwrap()];
            let setup = small(id, params);
            let error = agreement(&render_view(renderer, &view, &setup), &oracle, &setup);
            println!("{id} {params} at {extinction_per_m}: {error:.1e}");
            let tolerance = setup.method.info().tolerance;
            assert!(error <= tolerance, "{id} {params}: {error:.1e}");
        }
    });
}

/// View rays that leave a shell through its inner sphere and re-enter, under a low sun whose rays do so too.
#[test]
fn rays_across_the_gap_of_a_shell() {
    needs_adapter!();
    let mut scene = box_scene([0.0; 3], [1.0; 3], 2e-5);
    scene.container = Container::Shell {
        planet_radius_m: 200_000.0,
        base_m: 1000.0,
        top_m: 2000.0,
    };
    scene.sun.elevation_deg = 2.0;
    // From 5 km up the ray 12 degrees below the horizontal passes 500 m above ground.
    scene.camera.position_m = [0.0, 5000.0, 0.0];
    scene.camera.target_m = [1000.0, 5000.0 - 1000.0 * 12f64.to_radians().tan(), 0.0];
    scene.camera.fov_y_deg = 2.0;
    scene.validate().unwrap();
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let oracle = [Oracle::new(&scene, IMAGE).unwrap()];
        let mut filled = scene.clone();
        filled.container = Container::Shell {
            planet_radius_m: 200_000.0,
            base_m: 400.0,
            top_m: 2000.0,
        };
        let control = [Oracle::new(&filled, IMAGE).unwrap()];
        for (id, params) in [("srm", ""), ("truth", "step_m=100"), ("bsm", "")] {
            let setup = small(id, params);
            let device = render_view(renderer, &view, &setup);
            let (right, wrong) = (
                agreement(&device, &oracle, &setup),
                agreement(&device, &control, &setup),
            );
            println!("shell with a gap, {id}: {right:.1e}, control {wrong:.1e}");
            assert!(right <= 1e-4, "{id}: {right:.1e}");
            assert!(wrong > 1e-2, "{id}: a shell without a gap passed");
        }
    });
}
