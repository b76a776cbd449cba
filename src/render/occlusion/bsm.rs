//! Beer shadow map: front, mean extinction and largest optical depth of each light column.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, Front, LookUp, Twin, at_least_zero, smaller};
use super::{FORM, FRONT, GEOMETRY, LightOcclusion, Plan, TEXELS};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};

/// Beer shadow map.
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
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "tail",
        unit: "",
        doc: "A column ends where its T falls to 1e-4 (dark) or 1e-2 (dim): mean and weighted front know nothing of what lies behind, a fourth value adds an optical depth for it (Matsuda 2025, three-clouds).",
        kind: ParamKind::Choice {
            options: &["off", "dark", "dim"],
            default: "off",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    FORM,
    ParamSpec {
        doc: "Where a column's cloud begins: threshold = T first falls below 0.99 (thesis M), first = near edge of the first occupied step, weighted = mean depth of occupied steps, weighted with the T behind each (Matsuda 2025, three-clouds).",
        kind: ParamKind::Choice {
            options: &["threshold", "first", "weighted"],
            default: "threshold",
        },
        ..FRONT
    },
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "mean=all"),
        trial("storage=f32", "mean=fitted storage=f32"),
        trial("mean=all", "mean=fitted"),
        trial("mean=fitted lookup=hardware", "mean=fitted"),
        trial("front=first sampling=end", "front=threshold sampling=end"),
        trial("form=published", "form=stable"),
        trial("sampling=quadratic", "sampling=midpoint"),
        trial("front=weighted", "front=weighted sampling=end"),
        trial("tail=dark", "tail=dim"),
        trial("tail=dim", "tail=dark"),
        trial(
            "tail=dim front=weighted mean=fitted lookup=hardware",
            "tail=off front=weighted mean=fitted lookup=hardware",
        ),
    ],
    clouds: &[trial("", "mean=fitted")],
    texels: &[
        trial("", "mean=all"),
        trial("mean=all front=first", "mean=all"),
        trial("mean=fitted", "mean=occupied"),
        trial("form=published", "form=published mean=all"),
        trial("front=weighted", "front=first"),
        trial("tail=dim steps=12", "tail=dim steps=12 front=first"),
        trial(
            "tail=dim front=weighted mean=fitted",
            "tail=dim front=first mean=fitted",
        ),
    ],
    // With the other front, the threshold leaves out τ = 0.01.
    exact: &[
        "front=first",
        "front=first mean=all",
        "front=first mean=fitted",
    ],
};

impl LightOcclusion for Bsm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "bsm",
            title: "Beer shadow map",
            summary: "Beer shadow map: front, mean extinction, largest optical depth",
            texel: "3 + 1",
            expect: "Extinction is one mean from the front on: light keeps fading in the gaps between clouds, which darkens at a low sun, and a second deck upsets the mean, most with `mean=fitted`. With `mean=all` light leaks into every cloud. With `front=weighted` shadow begins inside of the cloud: light leaks into its lit side, most into thin cloud.",
            citation: "Hillaire 2020, A Scalable and Production Ready Sky and Atmosphere (Unreal Engine clouds); thesis M, Algorithms 5 and 6; Matsuda 2025, three-clouds (tail, weighted front)",
            role: Role::Practical,
            colour: 0xc4501b,
            marker: Marker::Up,
            shader: "occlusion/bsm.wgsl",
            source: include_str!("../../../shaders/occlusion/bsm.wgsl"),
            params: &[GEOMETRY, TEXELS, PARAMS],
            monotone: true,
            bounded: true,
            tolerance: 1e-4,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Beer {
            mean: params.choice("mean")?,
            front: Front::new(params)?,
            ends_at: match params.choice("tail")? {
                "dark" => Some(1e-4),
                "dim" => Some(1e-2),
                _ => None,
            },
            published: params.choice("form")? == "published",
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let names = [
            "front z",
            "mean extinction × depth",
            "largest optical depth",
            "tail",
        ];
        Ok(names[..values(params)?]
            .iter()
            .map(|n| (*n).to_owned())
            .collect())
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        Ok(Plan::array(values(params)? as u32))
    }
}

/// Values of a texel.
fn values(params: &Params) -> Result<usize> {
    Ok(if params.choice("tail")? == "off" {
        3
    } else {
        4
    })
}

/// Largest stored τ_max of the stable form: e^(−64) is black in any picture, and f16 holds the value.
const LARGEST_TAU: f64 = 64.0;
/// Largest σ̄·L_max of the stable form: f16 ends at 65504.
const LARGEST_MEAN: f64 = 6e4;

/// V = exp(−min(τ_max, σ̄ (d − z))), or with a tail exp(−min(τ_max + τ_t, σ̄ (d − z))).
struct Beer {
    mean: &'static str,
    front: Front,
    /// Transmittance at which a column with a tail ends.
    ends_at: Option<f64>,
    published: bool,
}

impl Beer {
    /// σ̄·L_max with the front at `z`.
    fn mean_extinction(&self, column: &Column, z: f64) -> f64 {
        let tau: f64 = column.thicknesses().sum();
        let over = |length_m: f64| {
            if length_m > 0.0 {
                tau / length_m * column.depth_m
            } else {
                0.0
            }
        };
        match self.mean {
            "all" => over(column.length_m),
            "fitted" => self
                .fitted(column, z)
                .unwrap_or_else(|| over(column.step_m)),
            _ => {
                let occupied = column.extinction_per_m.iter().filter(|s| **s > 0.0).count();
                over(occupied as f64 * column.step_m)
            }
        }
    }

    /// argmin over σ̄ of Σ w (τ − σ̄ x)², x = max(0, d − z), w = σT, at midpoints of steps; `None` where all weight is in
    /// front of z.
    fn fitted(&self, column: &Column, z: f64) -> Option<f64> {
        let (mut tau, mut cross, mut square) = (0.0, 0.0, 0.0);
        for (k, thickness) in column.thicknesses().enumerate() {
            let at_middle: f64 = tau + 0.5 * thickness;
            let x = (column.depth_at(k, 0.5) - z).max(0.0);
            let weight = column.extinction_per_m[k] * (-at_middle).exp();
            cross += weight * at_middle * x;
            square += weight * x * x;
            tau += thickness;
        }
        (square > 1e-30).then(|| cross / square)
    }

    /// Front, mean extinction and largest optical depth, bounded in the stable form.
    fn values(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let tau = rounding.computed(column.thicknesses().sum());
        let missing = if self.published { -1.0 } else { 1.0 };
        let z = column.front(self.front).unwrap_or(missing);
        let mean = rounding.computed(self.mean_extinction(column, z));
        if self.published {
            vec![z, mean, tau]
        } else {
            vec![z, mean.min(LARGEST_MEAN), tau.min(LARGEST_TAU)]
        }
    }
}

/// The column up to the step behind which T is at most `transmittance`, nothing behind, and the tail that stands for the
/// rest; `None` where T stays above.
fn ended(column: &Column, transmittance: f64) -> Option<(Column, f64)> {
    let mut behind = column.thicknesses().scan(0.0, |tau, thickness| {
        *tau += thickness;
        Some(*tau)
    });
    let last = behind.position(|tau| tau >= -transmittance.ln())?;
    let mut lit = column.clone();
    lit.extinction_per_m[last + 1..].fill(0.0);
    let occupied = lit.extinction_per_m.iter().filter(|s| **s > 0.0).count();
    let tail = 2.0 * column.step_m * (1.0 - occupied as f64).exp();
    Some((lit, tail.min(0.5 * column.step_m)))
}

impl Encoding for Beer {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let Some(transmittance) = self.ends_at else {
            return self.values(column, rounding);
        };
        let (mut values, tail) = match ended(column, transmittance) {
            Some((lit, tail)) => (self.values(&lit, rounding), tail),
            None => (self.values(column, rounding), 0.0),
        };
        values.push(match self.published {
            true => rounding.computed(tail),
            false => rounding.computed(tail).min(LARGEST_TAU),
        });
        values
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let behind = at_least_zero(look_up.depth - values[0]);
        let most = match values[3..] {
            [tail] => rounding.computed(values[2] + tail),
            _ => values[2],
        };
        let tau = smaller(most, rounding.computed(values[1] * behind));
        let transmittance = rounding.computed((-tau).exp());
        if self.published {
            rounding.computed(transmittance * tau)
        } else {
            transmittance
        }
    }
}
