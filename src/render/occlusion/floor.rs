//! The floor: an uncompressed light column; its error is that of the march alone.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin};
use super::{GEOMETRY, LightOcclusion, Plan, TEXELS};
use crate::error::Result;
use crate::param::Params;

/// The uncompressed column.
pub struct Floor;

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "sampling=end"),
        trial("storage=f32", "sampling=end storage=f32"),
        trial("lookup=hardware", "lookup=nearest"),
        trial("sampling=end", ""),
        trial("fit=warped", "fit=warped warp_exponent=0.5"),
        trial("near_steps=3 near_m=0.2", "near_steps=3 near_m=0.1"),
        trial("cascades=3", "cascades=3 cascade_ratio=0.5"),
        trial("fill_frames=4", "fill_frames=4 sampling=end"),
        trial("column_end=dark", ""),
    ],
    clouds: &[
        trial("", "sampling=end"),
        trial("fit=warped placement=occupied", "fit=axes"),
        trial("fit=axes near_steps=4", "fit=axes near_steps=3"),
        trial("fit=warped cascades=2", "fit=warped"),
        trial("lookup=hardware cascades=4", "lookup=hardware cascades=2"),
    ],
    texels: &[
        trial("", "sampling=end"),
        trial("fit=axes", ""),
        trial("placement=occupied", ""),
        trial("fit=warped placement=occupied", "fit=axes"),
        trial("cascades=3", "cascades=3 cascade_ratio=0.6"),
        trial("fit=warped cascades=2 fill_frames=2", "fit=axes cascades=2"),
    ],
    exact: &[""],
};

impl LightOcclusion for Floor {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "floor",
            title: "Uncompressed column",
            summary: "the uncompressed column: the error no map of these steps and texels can go below",
            texel: "n",
            expect: "Only what steps and texels cost: shadows blurred to a texel, cloud between two steps missed. A value for every step is the memory that the other maps avoid.",
            citation: "Lokovic & Veach 2000, Deep Shadow Maps, sect. 3 (before compression)",
            role: Role::Floor,
            colour: 0xdba11c,
            marker: Marker::Plus,
            shader: "occlusion/floor.wgsl",
            source: include_str!("../../../shaders/occlusion/floor.wgsl"),
            params: &[GEOMETRY, TEXELS],
            monotone: true,
            bounded: false,
            tolerance: 2e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, _params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Cumulative)))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let steps = 1..=params.int("steps")?;
        Ok(steps.map(|k| format!("τ after step {k}")).collect())
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        Ok(Plan::array(params.int("steps")?))
    }
}

/// Largest stored optical depth: f16 ends at 65504, and interpolation between two infinite values gives NaN.
const LARGEST_TAU: f64 = 6e4;

/// Optical depth at the far edge of every step, linear in between.
struct Cumulative;

impl Encoding for Cumulative {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        if column.spans.is_some() {
            // Samples lie elsewhere than what is stored.
            let n = column.extinction_per_m.len();
            let edge = |k: usize| k as f64 / n as f64 * column.length_m;
            let depth = |k: usize| column.optical_depth_before(edge(k)).min(LARGEST_TAU);
            return (1..=n).map(depth).collect();
        }
        let edges = column.thicknesses().scan(0.0, |tau, thickness| {
            *tau = rounding.computed(*tau + thickness);
            Some(tau.min(LARGEST_TAU))
        });
        edges.collect()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let last = values.len() as f64;
        // A column of length 0 would give 0/0.
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
