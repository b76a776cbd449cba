//! Beer shadow map: front, mean extinction and largest optical depth.

use super::param::{ParamKind, ParamSpec, Params};
use super::{FORM, FRONT, LightOcclusion, MAP_PARAMS, MethodInfo, Plan};
use crate::error::Result;

/// See the module.
pub struct Bsm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "mean",
        unit: "",
        doc: "Mean extinction over: occupied steps (Hillaire 2020), all steps (thesis M), or fitted to the column by least squares.",
        kind: ParamKind::Choice {
            options: &["occupied", "all", "fitted"],
            default: "occupied",
        },
    },
    FORM,
    FRONT,
];

impl LightOcclusion for Bsm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "bsm",
            title: "Beer shadow map",
            citation: "Hillaire 2020, A Scalable and Production Ready Sky and Atmosphere (Unreal Engine clouds); thesis M, Algorithms 5 and 6",
            shader: "occlusion/bsm.wgsl",
            source: include_str!("../../shaders/occlusion/bsm.wgsl"),
            params: &[MAP_PARAMS, PARAMS],
            monotone: true,
        }
    }

    fn plan(&self, _params: &Params) -> Result<Plan> {
        Ok(Plan {
            map_values: Some(3),
            ..Plan::default()
        })
    }
}
