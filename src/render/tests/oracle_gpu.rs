//! Device against oracle: every method of the registry and its variants, over three kinds of density.
//!
//! Terms of the tolerance (`MethodInfo::tolerance`, relative RMSE of sunlight): 64 view steps of f32 round 2⁻²⁴ each
//! (4e-6), `exp` of τ adds 3 + 2τ ulp, a light march of n steps √n·2⁻²⁴ of τ; a map adds the rounding of d/L_max, whose
//! effect is c or τ times larger, `nearest` look-ups beside the texel's edge (share of samples: 2⁻²⁴·|p|·R/extent), and
//! for `bsm` steps that count as occupied on one side only. Positions round 2⁻²⁴·|p|, times σ of τ: 2e-6 here, 1e-4 at
//! 10 m⁻¹. Rounding of stored values is emulated. WGSL leaves f16 conversion (nearest or truncated) and the filtering
//! of noise to the device: the device is compared with the oracle for each, and the smaller difference counts.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::agreement::{IMAGE, agreement, rough_volume, small};
use common::{cumulus, on_gpu, render_view};
use occlab::occlusion::{LightOcclusion, MethodSetup, REGISTRY, Trial, Trials};
use occlab::oracle::{Filter, Oracle};
use occlab::scene::Scene;

/// Which trials of a method are rendered: variants, each with a slightly wrong one that must be told apart from it.
type Select = fn(&Trials) -> &'static [Trial];

/// Hardware may cut bilinear weights to 8 bits: up to 2⁻⁹ of the difference between neighbours.
fn tolerance(setup: &MethodSetup) -> f64 {
    match setup.params.choice("lookup") {
        Ok("hardware") => 1e-3,
        _ => setup.method.info().tolerance,
    }
}

/// Every variant must be within its tolerance, its wrong neighbour at least twice as far away. `floor`: smallest
/// tolerance.
fn check(scene: Scene, trials: Select, filters: &'static [Filter], floor: f64) {
    scene.validate().unwrap();
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let oracles: Vec<Oracle> = filters
            .iter()
            .map(|filter| Oracle::filtered(&scene, IMAGE, *filter).unwrap())
            .collect();
        let mut failures = Vec::new();
        let each = |method: &&dyn LightOcclusion| {
            let info = method.info();
            trials(&info.trials).iter().map(|trial| (info.id, trial))
        };
        for (id, trial) in REGISTRY.iter().flat_map(each) {
            let (params, wrong) = (trial.params, trial.control);
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
            info.specs().next().is_none() || !info.trials.pictures.is_empty(),
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
    let volume = rough_volume(folder.path());
    check(volume, |t| t.pictures, &[Filter::Exact], 0.0);
}

/// Noise is filtered with weights of 8 bits, on llvmpipe to values of 8 bits, and texels differ where a value lies between
/// two of 255: 1/255 of shape is up to 2 % of extinction near an edge, and moves fronts. 1e-2 in a picture.
#[test]
fn procedural_clouds() {
    needs_adapter!();
    check(
        cumulus(),
        |t| t.clouds,
        &[Filter::EightBit, Filter::Exact],
        1e-2,
    );
}
