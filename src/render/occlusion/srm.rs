//! Secondary march: a few samples from every view sample toward the sun.

use super::LightOcclusion;
use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::spans::{LEAST_GAP, Spanned, Spans};
use super::twin::{LightMarch, LightRay, Twin, march};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};

/// Secondary march.
pub struct Srm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "steps",
        unit: "",
        doc: "Samples of a light ray.",
        kind: ParamKind::Int {
            min: 1,
            max: 1000,
            default: 10,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "spacing",
        unit: "",
        doc: "quadratic and exponential steps grow with distance; uniform steps reach the layer's exit, uniform_reach ends at reach_m.",
        kind: ParamKind::Choice {
            options: &["quadratic", "uniform", "uniform_reach", "exponential"],
            default: "quadratic",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "reach_m",
        unit: "m",
        doc: "Length of the light ray, at most the way to the layer's exit.",
        kind: ParamKind::Float {
            min: 1e-6,
            max: 1e6,
            default: 1000.0,
        },
        applies: Applies::Choice {
            of: "spacing",
            is: &["uniform_reach"],
        },
        as_printed: &[],
    },
    ParamSpec {
        name: "sampling",
        unit: "",
        doc: "Where a step is sampled: midpoint, far end (thesis M), or jittered by the pixel's noise.",
        kind: ParamKind::Choice {
            options: &["midpoint", "end", "jittered"],
            default: "midpoint",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "placement",
        unit: "",
        doc: "Where a ray's samples lie: even = spaced over its whole length; occupied = over what may hold medium alone, so that none is spent on provably empty space.",
        kind: ParamKind::Choice {
            options: &["even", "occupied"],
            default: "even",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "steps=9"),
        trial("spacing=uniform steps=20", "spacing=uniform steps=18"),
        trial(
            "spacing=uniform_reach reach_m=300",
            "spacing=uniform_reach reach_m=330",
        ),
        trial("spacing=exponential steps=6", "spacing=exponential steps=7"),
        trial("sampling=end", "sampling=midpoint"),
        trial("sampling=jittered", "sampling=midpoint"),
    ],
    clouds: &[
        trial("", "steps=9"),
        trial("sampling=jittered", "sampling=midpoint"),
        // Cells of the small volume are too large for parts of a ray to be empty.
        trial("placement=occupied", "placement=even"),
    ],
    texels: &[],
    exact: &[""],
};

impl LightOcclusion for Srm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "srm",
            title: "Secondary ray march",
            summary: "marches 1–1000 samples toward the sun; spacing uniform, quadratic, exponential or of fixed reach",
            texel: "–",
            expect: "Cloud between two samples is missed, so light leaks, most at a low sun, where light rays are long. More steps lower the error and raise the time.",
            citation: "Harris & Lastra 2001, Real-Time Cloud Rendering; Schneider & Vos 2015; thesis M, Algorithm 2",
            role: Role::Practical,
            colour: 0x173a8f,
            marker: Marker::Circle,
            shader: "occlusion/srm.wgsl",
            source: include_str!("../../../shaders/occlusion/srm.wgsl"),
            params: &[PARAMS],
            monotone: false,
            bounded: false,
            tolerance: 1e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::March(Box::new(SecondaryMarch {
            steps: params.int("steps")?,
            spacing: params.choice("spacing")?,
            reach_m: params.number("reach_m")?,
            sampling: params.choice("sampling")?,
            placed: params.choice("placement")? == "occupied",
        })))
    }

    fn light_turns(&self, params: &Params, _longest_path_m: f64) -> Result<f64> {
        let walk = match params.choice("placement")? {
            "occupied" => PARTS / LEAST_GAP,
            _ => 0.0,
        };
        Ok(params.number("steps")? + walk)
    }
}

/// Parts of a ray in which medium is looked for.
const PARTS: f64 = 24.0;

/// V = exp(−Σ σ(p + ω sₖ) Δₖ).
struct SecondaryMarch {
    steps: u32,
    spacing: &'static str,
    reach_m: f64,
    sampling: &'static str,
    placed: bool,
}

impl LightMarch for SecondaryMarch {
    fn transmittance(&self, ray: &dyn LightRay, rnd: f64) -> f64 {
        let n = f64::from(self.steps);
        let exit_m = ray.length_m();
        let length_m = match self.spacing {
            "uniform_reach" => exit_m.min(self.reach_m),
            _ => exit_m,
        };
        let boundary = |k: f64| match self.spacing {
            "quadratic" => (k / n).powi(2),
            // (2ᵏ − 1)/(2ⁿ − 1), over 2ⁿ in both parts: finite at any n.
            "exponential" => ((k - n).exp2() - (-n).exp2()) / (1.0 - (-n).exp2()),
            _ => k / n,
        };
        let fraction = match self.sampling {
            "end" => 1.0,
            "jittered" => rnd,
            _ => 0.5,
        };
        if !self.placed {
            return march(ray, length_m, self.steps, boundary, fraction);
        }
        let spans = Spans::walk(ray, length_m, length_m / PARTS);
        let spanned = Spanned { ray, spans: &spans };
        march(&spanned, spans.occupied_m(), self.steps, boundary, fraction)
    }
}
