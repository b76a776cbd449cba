//! The truth: a secondary march of constant small steps.

use super::LightOcclusion;
use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::twin::{LightMarch, LightRay, OPAQUE_TAU, Twin};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};

/// Secondary march in constant steps, the reference for all other methods.
pub struct Truth;

const TRIALS: Trials = Trials {
    pictures: &[trial("step_m=2", "step_m=40")],
    clouds: &[trial("step_m=10", "step_m=300")],
    texels: &[],
    exact: &[""],
};

impl LightOcclusion for Truth {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "truth",
            title: "Ground truth",
            summary: "constant 10 m steps to the end of the layer",
            texel: "–",
            expect: "Nothing, but it takes far too long for a frame. In the shipped scenes steps of 2.5 m change it by a rel_rmse of 0.001 to 0.003.",
            citation: "Secondary march of 1000 × 10 m or to the layer's exit (comparison thesis 2023, ch. 4)",
            role: Role::Truth,
            colour: 0x000000,
            marker: Marker::Star,
            shader: "occlusion/truth.wgsl",
            source: include_str!("../../../shaders/occlusion/truth.wgsl"),
            params: &[&[ParamSpec {
                name: "step_m",
                unit: "m",
                doc: "Length of a light step; the references of a batch use the scene's own (10 m, or 1/1000 of a box's diagonal).",
                kind: ParamKind::Float {
                    min: 1e-9,
                    max: 1e6,
                    default: 10.0,
                },
                applies: Applies::Always,
                as_printed: &[],
            }]],
            monotone: true,
            bounded: false,
            tolerance: 2e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::March(Box::new(ConstantSteps {
            step_m: params.number("step_m")?,
        })))
    }

    fn light_turns(&self, params: &Params, longest_path_m: f64) -> Result<f64> {
        Ok((longest_path_m / params.number("step_m")?).ceil() + 1.0)
    }
}

/// V = exp(−Σ σ Δ) in steps of one length, the last one shortened to end with the layer.
struct ConstantSteps {
    step_m: f64,
}

impl LightMarch for ConstantSteps {
    fn transmittance(&self, ray: &dyn LightRay, _rnd: f64) -> f64 {
        let length_m = ray.length_m();
        let steps = (length_m / self.step_m).ceil() as u64;
        let (mut tau, mut k) = (0.0, 0);
        while k < steps && tau < OPAQUE_TAU {
            let near_m = k as f64 * self.step_m;
            let width_m = self.step_m.min(length_m - near_m);
            let middle_m = near_m + 0.5 * width_m;
            if let Some(clear_m) = ray.clear_m(middle_m) {
                k += 1 + (clear_m / self.step_m) as u64;
                continue;
            }
            tau += ray.extinction_per_m(middle_m) * width_m;
            k += 1;
        }
        (-tau).exp()
    }
}
