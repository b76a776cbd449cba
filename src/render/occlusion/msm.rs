//! Moment shadow map: optical depth of a light column, and four moments of where it lies.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin, at_least_zero, smaller};
use super::{GEOMETRY, LightOcclusion, Plan, TEXELS};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};

/// Moment shadow map.
pub struct Msm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "overestimation",
        unit: "",
        doc: "Share of the weight at a depth that counts as in front of it: 0 and 1 are bounds of all columns with these moments; 0.25 as published, 0.5 for a medium without gaps.",
        kind: ParamKind::Float {
            min: 0.0,
            max: 1.0,
            default: 0.25,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "bounds",
        unit: "",
        doc: "Depths that the moments are taken over: the longest column of the map, or each texel's own occupied part (2 values more).",
        kind: ParamKind::Choice {
            options: &["map", "texel"],
            default: "texel",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "sampling=end"),
        trial("storage=f32", "storage=f32 sampling=end"),
        trial("bounds=map", "bounds=texel"),
        trial("bounds=map storage=f32", "bounds=map"),
        trial("overestimation=0.5", "overestimation=0.55"),
        trial("lookup=nearest", "lookup=blend"),
        trial("lookup=hardware", "lookup=nearest"),
        trial("placement=occupied", "placement=occupied sampling=end"),
    ],
    clouds: &[trial("bounds=map", "bounds=texel")],
    texels: &[
        trial("", "sampling=end"),
        trial("bounds=map", "bounds=map sampling=end"),
        trial("bounds=map fit=warped", "bounds=map fit=axes"),
    ],
    exact: &["overestimation=0.5"],
};

impl LightOcclusion for Msm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "msm",
            title: "Moment shadow map",
            summary: "moment shadow map: optical depth and four moments of its distribution",
            texel: "5 + 2",
            expect: "Three points stand for the column: light fades in gaps between clouds, and in deep columns shadow begins before the medium does. In f16 the bias that rounding calls for smears optical depth over the whole interval, most with `bounds=map`.",
            citation: "Münstermann et al. 2018, Moment-Based Order-Independent Transparency; Peters et al. 2017",
            role: Role::Practical,
            colour: 0x7a4a1e,
            marker: Marker::Hexagon,
            shader: "occlusion/msm.wgsl",
            source: include_str!("../../../shaders/occlusion/msm.wgsl"),
            params: &[GEOMETRY, TEXELS, PARAMS],
            monotone: true,
            bounded: true,
            tolerance: 1e-3,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        let bias = match params.choice("storage")? {
            "f16" => BIAS_F16,
            _ => BIAS_F32,
        };
        let own_share = params.number("overestimation")?;
        let own_bounds = params.choice("bounds")? == "texel";
        Ok(Twin::Map(Box::new(Moments {
            bias,
            own_share,
            own_bounds,
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let mut names = vec!["optical depth".to_owned()];
        names.extend((1..=4).map(|i| format!("moment {i}")));
        if params.choice("bounds")? == "texel" {
            names.extend(["near bound", "far bound"].map(str::to_owned));
        }
        Ok(names)
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        Ok(Plan::array(match params.choice("bounds")? {
            "texel" => 7,
            _ => 5,
        }))
    }

    /// Three points stand for the uniform distribution; measured 0.060, and 0.63 with the published overestimation.
    fn homogeneous_error(&self) -> f64 {
        0.07
    }
}

/// Bias of f32 moments, as published.
const BIAS_F32: f64 = 5e-7;
/// Bias of f16 moments. Of 120 000 distributions of one point, two points and narrow clusters, rounded or cut off, none
/// needs more than 2.1e-3 to keep its Hankel matrix positive.
const BIAS_F16: f64 = 3e-3;
/// The moments that the bias draws toward: those of a distribution far from any single point.
const SPREAD: [f64; 4] = [0.0, 0.375, 0.0, 0.375];
/// Largest optical thickness of a step.
const LARGEST_THICKNESS: f64 = 10.0;

/// V = exp(−b₀ F), F from four moments.
struct Moments {
    bias: f64,
    /// Share of the weight at a depth that counts as in front of it.
    own_share: f64,
    own_bounds: bool,
}

impl Moments {
    /// Near and far edge of the depths that a column's moments are taken over, over L_max.
    fn interval(&self, column: &Column) -> [f64; 2] {
        if self.own_bounds {
            column.occupied_interval()
        } else {
            [0.0, 1.0]
        }
    }
}

/// z in −1…1 of a depth between `near` and `far`, beyond them the nearer end.
fn position(depth: f64, [near, far]: [f64; 2]) -> f64 {
    let offset = at_least_zero(depth - near);
    if offset >= far - near {
        1.0
    } else {
        2.0 * offset / (far - near) - 1.0
    }
}

impl Encoding for Moments {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let interval = self.interval(column);
        let bounds = &interval[..if self.own_bounds { 2 } else { 0 }];
        let mut sums = [0.0; 5];
        for (k, thickness) in column.thicknesses().enumerate() {
            let thickness = smaller(thickness, LARGEST_THICKNESS);
            let z = position(column.depth_at(k, column.fraction), interval);
            for (power, sum) in sums.iter_mut().enumerate() {
                *sum = rounding.computed(*sum + thickness * z.powi(power as i32));
            }
        }
        if sums[0] <= 1e-20 {
            return [&[0.0; 5], bounds].concat();
        }
        let [total, moments @ ..] = sums;
        let moments = moments.map(|sum| rounding.computed(sum / total));
        [&[total], &moments[..], bounds].concat()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let biased = |i: usize| values[i + 1] + self.bias * (SPREAD[i] - values[i + 1]);
        let interval = match values[5..] {
            [near, _] if look_up.depth <= near => return 1.0,
            [near, far] => [near, far],
            _ => [0.0, 1.0],
        };
        let z = position(look_up.depth, interval);
        let share = share_before(std::array::from_fn(biased), z, self.own_share);
        rounding.computed((-values[0] * share).exp())
    }
}

/// F(z): of the distribution on three points, z among them, that has the moments `b`, what lies below z and `own` of
/// what lies at it.
fn share_before(b: [f64; 4], z: f64, own: f64) -> f64 {
    let c = solved(b, z);
    // The other two points are the roots of c₀ + c₁x + c₂x².
    let half = 0.5 * c[1] / c[2];
    let root = (half * half - c[0] / c[2]).sqrt();
    let points = [-half - root, -half + root];
    let weight = |at: f64, other: f64, third: f64| {
        (b[1] - b[0] * (other + third) + other * third) / ((at - other) * (at - third))
    };
    let below = |i: usize| match points[i] < z {
        true => weight(points[i], z, points[1 - i]),
        false => 0.0 * points[i],
    };
    own * weight(z, points[0], points[1]) + below(0) + below(1)
}

/// c of H c = (1, z, z²), H the Hankel matrix of the moments, up to a factor: by its adjugate.
fn solved([b1, b2, b3, b4]: [f64; 4], z: f64) -> [f64; 3] {
    let row = |a: f64, b: f64, c: f64| a + b * z + c * z * z;
    let first = row(b2 * b4 - b3 * b3, b2 * b3 - b1 * b4, b1 * b3 - b2 * b2);
    let second = row(b2 * b3 - b1 * b4, b4 - b2 * b2, b1 * b2 - b3);
    let third = row(b1 * b3 - b2 * b2, b1 * b2 - b3, b2 - b1 * b1);
    [first, second, third]
}
