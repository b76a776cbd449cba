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

use common::agreement::{IMAGE, agreement, rough_volume, small};
use common::{cumulus, on_gpu, render_view};
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::oracle::{Filter, Oracle};
use occlab::scene::Scene;

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
    // Misprints of thesis M, kept to show what they do.
    case("bsm", "sampling=quadratic", "sampling=midpoint"),
    case("fom", "sampling=quadratic", "sampling=end"),
    case("fom", "sines=first", "sines=own"),
    case("fom", "step_length=metre", "step_length=own"),
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
