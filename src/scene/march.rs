//! How view rays are sampled: the same for every method and for the truth.

use super::{Problem, check};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Sampling of the view rays. Exactly one of `steps` and `step_m` is in force: `step_m` when given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct March {
    /// Steps over the part of the ray inside the layer, 1…4096.
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
    /// Exact for constant extinction and light over the step: σ(1 − e^(−σΔ))/σ (Hillaire 2016).
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

    /// No view ray takes more steps than this.
    pub fn most_steps(&self) -> u32 {
        if self.step_m.is_some() {
            Self::MAX_STEPS
        } else {
            self.steps
        }
    }

    pub(super) fn validate(&self) -> Result<(), Problem> {
        check("/march/steps", f64::from(self.steps), "1…4096", |v| {
            v >= 1.0 && v <= f64::from(Self::MAX_STEPS)
        })?;
        self.step_m.map_or(Ok(()), |v| {
            check("/march/step_m", v, "above 0 m", |v| v > 0.0)
        })
    }
}
