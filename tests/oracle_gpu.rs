//! Device against oracle: every method of the registry and its variants, over three kinds of density.
//!
//! What a tolerance (`MethodInfo::tolerance`, relative RMSE of sunlight) is made of: 64 view steps of f32 round 2⁻²⁴ each
//! (4e-6), `exp` of τ adds 3 + 2τ ulp, a light march of n steps √n·2⁻²⁴ of τ; a map adds the rounding of d/L_max, whose
//! effect is c or τ times larger, `nearest` look-ups beside the texel's edge (share of samples: 2⁻²⁴·|p|·R/extent), and for
//! `bsm` steps that count as occupied on one side only. Positions round 2⁻²⁴·|p|, times σ of τ: 2e-6 here, 1e-4 at 10 m⁻¹.
//! Rounding of stored values is emulated. WGSL leaves f16 conversion (nearest or cut off) and the filtering of noise to the
//! device: the oracle is asked for both, and the nearer answer counts.

#[macro_use]
mod common;

use common::{
    box_scene, cube_density, cumulus, hashed, on_gpu, relative_rmse, render_view, setup, write_cube,
};
use occlab::frame::Frame;
use occlab::occlusion::rounding::{Format, Rounding};
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::oracle::{Filter, Options, Oracle};
use occlab::scene::{Ambient, Container, Density, ImageSize, Integration, Scene, Sky};

const IMAGE: ImageSize = ImageSize {
    width: 48,
    height: 27,
};
const MAP: &str = "resolution=128 steps=64";

/// A method's variant and a slightly wrong one that must be told apart from it.
struct Case {
    id: &'static str,
    params: &'static str,
    wrong: &'static str,
}

const fn case(id: &'static str, params: &'static str, wrong: &'static str) -> Case {
    Case { id, params, wrong }
}

const CASES: &[Case] = &[
    case("srm", "", "steps=9"),
    case(
        "srm",
        "spacing=uniform steps=20",
        "spacing=uniform steps=18",
    ),
    case(
        "srm",
        "spacing=uniform_reach reach_m=300",
        "spacing=uniform_reach reach_m=330",
    ),
    case(
        "srm",
        "spacing=exponential steps=6",
        "spacing=exponential steps=7",
    ),
    case("srm", "sampling=end", "sampling=midpoint"),
    case("srm", "sampling=jittered", "sampling=midpoint"),
    case("truth", "step_m=2", "step_m=40"),
    case("esm", "", "c=12.1"),
    case("esm", "storage=f32", "c=12.1 storage=f32"),
    case("esm", "lookup=nearest", "lookup=blend"),
    case("esm", "lookup=hardware", "lookup=blend"),
    case("esm", "form=published c=8", "form=published c=8.8"),
    case(
        "esm",
        "form=published c=80 storage=f32",
        "form=published c=88 storage=f32",
    ),
    case("bsm", "", "mean=all"),
    case("bsm", "storage=f32", "mean=fitted storage=f32"),
    case("bsm", "mean=all", "mean=fitted"),
    case("bsm", "mean=fitted lookup=hardware", "mean=fitted"),
    case(
        "bsm",
        "front=first sampling=end",
        "front=threshold sampling=end",
    ),
    case("bsm", "form=published", "form=stable"),
    case("fom", "", "order=4"),
    case("fom", "storage=f32", "order=4 storage=f32"),
    case("fom", "bounds=texel", "bounds=map"),
    case("fom", "order=7 window=lanczos", "order=7"),
    case(
        "fom",
        "order=5 window=fejer lookup=hardware",
        "order=5 window=lanczos lookup=hardware",
    ),
    case("fom", "form=published lookup=nearest", "form=published"),
    case("floor", "", "sampling=end"),
    case("floor", "storage=f32", "sampling=end storage=f32"),
    case("floor", "lookup=hardware", "lookup=nearest"),
    case("floor", "sampling=end", ""),
];

/// Where noise is filtered by hardware, neighbours must be farther away.
const CLOUD_CASES: &[Case] = &[
    case("srm", "", "steps=9"),
    case("srm", "sampling=jittered", "sampling=midpoint"),
    case("truth", "step_m=10", "step_m=300"),
    case("esm", "", "c=12.1"),
    case("bsm", "", "mean=fitted"),
    case("fom", "", "order=5"),
    case("floor", "", "sampling=end"),
];

/// The method, with a small map if it has one.
fn small(id: &str, params: &str) -> MethodSetup {
    let plain = setup(id, "");
    let plan = plain.method.plan(&plain.params).unwrap();
    let map = if plan.map_values.is_some() { MAP } else { "" };
    setup(id, &format!("{map} {params}"))
}

/// What a device may make of stored values.
fn roundings(setup: &MethodSetup) -> Vec<Rounding> {
    let nearest = Rounding::device(setup.params.choice("storage").unwrap_or("f32"), false);
    let cut = Rounding {
        truncate_f16: true,
        ..nearest
    };
    if nearest.storage == Format::F16 {
        vec![nearest, cut]
    } else {
        vec![nearest]
    }
}

fn channels(frame: &Frame, of: fn(&Frame) -> &[[f32; 4]]) -> impl Iterator<Item = f64> + '_ {
    of(frame)
        .iter()
        .flat_map(|p| p[..3].iter().map(|v| f64::from(*v)))
}

fn error(device: &Frame, oracle: &Frame, of: fn(&Frame) -> &[[f32; 4]]) -> f64 {
    relative_rmse(channels(device, of).zip(channels(oracle, of)))
}

/// Relative RMSE of sunlight, over the nearest of what the device may do.
fn agreement(device: &Frame, oracles: &[Oracle], setup: &MethodSetup) -> f64 {
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

/// Hardware may cut bilinear weights to 8 bits: up to 2⁻⁹ of the difference between neighbours.
fn tolerance(setup: &MethodSetup) -> f64 {
    match setup.params.choice("lookup") {
        Ok("hardware") => 1e-3,
        _ => setup.method.info().tolerance,
    }
}

/// Every case within its tolerance, its wrong neighbour at least twice as far away. `floor`: no tolerance is smaller.
fn check(scene: Scene, cases: &'static [Case], filters: &'static [Filter], floor: f64) {
    scene.validate().unwrap();
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let oracles: Vec<Oracle> = filters
            .iter()
            .map(|filter| Oracle::filtered(&scene, IMAGE, *filter).unwrap())
            .collect();
        let mut failures = Vec::new();
        for Case { id, params, wrong } in cases {
            let right = small(id, params);
            let tolerance = tolerance(&right).max(floor);
            let device = render_view(renderer, &view, &right);
            let error = agreement(&device, &oracles, &right);
            let control = agreement(&device, &oracles, &small(id, wrong));
            let line = format!(
                "{} {id} {params}: {error:.1e} of {tolerance:.0e}; {wrong}: {control:.1e}",
                scene.name
            );
            println!("{line}");
            if error > tolerance || control <= 2.0 * tolerance {
                failures.push(line);
            }
        }
        assert!(failures.is_empty(), "{failures:#?}");
    });
}

/// Seen with an oblique sun from outside, a box in full view.
fn outside(scene: &mut Scene) {
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    scene.camera.position_m = [-500.0, 900.0, -1400.0];
}

fn rough_volume(folder: &std::path::Path) -> Scene {
    let mut scene = box_scene([-300.0, 100.0, -200.0], [400.0, 600.0, 500.0], 0.03);
    scene.name = "volume".into();
    scene.density = cube_density(write_cube(folder, 17, |x, y, z| {
        (hashed(x, y, z) - 0.6).max(0.0) * 2.5
    }));
    outside(&mut scene);
    scene
}

#[test]
fn every_method_has_a_case() {
    for method in REGISTRY {
        let info = method.info();
        assert!(
            info.tolerance > 0.0 && info.tolerance <= 1e-3,
            "{}",
            info.id
        );
        assert!(
            info.id == "none" || CASES.iter().any(|c| c.id == info.id),
            "{} is not compared with its twin",
            info.id
        );
    }
}

/// Volumes are interpolated in f32 by hand: nothing but rounding separates device and oracle.
#[test]
fn imported_volume() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    check(rough_volume(folder.path()), CASES, &[Filter::Exact], 0.0);
}

/// Noise is filtered with weights of 8 bits, on llvmpipe to values of 8 bits, and texels differ where a value lies between
/// two of 255: 1/255 of shape is up to 2 % of extinction near an edge, and moves fronts. 1e-2 in a picture.
#[test]
fn procedural_clouds() {
    needs_adapter!();
    check(
        cumulus(),
        CLOUD_CASES,
        &[Filter::EightBit, Filter::Exact],
        1e-2,
    );
}

/// Everything a view march can do, and what is behind the medium.
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

/// Sun, whole radiance and opacity, to 1e-2: noise is filtered as in `procedural_clouds`. An albedo 5 % off is told apart.
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

/// The sky alone, whose coefficients a device holds in f32.
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

/// Columns that never begin: in a medium too thin for any threshold, and beside a box, where a column has no length.
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

/// View rays that leave a shell through its inner sphere and come back, under a low sun whose rays do so too.
#[test]
fn rays_across_the_gap_of_a_shell() {
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
        for (id, params) in [("srm", ""), ("truth", "step_m=100"), ("bsm", MAP)] {
            let setup = setup(id, params);
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
