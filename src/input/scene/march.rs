//! Sampling of view rays: the same for every method and for the truth.

use super::{MAX_MAGNITUDE, Problem, check};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Sampling of the view rays. Exactly one of `steps` and `step_m` is in force: `step_m` when given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct March {
    /// Steps over the part of the ray inside the layer, 1…4096.
    #[schemars(range(min = 1, max = 4096))]
    pub steps: u32,
    /// Length of a step, metres; replaces `steps` when given (at most 4096 steps a ray).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_m: Option<f64>,
    /// Each pixel starts its ray at its own fraction of a step (trades banding for noise); false = midpoints.
    pub jitter: bool,
    /// How a step's light is summed.
    pub integration: Integration,
}

/// How the light of one step is summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Integration {
    /// Exact for constant extinction and light over the step: L·(1 − e^(−σΔ)) (Hillaire 2016).
    #[default]
    Analytic,
    /// Thesis M, Algorithm 1: transmittance first, then L·σ·T·Δ.
    Thesis,
}

impl Default for March {
    fn default() -> Self {
        Self {
            steps: 64,
            step_m: None,
            jitter: true,
            integration: Integration::Analytic,
        }
    }
}

impl March {
    /// Most steps a view ray may take.
    pub const MAX_STEPS: u32 = 4096;

    /// Largest number of steps of any view ray.
    pub fn most_steps(&self) -> u32 {
        if self.step_m.is_some() {
            Self::MAX_STEPS
        } else {
            self.steps
        }
    }

    /// This sampling with steps of a quarter of the length, to measure the discretisation error of the view march;
    /// `None` when a ray of `longest_m` would then take more than [`March::MAX_STEPS`].
    pub fn quartered(&self, longest_m: f64) -> Option<Self> {
        let steps = self.steps.saturating_mul(4);
        let step_m = self.step_m.map(|step_m| step_m / 4.0);
        let taken = step_m.map_or(f64::from(steps), |step_m| (longest_m / step_m).ceil());
        (taken <= f64::from(Self::MAX_STEPS)).then(|| Self {
            steps,
            step_m,
            ..self.clone()
        })
    }

    pub(super) fn validate(&self) -> Result<(), Problem> {
        check("/march/steps", f64::from(self.steps), "1…4096", |v| {
            v >= 1.0 && v <= f64::from(Self::MAX_STEPS)
        })?;
        self.step_m.map_or(Ok(()), |v| {
            check("/march/step_m", v, "1e-9…1e12 m", |v| {
                (1e-9..=MAX_MAGNITUDE).contains(&v)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_the_step_within_the_limit() {
        let march = |steps, step_m| March {
            steps,
            step_m,
            ..March::default()
        };
        let finer = |steps, step_m| march(steps, step_m).quartered(1e4);
        assert_eq!(finer(64, None), Some(march(256, None)));
        assert_eq!(finer(1024, None), Some(march(4096, None)));
        assert_eq!(finer(1025, None), None);
        assert_eq!(finer(64, Some(40.0)), Some(march(256, Some(10.0))));
        assert_eq!(finer(64, Some(8.0)), None, "5000 steps");
    }
}
