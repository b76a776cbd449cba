//! Secondary march: a few samples from every view sample toward the sun.

use super::param::{ParamKind, ParamSpec, Params};
use super::{LightOcclusion, MethodInfo};
use crate::error::Result;

/// See the module.
pub struct Srm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "steps",
        unit: "",
        doc: "Samples of a light ray.",
        kind: ParamKind::Int {
            min: 1,
            max: 1000,
            default: 10,
        },
    },
    ParamSpec {
        name: "spacing",
        unit: "",
        doc: "quadratic and exponential steps grow with distance; uniform steps reach the layer's exit, uniform_reach ends at reach_m.",
        kind: ParamKind::Choice {
            options: &["quadratic", "uniform", "uniform_reach", "exponential"],
            default: "quadratic",
        },
    },
    ParamSpec {
        name: "reach_m",
        unit: "m",
        doc: "Length of the light ray for uniform_reach.",
        kind: ParamKind::Float {
            min: 1e-6,
            max: 1e6,
            default: 1000.0,
        },
    },
    ParamSpec {
        name: "sampling",
        unit: "",
        doc: "Where a step is sampled: midpoint, far end (thesis M), or jittered by the pixel's noise.",
        kind: ParamKind::Choice {
            options: &["midpoint", "end", "jittered"],
            default: "midpoint",
        },
    },
];

impl LightOcclusion for Srm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "srm",
            title: "Secondary ray march",
            citation: "Harris & Lastra 2001, Real-Time Cloud Rendering; Schneider & Vos 2015; thesis M, Algorithm 2",
            shader: "occlusion/srm.wgsl",
            source: include_str!("../../shaders/occlusion/srm.wgsl"),
            params: &[PARAMS],
            monotone: false,
        }
    }

    fn light_turns(&self, params: &Params, _longest_path_m: f64) -> Result<f64> {
        params.number("steps")
    }
}
