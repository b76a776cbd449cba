//! No occlusion: V = 1.

use super::param::Params;
use super::twin::{LightRay, March, Twin};
use super::{LightOcclusion, MethodInfo};
use crate::error::Result;

/// See the module.
pub struct None;

impl LightOcclusion for None {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "none",
            title: "No occlusion",
            citation: "V = 1: upper bound of light, cost of the view march alone",
            shader: "occlusion/none.wgsl",
            source: include_str!("../../shaders/occlusion/none.wgsl"),
            params: &[],
            monotone: true,
            tolerance: 1e-5,
        }
    }

    fn oracle(&self, _params: &Params) -> Result<Twin> {
        Ok(Twin::March(Box::new(Unoccluded)))
    }
}

/// V = 1.
struct Unoccluded;

impl March for Unoccluded {
    fn transmittance(&self, _ray: &dyn LightRay, _rnd: f64) -> f64 {
        1.0
    }
}
