//! The floor: an uncompressed column, which shows what the march alone costs.

use super::param::Params;
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin};
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
            tolerance: 2e-5,
        }
    }

    fn oracle(&self, _params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Cumulative)))
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        Ok(Plan {
            map_values: Some(params.int("steps")?),
            ..Plan::default()
        })
    }
}

/// Stored depths stay below this: f16 ends at 65504, and between two infinite values NaN is interpolated.
const LARGEST_TAU: f64 = 6e4;

/// Optical depth at the far edge of every step, linear in between.
struct Cumulative;

impl Encoding for Cumulative {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let edges = column.thicknesses().scan(0.0, |tau, thickness| {
            *tau = rounding.computed(*tau + thickness);
            Some(tau.min(LARGEST_TAU))
        });
        edges.collect()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let last = values.len() as f64;
        // A column without length has no depth beyond its first edge but 0/0.
        let steps = if look_up.length > 0.0 {
            (look_up.depth / look_up.length * last).clamp(0.0, last)
        } else {
            last
        };
        let k = (steps as usize).min(values.len() - 1);
        let near = if k == 0 { 0.0 } else { values[k - 1] };
        let tau = near + (values[k] - near) * (steps - k as f64);
        rounding.computed((-rounding.computed(tau)).exp())
    }
}
