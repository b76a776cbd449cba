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
    FORM,
    FRONT,
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
    ],
    clouds: &[trial("", "mean=fitted")],
    texels: &[
        trial("", "mean=all"),
        trial("mean=all front=first", "mean=all"),
        trial("mean=fitted", "mean=occupied"),
        trial("form=published", "form=published mean=all"),
        trial(
            "mean=fitted fit=warped placement=occupied",
            "mean=fitted fit=axes",
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
            texel: "3",
            expect: "Extinction is one mean from the front on: light keeps fading in the gaps between clouds, which darkens at a low sun, and a second deck upsets the mean, most with `mean=fitted`. With `mean=all` light leaks into every cloud.",
            citation: "Hillaire 2020, A Scalable and Production Ready Sky and Atmosphere (Unreal Engine clouds); thesis M, Algorithms 5 and 6",
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
            published: params.choice("form")? == "published",
        })))
    }

    fn value_names(&self, _params: &Params) -> Result<Vec<String>> {
        let names = [
            "front z",
            "mean extinction × depth",
            "largest optical depth",
        ];
        Ok(names.map(str::to_owned).into())
    }

    fn plan(&self, _params: &Params) -> Result<Plan> {
        Ok(Plan::array(3))
    }
}

/// Largest stored τ_max of the stable form: e^(−64) is black in any picture, and f16 holds the value.
const LARGEST_TAU: f64 = 64.0;
/// Largest σ̄·L_max of the stable form: f16 ends at 65504.
const LARGEST_MEAN: f64 = 6e4;

/// V = exp(−min(τ_max, σ̄ (d − z))).
struct Beer {
    mean: &'static str,
    front: Front,
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
}

impl Encoding for Beer {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
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

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let behind = at_least_zero(look_up.depth - values[0]);
        let tau = smaller(values[2], rounding.computed(values[1] * behind));
        let transmittance = rounding.computed((-tau).exp());
        if self.published {
            rounding.computed(transmittance * tau)
        } else {
            transmittance
        }
    }
}
