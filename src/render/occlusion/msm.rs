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
        name: "moments",
        unit: "",
        doc: "Power moments of where the optical depth lies; the distribution of three or four points with these moments stands for the column.",
        kind: ParamKind::Choice {
            options: &["four", "six"],
            default: "four",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
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
        trial("moments=six", "moments=four"),
        trial("moments=six storage=f32", "storage=f32"),
        trial("moments=six bounds=map", "moments=six bounds=texel"),
        trial(
            "moments=six overestimation=0.5 lookup=hardware",
            "moments=six overestimation=0.55 lookup=hardware",
        ),
    ],
    clouds: &[
        trial("bounds=map", "bounds=texel"),
        trial("moments=six bounds=map", "moments=six bounds=texel"),
    ],
    texels: &[
        trial("", "sampling=end"),
        trial("moments=six", "moments=six sampling=end"),
        trial(
            "moments=six bounds=map",
            "moments=six bounds=map sampling=end",
        ),
        trial("bounds=map", "bounds=map sampling=end"),
        trial("bounds=map fit=warped", "bounds=map fit=axes"),
    ],
    exact: &["overestimation=0.5", "overestimation=0.5 moments=six"],
};

impl LightOcclusion for Msm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "msm",
            title: "Moment shadow map",
            summary: "moment shadow map: optical depth and m = 4 or 6 moments of its distribution",
            texel: "m + 1 + 2",
            expect: "Three points, or four, stand for the column: light fades in gaps between clouds, and in deep columns shadow begins before the medium does. In f16 the bias that rounding calls for smears optical depth over the whole interval, most with `bounds=map`.",
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
        let six = params.choice("moments")? == "six";
        let bias = match (params.choice("storage")?, six) {
            ("f16", false) => BIAS_F16,
            ("f16", true) => BIAS_F16_SIX,
            (_, false) => BIAS_F32,
            (_, true) => BIAS_F32_SIX,
        };
        let own_share = params.number("overestimation")?;
        let own_bounds = params.choice("bounds")? == "texel";
        Ok(Twin::Map(Box::new(Moments {
            spread: if six { SPREAD_SIX } else { SPREAD },
            bias,
            own_share,
            own_bounds,
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let mut names = vec!["optical depth".to_owned()];
        names.extend((1..=count(params)?).map(|i| format!("moment {i}")));
        if params.choice("bounds")? == "texel" {
            names.extend(["near bound", "far bound"].map(str::to_owned));
        }
        Ok(names)
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let bounds = match params.choice("bounds")? {
            "texel" => 2,
            _ => 0,
        };
        Ok(Plan::array(1 + count(params)? + bounds))
    }

    /// Three points stand for the uniform distribution; measured 0.060, and 0.63 with the published overestimation.
    fn homogeneous_error(&self) -> f64 {
        0.07
    }
}

/// Moments beside the optical depth.
fn count(params: &Params) -> Result<u32> {
    Ok(match params.choice("moments")? {
        "six" => 6,
        _ => 4,
    })
}

/// Bias of f32 moments, as published.
const BIAS_F32: f64 = 5e-7;
/// Bias of f16 moments. Of 120 000 distributions of one point, two points and narrow clusters, rounded or cut off, none
/// needs more than 2.1e-3 to keep its Hankel matrix positive.
const BIAS_F16: f64 = 3e-3;
/// The moments that the bias draws toward: those of a distribution far from any single point.
const SPREAD: &[f64] = &[0.0, 0.375, 0.0, 0.375];
/// Bias of six f32 moments. As published 5e-6, for single sums: of 4000 distributions of up to three clusters, summed in
/// f32 over 100 steps, the worst needs 1.6e-5, of 400 summed over 1000 steps 4.5e-5.
const BIAS_F32_SIX: f64 = 5e-5;
/// Bias of six f16 moments: of 60 000 distributions of up to four points or clusters, rounded or cut off, none needs more
/// than 1.6e-2.
const BIAS_F16_SIX: f64 = 2e-2;
/// What six moments are drawn toward, as published for 16 bits: the least eigenvalue of its Hankel matrix, 0.027, is twice
/// that of the published f32 one.
const SPREAD_SIX: &[f64] = &[0.0, 0.5566, 0.0, 0.489, 0.0, 0.478_693_82];
/// Largest optical thickness of a step.
const LARGEST_THICKNESS: f64 = 10.0;

/// V = exp(−b₀ F), F from four or six moments.
struct Moments {
    spread: &'static [f64],
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
        let mut sums = vec![0.0; self.spread.len() + 1];
        for (k, thickness) in column.thicknesses().enumerate() {
            let thickness = smaller(thickness, LARGEST_THICKNESS);
            let z = position(column.depth_at(k, column.fraction), interval);
            for (power, sum) in sums.iter_mut().enumerate() {
                *sum = rounding.computed(*sum + thickness * z.powi(power as i32));
            }
        }
        if sums[0] <= 1e-20 {
            sums.fill(0.0);
            return [&sums, bounds].concat();
        }
        let total = sums[0];
        for moment in &mut sums[1..] {
            *moment = rounding.computed(*moment / total);
        }
        [&sums, bounds].concat()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let (moments, edges) = values[1..].split_at(self.spread.len());
        let pairs = moments.iter().zip(self.spread);
        let biased: Vec<f64> = pairs.map(|(b, s)| b + self.bias * (s - b)).collect();
        let interval = match *edges {
            [near, _] if look_up.depth <= near => return 1.0,
            [near, far] => [near, far],
            _ => [0.0, 1.0],
        };
        let z = position(look_up.depth, interval);
        let share = match biased[..] {
            [b1, b2, b3, b4] => share_before([b1, b2, b3, b4], z, self.own_share),
            _ => share_before_of(&biased, z, self.own_share),
        };
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

/// F(z) for any even number of moments `b` with a positive Hankel matrix H. With v(x) = (1, x, x², …) the distribution
/// that has them and a point at z has its other points where v(z)ᵀH⁻¹v(x) = 0, and the weight 1/(v(x)ᵀH⁻¹v(x)) at each.
/// What lies more than [`FAR`] away has no weight that could be seen.
fn share_before_of(b: &[f64], z: f64, own: f64) -> f64 {
    let order = b.len() / 2;
    let moment = |i: usize| if i == 0 { 1.0 } else { b[i - 1] };
    let solved = |x: f64| {
        let row = |i: usize| {
            let hankel = (0..=order).map(|j| moment(i + j));
            hankel.chain([x.powi(i as i32)]).collect()
        };
        eliminated((0..=order).map(row).collect())
    };
    let weight = |x: f64| 1.0 / at(&solved(x), x);
    let others = roots(&solved(z));
    let below = others.into_iter().filter(|x| *x < z).map(weight);
    own * weight(z) + below.sum::<f64>()
}

/// Distance beyond which points of support are left out: six moments leave a weight below 1e-18 there.
const FAR: f64 = 1e3;

/// The solution of linear equations, a row each with the right side last, of a positive matrix: by elimination without
/// pivoting.
fn eliminated(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for k in 0..n {
        let pivot = rows[k].clone();
        let others = rows.iter_mut().enumerate().filter(|(i, _)| *i != k);
        for (_, row) in others {
            let factor = row[k] / pivot[k];
            for (value, of_pivot) in row.iter_mut().zip(&pivot) {
                *value -= factor * of_pivot;
            }
        }
    }
    let solved = rows.iter().enumerate().map(|(i, row)| row[n] / row[i]);
    solved.collect()
}

/// Σ cᵢ xⁱ
fn at(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Real roots of a polynomial in −[`FAR`]…[`FAR`], in growing order, by bisection between those of its derivative.
fn roots(coefficients: &[f64]) -> Vec<f64> {
    if coefficients.len() < 2 {
        return Vec::new();
    }
    let powers = coefficients.iter().enumerate().skip(1);
    let slope: Vec<f64> = powers.map(|(i, c)| i as f64 * c).collect();
    let turns = roots(&slope);
    let edges = [&[-FAR], &turns[..], &[FAR]].concat();
    let root = |edge: &[f64]| {
        let [mut low, mut high] = [edge[0], edge[1]];
        let rising = at(coefficients, high) > 0.0;
        if (at(coefficients, low) > 0.0) == rising {
            return None;
        }
        for _ in 0..64 {
            let middle = 0.5 * (low + high);
            match (at(coefficients, middle) > 0.0) == rising {
                true => high = middle,
                false => low = middle,
            }
        }
        Some(0.5 * (low + high))
    };
    edges.windows(2).filter_map(root).collect()
}
