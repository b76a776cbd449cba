//! No occlusion: V = 1.

use super::{LightOcclusion, MethodInfo};

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
        }
    }
}
