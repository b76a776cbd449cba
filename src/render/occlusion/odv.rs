//! Optical-depth volume: optical depth at equal depths, in a 3-D texture.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::plan::{MapLayout, MapNumbers};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin, between_slices};
use super::{GEOMETRY, LightOcclusion, Plan};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};

/// Optical-depth volume.
pub struct Odv;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "slices",
        unit: "",
        doc: "Depths a column keeps, equally spaced from the sun side to the longest column's end.",
        kind: ParamKind::Int {
            min: 2,
            max: 256,
            default: 32,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "storage",
        unit: "",
        doc: "Stored values: optical depth in half or single precision, or the root of its share of 8 in fractions of 8 bits.",
        kind: ParamKind::Choice {
            options: &["f16", "f32", "unorm8"],
            default: "f16",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "slices=16"),
        trial("slices=64", "slices=32"),
        trial("storage=f32", "storage=f32 slices=16"),
        trial("fit=warped placement=occupied", "fit=square slices=16"),
    ],
    // Filters of 8-bit textures calculate in 8 bits on some devices, llvmpipe among them: 1e-3 over the volume.
    clouds: &[
        trial("", "slices=4"),
        trial("storage=unorm8", "storage=unorm8 slices=4"),
    ],
    texels: &[
        trial("", "sampling=end"),
        trial("slices=8", "slices=8 sampling=end"),
        trial("fit=warped placement=occupied", "fit=axes"),
        trial("cascades=2", "cascades=2 cascade_ratio=0.6"),
    ],
    exact: &["slices=64"],
};

impl LightOcclusion for Odv {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "odv",
            title: "Optical-depth volume",
            summary: "optical-depth volume: τ at S depths in a 3-D texture, one filtered fetch",
            texel: "S",
            expect: "Depths are equal parts of the longest column, so at a low sun a slice is a kilometre thick: shadow begins up to a slice too early and edges inside it are ramps. τ, not T, is interpolated between columns, which darkens edges.",
            citation: "light-space optical-depth volumes of current engines; Lokovic & Veach 2000, Deep Shadow Maps (without compression)",
            role: Role::Practical,
            colour: 0x2e8fd0,
            marker: Marker::Circle,
            shader: "occlusion/odv.wgsl",
            source: include_str!("../../../shaders/occlusion/odv.wgsl"),
            params: &[GEOMETRY, PARAMS],
            monotone: true,
            bounded: false,
            // Interpolated by hardware, which may cut weights to 8 bits.
            tolerance: 1e-3,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Slices {
            slices: params.int("slices")?,
            root: params.choice("storage")? == "unorm8",
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let slices = params.int("slices")?;
        let what = match params.choice("storage")? {
            "unorm8" => "√(τ/8)",
            _ => "τ",
        };
        let name = |k: u32| format!("{what} at {k}/{} of the depth", slices - 1);
        Ok((0..slices).map(name).collect())
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let slices = params.int("slices")?;
        let numbers = match params.choice("storage")? {
            "unorm8" => MapNumbers::Unorm8,
            _ => MapNumbers::Float,
        };
        let mut plan = Plan::of(MapLayout::Volume {
            slices,
            values: 1,
            numbers,
        });
        plan.defs
            .insert("SLICES".to_owned(), Some(slices.cast_signed()));
        Ok(plan)
    }

    fn homogeneous_error(&self) -> f64 {
        1e-3
    }
}

/// f16 ends at 65504, and e^(−6e4) is 0.
const LARGEST_TAU: f64 = 6e4;
/// Largest optical depth of fractions.
const LARGEST_FRACTION_TAU: f64 = 8.0;

/// τ at k/(S − 1) of L_max, or the root of its share of 8.
struct Slices {
    slices: u32,
    root: bool,
}

impl Encoding for Slices {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let last = f64::from(self.slices - 1);
        let slice = |k: u32| {
            let depth_m = f64::from(k) / last * column.depth_m;
            let tau = rounding.computed(column.optical_depth_before(depth_m));
            match self.root {
                true => (tau / LARGEST_FRACTION_TAU).min(1.0).sqrt(),
                false => tau.min(LARGEST_TAU),
            }
        };
        (0..self.slices).map(slice).collect()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let slices = f64::from(self.slices);
        let centre = (look_up.depth * (slices - 1.0) + 0.5) / slices;
        let stored = rounding.computed(between_slices(values, centre));
        let tau = match self.root {
            true => stored * stored * LARGEST_FRACTION_TAU,
            false => stored,
        };
        rounding.computed((-tau).exp())
    }
}
