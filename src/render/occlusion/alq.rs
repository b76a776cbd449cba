//! Absorbed-light quantiles: the depths at which given shares of a column's absorbed light are absorbed.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::plan::{MapLayout, MapNumbers, MapPlan};
use super::rounding::{FloatFormat, Rounding, fraction};
use super::twin::{Column, Encoding, LookUp, Twin};
use super::{GEOMETRY, LOOKUP, LightOcclusion, Plan};
use crate::error::{Error, Result};
use crate::param::{Applies, ParamKind, ParamSpec, Params};
use crate::shader_defs::Defs;

/// Absorbed-light quantiles.
pub struct Alq;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "quantiles",
        unit: "",
        doc: "Number of depths a texel keeps.",
        kind: ParamKind::Choice {
            options: &["two", "three", "six"],
            default: "three",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "storage",
        unit: "",
        doc: "Stored values: half or single precision; fractions of 16 bits (an optional feature of devices); packed = words of 4 bytes for two or three quantiles, 8 for six.",
        kind: ParamKind::Choice {
            options: &["f16", "f32", "unorm16", "packed"],
            default: "f16",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    LOOKUP,
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "quantiles=two"),
        trial("storage=f32", "quantiles=two storage=f32"),
        trial("quantiles=six", "quantiles=three"),
        trial("quantiles=two", "quantiles=three"),
        trial("lookup=nearest", ""),
        trial("lookup=hardware", ""),
        trial("storage=packed", "storage=f32"),
        trial("storage=packed quantiles=two", "storage=f32 quantiles=two"),
        trial("storage=packed quantiles=six", "storage=f32 quantiles=six"),
        trial(
            "storage=packed lookup=nearest",
            "storage=f32 lookup=nearest",
        ),
        trial("near_steps=3 near_m=0.2", "near_steps=3 near_m=0.1"),
        trial("fit=warped placement=occupied", "fit=axes"),
    ],
    clouds: &[
        trial("", "quantiles=two"),
        trial("storage=packed", "storage=packed quantiles=two"),
        trial("fit=warped placement=occupied", "fit=axes"),
    ],
    texels: &[
        trial("", "sampling=end"),
        trial(
            "quantiles=six storage=f32",
            "quantiles=six storage=f32 sampling=end",
        ),
        trial("quantiles=two", "quantiles=two sampling=end"),
        trial("steps=200", "steps=200 sampling=end"),
        trial("fit=warped placement=occupied", "fit=axes"),
    ],
    exact: &["quantiles=six"],
};

impl LightOcclusion for Alq {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "alq",
            title: "Absorbed-light quantiles",
            summary: "absorbed-light quantiles: depths at which K shares of a column's light are absorbed",
            texel: "K + 1",
            expect: "Between two quantiles light is lost evenly, so a gap between two clouds is bridged where no quantile falls at its edges: light fades in the gap. Before the first quantile shadow may begin too early, behind the last it may end too late.",
            citation: "this project; quantile functions: Parzen 1979",
            role: Role::Practical,
            colour: 0xd02c2c,
            marker: Marker::Down,
            shader: "occlusion/alq.wgsl",
            source: include_str!("../../../shaders/occlusion/alq.wgsl"),
            params: &[GEOMETRY, PARAMS],
            monotone: true,
            bounded: false,
            tolerance: 1e-4,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        let shares = shares(params)?;
        let storage = Storage::new(params)?;
        Ok(Twin::Map(Box::new(Quantiles { shares, storage })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let shares = shares(params)?;
        let storage = Storage::new(params)?;
        if storage == Storage::Packed {
            let words = 1..=packed_bits(shares).len();
            return Ok(words.map(|i| format!("word {i}")).collect());
        }
        let depths = shares.iter();
        let depths = depths.map(|q| format!("depth of {:.0} % absorbed", 100.0 * q));
        let absorbed = ["absorbed light".to_owned()];
        Ok(absorbed.into_iter().chain(depths).collect())
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let shares = shares(params)?;
        let storage = Storage::new(params)?;
        let quantiles = shares.len() as u32 + 1;
        let (values, numbers) = match storage {
            Storage::Floats => (quantiles, MapNumbers::Float),
            Storage::Fractions => (quantiles, MapNumbers::Unorm16),
            Storage::Packed => (packed_bits(shares).len() as u32, MapNumbers::Word),
        };
        let map = MapPlan::of(MapLayout::Array { values, numbers });
        let mut defs = Defs::new();
        let steps = params.int("steps")?;
        if steps <= MOST_KEPT {
            defs.insert("KEPT_STEPS".to_owned(), Some(steps.cast_signed()));
        }
        Ok(Plan {
            map: Some(map),
            defs,
        })
    }

    fn homogeneous_error(&self) -> f64 {
        0.11
    }
}

/// Steps of a column whose extinctions an invocation keeps; more are marched twice.
const MOST_KEPT: u32 = 128;
/// Narrowest piece of Q, over L_max.
const NARROWEST: f64 = 1e-6;

/// Shares of the absorbed light whose depths are kept.
pub fn shares(params: &Params) -> Result<&'static [f64]> {
    Ok(match params.choice("quantiles")? {
        "two" => &[0.25, 0.75],
        "six" => &[0.10, 0.27, 0.45, 0.63, 0.80, 0.93],
        _ => &[0.27, 0.66, 0.87],
    })
}

/// Storage of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    Floats,
    /// Fractions of 16 bits.
    Fractions,
    /// Words: the root of A, the first depth, and for each further depth the root of its share of the way to the end.
    Packed,
}

impl Storage {
    /// Refuses a look-up that interpolates what only its texel can read.
    fn new(params: &Params) -> Result<Self> {
        let storage = match params.choice("storage")? {
            "unorm16" => Self::Fractions,
            "packed" => Self::Packed,
            _ => Self::Floats,
        };
        let interpolated = params.choice("lookup")? == "hardware";
        if interpolated && storage == Self::Packed {
            return Err(Error::input(
                "method `alq`",
                "`lookup=hardware` interpolates stored values, which `storage=packed` does not allow",
                "Use `lookup=blend` or `lookup=nearest`, or another storage.",
            ));
        }
        Ok(storage)
    }
}

/// Bits of a texel's numbers, word by word, from the lowest on: root of A, first depth, roots of shares.
fn packed_bits(shares: &[f64]) -> &'static [&'static [u32]] {
    match shares.len() {
        2 => &[&[8, 16, 8]],
        3 => &[&[8, 10, 7, 7]],
        _ => &[&[8, 16, 8], &[8, 8, 8, 8]],
    }
}

/// V = 1 − A·Q(d).
struct Quantiles {
    shares: &'static [f64],
    storage: Storage,
}

impl Quantiles {
    /// A texel after packing and unpacking.
    fn packed(&self, values: &[f64]) -> Vec<f64> {
        let bits = packed_bits(self.shares).concat();
        let most = |i: usize| f64::from((1u32 << bits[i]) - 1);
        let mut depth = fraction(values[1], most(1));
        let mut out = vec![fraction(values[0].sqrt(), most(0)).powi(2), depth];
        for (i, wanted) in values.iter().enumerate().skip(2) {
            let rest = 1.0 - depth;
            let share = ((wanted - depth) / rest.max(1e-20)).max(0.0);
            depth += fraction(share.sqrt(), most(i)).powi(2) * rest;
            out.push(depth);
        }
        out
    }
}

impl Encoding for Quantiles {
    fn encode(&self, column: &Column, _rounding: &Rounding) -> Vec<f64> {
        let whole: f64 = column.thicknesses().sum();
        let absorbed = -(-whole).exp_m1();
        let depth = |share: &f64| {
            let wanted = -(-share * absorbed).ln_1p();
            let mut tau = 0.0;
            for (k, thickness) in column.thicknesses().enumerate() {
                if thickness > 0.0 && tau + thickness >= wanted {
                    return column.depth_at(k, ((wanted - tau) / thickness).max(0.0));
                }
                tau += thickness;
            }
            1.0
        };
        let depths = self.shares.iter().map(depth);
        [absorbed].into_iter().chain(depths).collect()
    }

    fn stored(&self, values: Vec<f64>, rounding: &Rounding) -> Vec<f64> {
        match (self.storage, rounding.storage) {
            (Storage::Packed, FloatFormat::Packed) => self.packed(&values),
            _ => values.iter().map(|value| rounding.stored(*value)).collect(),
        }
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let (absorbed, depths) = (values[0], &values[1..]);
        let last = depths.len() - 2;
        // The piece that holds the depth; the first and the last reach on.
        let i = depths[1..=last]
            .iter()
            .filter(|depth| look_up.depth > **depth)
            .count();
        let width = (depths[i + 1] - depths[i]).max(NARROWEST);
        let share = self.shares[i]
            + (look_up.depth - depths[i]) * (self.shares[i + 1] - self.shares[i]) / width;
        rounding.computed(1.0 - absorbed * rounding.computed(share.clamp(0.0, 1.0)))
    }
}
