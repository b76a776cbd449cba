//! Absorbed-light quantiles: the depths at which given shares of a column's absorbed light are absorbed.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::plan::{MapLayout, MapNumbers};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin};
use super::{GEOMETRY, LOOKUP, LightOcclusion, Plan};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};

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
        doc: "Stored values: half or single precision, or fractions of 16 bits (an optional feature of devices).",
        kind: ParamKind::Choice {
            options: &["f16", "f32", "unorm16"],
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
        trial("near_steps=3 near_m=0.2", "near_steps=3 near_m=0.1"),
        trial("fit=warped placement=occupied", "fit=axes"),
    ],
    clouds: &[
        trial("", "quantiles=two"),
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
        Ok(Twin::Map(Box::new(Quantiles { shares })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let depths = shares(params)?.iter();
        let depths = depths.map(|q| format!("depth of {:.0} % absorbed", 100.0 * q));
        Ok(["absorbed light".to_owned()]
            .into_iter()
            .chain(depths)
            .collect())
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let numbers = match params.choice("storage")? {
            "unorm16" => MapNumbers::Unorm16,
            _ => MapNumbers::Float,
        };
        let values = shares(params)?.len() as u32 + 1;
        let mut plan = Plan::of(MapLayout::Array { values, numbers });
        let steps = params.int("steps")?;
        if steps <= MOST_KEPT {
            plan.defs
                .insert("KEPT_STEPS".to_owned(), Some(steps.cast_signed()));
        }
        Ok(plan)
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
fn shares(params: &Params) -> Result<&'static [f64]> {
    Ok(match params.choice("quantiles")? {
        "two" => &[0.25, 0.75],
        "six" => &[0.10, 0.27, 0.45, 0.63, 0.80, 0.93],
        _ => &[0.27, 0.66, 0.87],
    })
}

/// V = 1 − A·Q(d).
struct Quantiles {
    shares: &'static [f64],
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
