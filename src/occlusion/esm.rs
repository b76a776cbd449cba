//! Exponential shadow map: one value a texel.

use super::param::{Applies, ParamKind, ParamSpec, Params};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, Front, LookUp, Twin, at_least_zero};
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
        applies: Applies::Always,
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
            tolerance: 2e-5,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Exponential {
            c: params.number("c")?,
            front: Front::new(params)?,
            published: params.choice("form")? == "published",
        })))
    }

    fn plan(&self, _params: &Params) -> Result<Plan> {
        Ok(Plan {
            map_values: Some(1),
            ..Plan::default()
        })
    }
}

/// V = exp(−c (d − z)), from z or from exp(c z).
struct Exponential {
    c: f64,
    front: Front,
    published: bool,
}

impl Encoding for Exponential {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let z = column.front(self.front).unwrap_or(1.0);
        if self.published {
            vec![rounding.computed(rounding.computed(self.c * z).exp())]
        } else {
            vec![z]
        }
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        if self.published {
            let decay = rounding.computed((-rounding.computed(self.c * look_up.depth)).exp());
            return rounding.computed(values[0] * decay).clamp(0.0, 1.0);
        }
        let behind = at_least_zero(look_up.depth - values[0]);
        rounding.computed((-rounding.computed(self.c * behind)).exp())
    }
}
