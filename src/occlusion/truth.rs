//! The ground truth: a secondary march of constant small steps.

use super::param::{ParamKind, ParamSpec, Params};
use super::{LightOcclusion, MethodInfo};
use crate::error::Result;

/// See the module.
pub struct Truth;

impl LightOcclusion for Truth {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "truth",
            title: "Ground truth",
            citation: "Secondary march of 1000 × 10 m or to the layer's exit (comparison thesis 2023, ch. 4)",
            shader: "occlusion/truth.wgsl",
            source: include_str!("../../shaders/occlusion/truth.wgsl"),
            params: &[&[ParamSpec {
                name: "step_m",
                unit: "m",
                doc: "Length of a light step; the references of a batch use the scene's own (10 m, or 1/1000 of a box's diagonal).",
                kind: ParamKind::Float {
                    min: 1e-9,
                    max: 1e6,
                    default: 10.0,
                },
            }]],
            monotone: true,
        }
    }

    fn light_turns(&self, params: &Params, longest_path_m: f64) -> Result<f64> {
        Ok((longest_path_m / params.number("step_m")?).ceil() + 1.0)
    }
}
