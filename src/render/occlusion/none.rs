//! No occlusion: V = 1 everywhere.

use super::LightOcclusion;
use super::info::{Marker, MethodInfo, Role, Trials};
use super::twin::{LightMarch, LightRay, Twin};
use crate::error::Result;
use crate::param::Params;

/// No occlusion, V = 1.
pub struct None;

impl LightOcclusion for None {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "none",
            title: "No occlusion",
            summary: "V = 1",
            texel: "–",
            expect: "Every shadow is missing: clouds look flat and too bright. Its time is that of the view march alone.",
            citation: "V = 1: upper bound of light, cost of the view march alone",
            role: Role::Unshadowed,
            colour: 0x9cc8ee,
            marker: Marker::Cross,
            shader: "occlusion/none.wgsl",
            source: include_str!("../../../shaders/occlusion/none.wgsl"),
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

    fn oracle(&self, _params: &Params) -> Result<Twin> {
        Ok(Twin::March(Box::new(Unoccluded)))
    }
}

/// V = 1.
struct Unoccluded;

impl LightMarch for Unoccluded {
    fn transmittance(&self, _ray: &dyn LightRay, _rnd: f64) -> f64 {
        1.0
    }
}
