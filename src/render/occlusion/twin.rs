//! The f64 twin of a method: the same equations as its shader, written from the definitions, for the oracle.
//!
//! A twin sees light rays and columns, not the scene: it can be evaluated for any extinction. NaN passes through every
//! twin, so that the failure of a form shows.

use super::MethodSetup;
#[cfg(doc)]
use super::rounding::FloatFormat;
use super::rounding::Rounding;
use super::spans::{Grain, Spans};
use crate::error::Result;
use crate::param::Params;

/// Optical depth behind which nothing can change an f64 sum of order 1: 53 ln 2.
pub const OPAQUE_TAU: f64 = 36.736_800_569_677_1;
/// Transmittance below which a column's cloud begins (thesis M).
const FRONT_TRANSMITTANCE: f64 = 0.99;
/// Optical depth behind which a column with `column_end=dark` takes no sample: T = 2⁻⁸.
const DARK_TAU: f64 = 8.0 * std::f64::consts::LN_2;
/// Steps of the fallback march outside a map.
const FALLBACK_STEPS: u32 = 6;

/// Extinction along a light ray inside the layer, gaps excluded.
pub trait LightRay {
    /// Length of the ray, metres, ≥ 0.
    fn length_m(&self) -> f64;

    /// Extinction at distance `s_m` along it, m⁻¹, ≥ 0.
    fn extinction_per_m(&self, s_m: f64) -> f64;

    /// Length before and behind `s_m` over which extinction is provably 0, metres, whether or not marches skip it;
    /// `None` = nothing is known.
    fn empty_m(&self, _s_m: f64) -> Option<f64> {
        None
    }

    /// Length from `s_m` on over which extinction is provably 0, metres; `None` = nothing is known.
    fn clear_m(&self, _s_m: f64) -> Option<f64> {
        None
    }
}

/// The f64 twin of a method.
pub enum Twin {
    /// A method without a map.
    March(Box<dyn LightMarch>),
    /// A method with a map.
    Map(Box<dyn Encoding>),
}

/// Light transmittance by marching.
pub trait LightMarch: Send + Sync {
    /// V at the start of `ray`, which leads to the sun; `rnd` in `[0, 1)` is the sample's noise.
    fn transmittance(&self, ray: &dyn LightRay, rnd: f64) -> f64;
}

/// Encoding of a column in a texel, and V at a depth from it.
pub trait Encoding: Send + Sync {
    /// Values of a texel, before storage rounds them.
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64>;

    /// The values as the map stores them. A method that packs values into words overrides this: where
    /// [`Rounding::storage`] is [`FloatFormat::Packed`] it rounds each value as its packing does.
    fn stored(&self, values: Vec<f64>, rounding: &Rounding) -> Vec<f64> {
        let stored = values.into_iter().map(|value| rounding.stored(value));
        stored.collect()
    }

    /// Radius in texels of the square from which passes after the columns mix a texel's values; 0 = there are none.
    fn mixed_texels(&self) -> u32 {
        0
    }

    /// A texel's values after those passes, before storage rounds them, from the stored values of its square, row after
    /// row; beyond the map's edge the nearest texel stands in.
    fn mix(&self, square: &[&[f64]]) -> Vec<f64> {
        square[square.len() / 2].to_vec()
    }

    /// V at a depth, from the values as stored. For a map in a 3-D texture the values are already interpolated between
    /// four columns, slice by slice; [`between_slices`] does the rest of a trilinear fetch.
    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64;
}

/// Depth of a look-up, and length of the column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookUp {
    /// d/L_max, 0…1.
    pub depth: f64,
    /// Length of the texel's own column over L_max, 0…1.
    pub length: f64,
    /// L_max, metres.
    pub depth_m: f64,
}

/// A map column, marched from the sun side.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Length inside the layer, metres.
    pub length_m: f64,
    /// L_max, the longest column of the map, metres.
    pub depth_m: f64,
    /// Length of a step, metres; of placed steps, of medium.
    pub step_m: f64,
    /// Where the steps lie; `None` = equal steps over the whole column.
    pub spans: Option<Spans>,
    /// Position of a sample in its step: 0.5 midpoint, 1 far end, 0 near end.
    pub fraction: f64,
    /// Extinction of each step, m⁻¹; 0 where the column takes fewer samples than it may.
    pub extinction_per_m: Vec<f64>,
}

/// How the columns of a map are marched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColumnRules {
    /// Most steps.
    steps: u32,
    /// Parameter `sampling`.
    sampling: &'static str,
    /// Steps lie in what may hold medium.
    placed: bool,
    /// Nothing is sampled behind the depth where T falls below [`DARK_TAU`].
    ends_dark: bool,
}

impl ColumnRules {
    /// Equal steps over the whole column.
    pub fn even(steps: u32, sampling: &'static str) -> Self {
        Self {
            steps,
            sampling,
            placed: false,
            ends_dark: false,
        }
    }

    /// Reads the parameters of a map.
    pub fn new(params: &Params) -> Result<Self> {
        Ok(Self {
            steps: params.int("steps")?,
            sampling: params.choice("sampling")?,
            placed: params.choice("placement")? == "occupied",
            ends_dark: params.choice("column_end")? == "dark",
        })
    }
}

/// Definition of a column's front, where its cloud begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Front {
    /// Where T first falls below 0.99, extinction constant over a step (thesis M).
    Threshold,
    /// Near edge of the first step with extinction.
    First,
    /// Mean depth of the steps with extinction, each weighted with the transmittance behind it (Matsuda 2025).
    Weighted,
}

impl Front {
    /// Reads the method's parameter `front`.
    pub fn new(params: &Params) -> Result<Self> {
        Ok(match params.choice("front")? {
            "first" => Self::First,
            "weighted" => Self::Weighted,
            _ => Self::Threshold,
        })
    }
}

impl Column {
    /// Marches `ray` as a map's parameters say, in a map whose longest column is `depth_m`. `cell_m` is the edge of the
    /// cells of the grid of empty space, where there is one.
    pub fn march(
        ray: &dyn LightRay,
        rules: &ColumnRules,
        cell_m: Option<f64>,
        depth_m: f64,
    ) -> Self {
        let length_m = ray.length_m();
        let grain = Grain::new(cell_m, depth_m);
        let spans = rules
            .placed
            .then(|| Spans::walk(ray, length_m, grain.part_m));
        let (taken, marched_m) = match &spans {
            None => (rules.steps, length_m),
            Some(spans) => {
                let occupied_m = spans.occupied_m();
                (grain.steps(rules.steps, occupied_m), occupied_m)
            }
        };
        let n = f64::from(taken.max(1));
        let step_m = marched_m / n;
        let fraction = match rules.sampling {
            "end" => 1.0,
            "quadratic" => 0.0,
            _ => 0.5,
        };
        let travelled = |k: f64| match rules.sampling {
            "quadratic" => k * (k + 1.0) / (n - 1.0).max(1.0),
            _ => k + fraction,
        };
        let position_m = |x: f64| match &spans {
            None => x * step_m,
            Some(spans) => spans.position_m(x * step_m),
        };
        let mut extinction_per_m = vec![0.0; rules.steps as usize];
        let mut tau = 0.0;
        for (k, sigma) in extinction_per_m.iter_mut().take(taken as usize).enumerate() {
            if rules.ends_dark && tau > DARK_TAU {
                break;
            }
            *sigma = ray.extinction_per_m(position_m(travelled(k as f64)));
            tau += *sigma * step_m;
        }
        Self {
            length_m,
            depth_m,
            step_m,
            fraction,
            extinction_per_m,
            spans,
        }
    }

    /// Depth of the point at `fraction` of step `k`, over L_max.
    pub fn depth_at(&self, k: usize, fraction: f64) -> f64 {
        let x = k as f64 + fraction;
        match &self.spans {
            None => x * self.step_m / self.depth_m,
            Some(spans) => spans.position_m(x * self.step_m) / self.depth_m,
        }
    }

    /// Optical depth before `depth_m` metres, extinction constant over a step.
    pub fn optical_depth_before(&self, depth_m: f64) -> f64 {
        let n = self.extinction_per_m.len();
        let marched_m = match &self.spans {
            None => depth_m,
            Some(spans) => spans.before_m(depth_m),
        };
        let steps = marched_m / self.step_m.max(1e-300);
        let steps = steps.clamp(0.0, n as f64);
        let whole = (steps as usize).min(n - 1);
        let before: f64 = self.thicknesses().take(whole).sum();
        before + self.extinction_per_m[whole] * self.step_m * (steps - whole as f64)
    }

    /// Near edge of the first step with extinction and far edge of the last, over L_max; 0 and 0 where there is none.
    pub fn occupied_interval(&self) -> [f64; 2] {
        let occupied = |s: &f64| *s > 0.0;
        let first = self.extinction_per_m.iter().position(occupied);
        let last = self.extinction_per_m.iter().rposition(occupied);
        match first.zip(last) {
            Some((first, last)) => [self.depth_at(first, 0.0), self.depth_at(last, 1.0)],
            None => [0.0, 0.0],
        }
    }

    /// Optical thickness of each step.
    pub fn thicknesses(&self) -> impl Iterator<Item = f64> + '_ {
        self.extinction_per_m.iter().map(|s| s * self.step_m)
    }

    /// The front over L_max; `None` where the column has none.
    pub fn front(&self, rule: Front) -> Option<f64> {
        if rule == Front::Weighted {
            return self.weighted_front();
        }
        let wanted = -FRONT_TRANSMITTANCE.ln();
        let mut tau = 0.0;
        for (k, thickness) in self.thicknesses().enumerate() {
            let within = match rule {
                Front::First => (thickness > 0.0).then_some(0.0),
                _ => (tau + thickness > wanted).then(|| ((wanted - tau) / thickness).max(0.0)),
            };
            if let Some(fraction) = within {
                return Some(self.depth_at(k, fraction));
            }
            tau += thickness;
        }
        None
    }

    /// Σ T d/Σ T over the steps with extinction, T taken over that behind the first of them.
    fn weighted_front(&self) -> Option<f64> {
        let occupied = self.thicknesses().enumerate().filter(|(_, t)| *t > 0.0);
        let (mut tau, mut depths, mut weights) = (0.0, 0.0, 0.0);
        for (k, thickness) in occupied {
            tau += if weights > 0.0 { thickness } else { 0.0 };
            let weight = f64::exp(-tau);
            depths += weight * self.depth_at(k, self.fraction);
            weights += weight;
        }
        (weights > 0.0).then(|| depths / weights)
    }
}

/// exp(−Σ σ(sₖ)Δₖ) over intervals `[boundary(k), boundary(k + 1)]·length_m`, k < `steps`, sampled at `fraction` of each.
pub fn march(
    ray: &dyn LightRay,
    length_m: f64,
    steps: u32,
    boundary: impl Fn(f64) -> f64,
    fraction: f64,
) -> f64 {
    let mut tau = 0.0;
    for k in 0..steps {
        let near_m = boundary(f64::from(k)) * length_m;
        let far_m = boundary(f64::from(k) + 1.0) * length_m;
        tau += ray.extinction_per_m(near_m + fraction * (far_m - near_m)) * (far_m - near_m);
        if tau > OPAQUE_TAU {
            break;
        }
    }
    (-tau).exp()
}

/// The first metres toward the sun, marched at every look-up; the map answers for what is behind them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearMarch {
    /// Steps, quadratically spaced; 0 = the map answers for the whole ray.
    steps: u32,
    /// Reach, metres; the ray's length where that is shorter.
    reach_m: f64,
}

impl NearMarch {
    /// The parameters `near_steps` and `near_m` of a map.
    pub fn new(setup: &MethodSetup) -> Result<Self> {
        let steps = setup.params.int("near_steps")?;
        let reach_m = setup.params.number("near_m")?;
        Ok(Self { steps, reach_m })
    }

    /// Metres of a ray of `length_m` that are marched.
    pub fn reach_m(self, length_m: f64) -> f64 {
        match self.steps {
            0 => 0.0,
            _ => self.reach_m.min(length_m),
        }
    }

    /// Transmittance of the marched part of `ray`.
    pub fn transmittance(self, ray: &dyn LightRay) -> f64 {
        let n = f64::from(self.steps);
        let reach_m = self.reach_m(ray.length_m());
        march(ray, reach_m, self.steps, |k| (k / n).powi(2), 0.5)
    }
}

/// V of the fallback outside a map's rectangle: a march of six quadratic steps.
pub fn fallback(ray: &dyn LightRay) -> f64 {
    let n = f64::from(FALLBACK_STEPS);
    march(
        ray,
        ray.length_m(),
        FALLBACK_STEPS,
        |k| (k / n).powi(2),
        0.5,
    )
}

/// Value of a sampler at `depth` in 0…1 of a column of voxels, one value each: linear between the voxels' centres,
/// constant beyond the first and the last.
pub fn between_slices(values: &[f64], depth: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let position = (depth * values.len() as f64 - 0.5).clamp(0.0, last as f64);
    let low = position as usize;
    let (near, far) = (values[low], values[(low + 1).min(last)]);
    near + (far - near) * (position - low as f64)
}

/// `value`, or 0 below it; NaN stays, unlike with `f64::max`.
pub fn at_least_zero(value: f64) -> f64 {
    if value < 0.0 { 0.0 } else { value }
}

/// The smaller of two; NaN in either stays, unlike with `f64::min`.
pub fn smaller(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}
