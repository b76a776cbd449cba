//! The floor: an uncompressed column, which shows what the march alone costs.

use super::param::Params;
use super::{LightOcclusion, MAP_PARAMS, MethodInfo, Plan};
use crate::error::Result;

/// See the module.
pub struct Floor;

impl LightOcclusion for Floor {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "floor",
            title: "Uncompressed column",
            citation: "Lokovic & Veach 2000, Deep Shadow Maps, sect. 3 (before compression)",
            shader: "occlusion/floor.wgsl",
            source: include_str!("../../shaders/occlusion/floor.wgsl"),
            params: &[MAP_PARAMS],
            monotone: true,
        }
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        Ok(Plan {
            map_values: Some(params.int("steps")?),
            ..Plan::default()
        })
    }
}
