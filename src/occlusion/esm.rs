//! Exponential shadow map: one value a texel.

use super::param::{ParamKind, ParamSpec, Params};
use super::{FORM, FRONT, LightOcclusion, MAP_PARAMS, MethodInfo, Plan};
use crate::error::Result;

/// See the module.
pub struct Esm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "c",
        unit: "",
        doc: "Sharpness: extinction behind the front is c over the longest column. The published form overflows f16 from c·z = 11.09.",
        kind: ParamKind::Float {
            min: 1e-3,
            max: 1e5,
            default: 11.0,
        },
    },
    FORM,
    FRONT,
];

impl LightOcclusion for Esm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "esm",
            title: "Exponential shadow map",
            citation: "Annen et al. 2008, Exponential Shadow Maps, eq. 3; thesis M, Algorithms 3 and 4",
            shader: "occlusion/esm.wgsl",
            source: include_str!("../../shaders/occlusion/esm.wgsl"),
            params: &[MAP_PARAMS, PARAMS],
            monotone: true,
        }
    }

    fn plan(&self, _params: &Params) -> Result<Plan> {
        Ok(Plan {
            map_values: Some(1),
            ..Plan::default()
        })
    }
}
