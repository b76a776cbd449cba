//! Fourier opacity map: extinction along a light column as a truncated Fourier series.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin, at_least_zero};
use super::{FORM, GEOMETRY, LightOcclusion, Plan, TEXELS};
use crate::error::Result;
use crate::param::{Applies, AsPrinted, ParamKind, ParamSpec, Params};
use crate::shader_defs::Defs;
use std::f64::consts::{PI, TAU};

/// Fourier opacity map.
pub struct Fom;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "order",
        unit: "",
        doc: "Harmonics n; a texel holds 2n + 1 values.",
        kind: ParamKind::Int {
            min: 1,
            max: 15,
            default: 3,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "window",
        unit: "",
        doc: "Weights of the harmonics against ringing: none, lanczos, or fejer (monotone, blurrier).",
        kind: ParamKind::Choice {
            options: &["none", "lanczos", "fejer"],
            default: "none",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "bounds",
        unit: "",
        doc: "Interval of the series: the longest column of the map, or each texel's own occupied part (2 values more).",
        kind: ParamKind::Choice {
            options: &["map", "texel"],
            default: "map",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "sines",
        unit: "",
        doc: "Sine coefficients of the look-up: each harmonic's own.",
        kind: ParamKind::Choice {
            options: &["own", "first"],
            default: "own",
        },
        applies: Applies::AtLeast {
            of: "order",
            min: 2,
        },
        as_printed: &[AsPrinted {
            option: "first",
            doc: "the first coefficient in every harmonic, a misprint (thesis M, Algorithm 8)",
        }],
    },
    ParamSpec {
        name: "step_length",
        unit: "",
        doc: "Weight of a step in the sums: its own length.",
        kind: ParamKind::Choice {
            options: &["own", "metre"],
            default: "own",
        },
        applies: Applies::Always,
        as_printed: &[AsPrinted {
            option: "metre",
            doc: "one metre, a misprint (thesis M, Algorithm 7: the sums lack the length)",
        }],
    },
    FORM,
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "order=4"),
        trial("storage=f32", "order=4 storage=f32"),
        trial("bounds=texel", "bounds=map"),
        trial("order=7 window=lanczos", "order=7"),
        trial("sampling=quadratic", "sampling=end"),
        trial("sines=first", "sines=own"),
        trial("step_length=metre", "step_length=own"),
        trial(
            "order=5 window=fejer lookup=hardware",
            "order=5 window=lanczos lookup=hardware",
        ),
        trial("form=published lookup=nearest", "form=published"),
    ],
    clouds: &[trial("", "order=5")],
    texels: &[
        trial("", "sampling=end"),
        trial("bounds=texel order=5", "bounds=texel order=5 sampling=end"),
        trial("form=published", "form=published sampling=end"),
    ],
    exact: &[
        "",
        "order=7 window=fejer",
        "order=5 bounds=texel form=published",
    ],
};

impl LightOcclusion for Fom {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "fom",
            title: "Fourier opacity map",
            summary: "Fourier opacity map of order n",
            texel: "2n + 1",
            expect: "The series rings around thin, dense cloud: shadow begins before it, which darkens at a low sun, and behind it the optical depth is off by up to a fifth, so that T rises with depth. More harmonics and `bounds=texel` help, for more bytes.",
            citation: "Jansen & Bavoil 2010, Fourier Opacity Mapping, eqs. 6–9; thesis M, Algorithms 7 and 8",
            role: Role::Practical,
            colour: 0x8f2a7c,
            marker: Marker::Diamond,
            shader: "occlusion/fom.wgsl",
            source: include_str!("../../../shaders/occlusion/fom.wgsl"),
            params: &[GEOMETRY, TEXELS, PARAMS],
            monotone: false,
            bounded: false,
            tolerance: 2e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Fourier {
            order: params.int("order")?,
            window: params.choice("window")?,
            bounded: params.choice("bounds")? == "texel",
            first_sine: params.choice("sines")? == "first",
            metre: params.choice("step_length")? == "metre",
            published: params.choice("form")? == "published",
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let harmonic = |k: u32| [format!("a{k}"), format!("b{k}")];
        let mut names = vec!["a0".to_owned()];
        names.extend((1..=params.int("order")?).flat_map(harmonic));
        if params.choice("bounds")? == "texel" {
            names.extend(["near bound", "far bound"].map(str::to_owned));
        }
        Ok(names)
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let order = params.int("order")?;
        let bounds = if params.choice("bounds")? == "texel" {
            2
        } else {
            0
        };
        let values = 2 * order + 1 + bounds;
        let layers = values.div_ceil(4);
        let number = |v: u32| Some(v.cast_signed());
        let defs = Defs::from([
            ("ORDER".into(), number(order)),
            ("LAYERS".into(), number(layers)),
            ("PADDED".into(), number(4 * layers)),
        ]);
        Ok(Plan {
            defs,
            ..Plan::array(values)
        })
    }
}

/// Largest stored coefficient of the stable form: f16 ends at 65504.
const LARGEST_COEFFICIENT: f64 = 6e4;

/// τ(x) = a₀x/2 + Σ w_k [a_k sin 2πkx + b_k (1 − cos 2πkx)]/(2πk).
struct Fourier {
    order: u32,
    window: &'static str,
    bounded: bool,
    /// The misprint of the look-up: b₁ stands for every b_k.
    first_sine: bool,
    /// The misprint of the column pass: every step counts as one metre long.
    metre: bool,
    published: bool,
}

impl Fourier {
    /// Near and far edge of the interval that a column's series covers, over L_max.
    fn interval(&self, column: &Column) -> (f64, f64) {
        if !self.bounded {
            return (0.0, 1.0);
        }
        column.occupied_interval().into()
    }

    fn window(&self, k: u32) -> f64 {
        let x = f64::from(k) / f64::from(self.order + 1);
        match self.window {
            "lanczos" => (PI * x).sin() / (PI * x),
            "fejer" => 1.0 - x,
            _ => 1.0,
        }
    }

    /// −ln(1 − α) of one step; in the published form α has been rounded.
    fn thickness(&self, thickness: f64, rounding: &Rounding) -> f64 {
        if !self.published {
            return thickness;
        }
        let alpha = rounding.computed(1.0 - rounding.computed((-thickness).exp()));
        thickness_of_opacity(alpha, rounding)
    }
}

/// −ln(1 − α), the published form's thickness of a step of opacity α: infinite at α = 1, NaN above.
pub fn thickness_of_opacity(alpha: f64, rounding: &Rounding) -> f64 {
    -rounding.computed(rounding.computed(1.0 - rounding.computed(alpha)).ln())
}

/// Depth as the variable x of the series, 0…1 between `near` and `far`.
fn position(depth: f64, (near, far): (f64, f64)) -> f64 {
    let offset = depth - near;
    if offset <= 0.0 {
        0.0
    } else if offset >= far - near {
        1.0
    } else {
        offset / (far - near)
    }
}

impl Encoding for Fourier {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let interval = self.interval(column);
        let mut values = vec![0.0; 2 * self.order as usize + 1];
        let length_m = if self.metre { 1.0 } else { column.step_m };
        for (step, extinction_per_m) in column.extinction_per_m.iter().enumerate() {
            let thickness = extinction_per_m * length_m;
            if thickness <= 0.0 {
                continue;
            }
            let amount = 2.0 * self.thickness(thickness, rounding);
            let x = position(column.depth_at(step, column.fraction), interval);
            values[0] = rounding.computed(values[0] + amount);
            for k in 1..=self.order as usize {
                let (sin, cos) = (TAU * k as f64 * x).sin_cos();
                for (value, wave) in values[2 * k - 1..].iter_mut().zip([cos, sin]) {
                    *value = rounding.computed(*value + amount * rounding.computed(wave));
                }
            }
        }
        if !self.published && values[0] > LARGEST_COEFFICIENT {
            let scale = LARGEST_COEFFICIENT / values[0];
            values.iter_mut().for_each(|v| *v *= scale);
        }
        if self.bounded {
            values.extend([interval.0, interval.1]);
        }
        values
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let coefficients = 2 * self.order as usize + 1;
        let interval = match values[coefficients..] {
            [near, far] => (near, far),
            _ => (0.0, 1.0),
        };
        let x = position(look_up.depth, interval);
        let mut tau = 0.5 * values[0] * x;
        for k in 1..=self.order {
            let angle = TAU * f64::from(k) * x;
            let sine = if self.first_sine { 1 } else { k };
            let (a, b) = (values[2 * k as usize - 1], values[2 * sine as usize]);
            let wave = a * angle.sin() + b * (1.0 - angle.cos());
            tau = rounding.computed(tau + self.window(k) * wave / (TAU * f64::from(k)));
        }
        rounding.computed((-at_least_zero(tau)).exp())
    }
}
