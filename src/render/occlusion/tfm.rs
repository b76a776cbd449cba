//! Transmittance function map: transmittance along a light column as a truncated cosine series.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin, at_least_zero, smaller};
use super::{GEOMETRY, LightOcclusion, Plan, TEXELS};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};
use crate::shader_defs::Defs;
use std::f64::consts::PI;

/// Transmittance function map.
pub struct Tfm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "coefficients",
        unit: "",
        doc: "Cosine coefficients n of T; a texel holds as many values, with its own bounds two more.",
        kind: ParamKind::Int {
            min: 2,
            max: 8,
            default: 6,
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
            default: "texel",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "coefficients=5"),
        trial("storage=f32", "coefficients=7 storage=f32"),
        trial("bounds=map", "coefficients=7 bounds=map"),
        trial(
            "bounds=map coefficients=2 lookup=nearest",
            "bounds=map coefficients=2",
        ),
        trial(
            "coefficients=8 lookup=hardware bounds=map",
            "coefficients=6 lookup=hardware bounds=map",
        ),
        trial("coefficients=4 sampling=end", "coefficients=4"),
        trial(
            "coefficients=3 placement=occupied",
            "coefficients=4 placement=occupied",
        ),
    ],
    clouds: &[trial("bounds=map", "")],
    texels: &[
        trial("", "sampling=end"),
        trial("bounds=map fit=warped", "bounds=map fit=axes"),
        trial("bounds=map", "bounds=map sampling=end"),
    ],
    exact: &["coefficients=8"],
};

impl LightOcclusion for Tfm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "tfm",
            title: "Transmittance function map",
            summary: "transmittance function map of n cosine coefficients",
            texel: "n + 2",
            expect: "T itself is the series, so its error is as large in deep shadow as in light: dense cloud has stripes of light inside. With `bounds=map` a few terms stand for the longest column of all, tens of kilometres at a low sun, and clouds lose their shadows.",
            citation: "Delalandre et al. 2011, Transmittance Function Mapping",
            role: Role::Practical,
            colour: 0xe0559a,
            marker: Marker::Down,
            shader: "occlusion/tfm.wgsl",
            source: include_str!("../../../shaders/occlusion/tfm.wgsl"),
            params: &[GEOMETRY, TEXELS, PARAMS],
            monotone: false,
            bounded: false,
            tolerance: 3e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(CosineSeries {
            coefficients: params.int("coefficients")?,
            own_bounds: params.choice("bounds")? == "texel",
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let mut names = vec!["1 − c0".to_owned()];
        names.extend((1..params.int("coefficients")?).map(|j| format!("2 c{j}")));
        if params.choice("bounds")? == "texel" {
            names.extend(["near bound", "far bound"].map(str::to_owned));
        }
        Ok(names)
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let coefficients = params.int("coefficients")?;
        let bounds = match params.choice("bounds")? {
            "texel" => 2,
            _ => 0,
        };
        let values = coefficients + bounds;
        let layers = values.div_ceil(4);
        let number = |v: u32| Some(v.cast_signed());
        let defs = Defs::from([
            ("COEFFICIENTS".into(), number(coefficients)),
            ("LAYERS".into(), number(layers)),
            ("PADDED".into(), number(4 * layers)),
        ]);
        Ok(Plan {
            defs,
            ..Plan::array(values)
        })
    }

    /// The series of e^(−τx) breaks off after eight terms; measured 0.034.
    /// A cosine series overshoots a jump by 9 % of it, however many terms it has (Gibbs); the jumps of a column add up.
    fn largest_rise(&self) -> Option<f64> {
        Some(0.2)
    }

    fn homogeneous_error(&self) -> f64 {
        0.04
    }
}

/// T(x) = c₀ + 2 Σ c_j cos jπx, c_j = ∫ T cos jπx dx.
struct CosineSeries {
    coefficients: u32,
    own_bounds: bool,
}

impl CosineSeries {
    /// Near and far edge of the interval that a column's series covers, over L_max.
    fn interval(&self, column: &Column) -> [f64; 2] {
        if self.own_bounds {
            column.occupied_interval()
        } else {
            [0.0, 1.0]
        }
    }

    /// ∫ T cos jπx dx, T falling by a step at each sample: level `t` from one sample to the next.
    fn projected(&self, falls: &[(f64, f64)], j: u32) -> f64 {
        let frequency = PI * f64::from(j);
        let antiderivative = |x: f64| match j {
            0 => x,
            _ => (frequency * x).sin() / frequency,
        };
        let (mut t, mut from, mut sum) = (1.0, 0.0, 0.0);
        for (x, thickness) in falls {
            sum += t * (antiderivative(*x) - antiderivative(from));
            t *= (-thickness).exp();
            from = *x;
        }
        sum + t * (antiderivative(1.0) - antiderivative(from))
    }
}

/// Depth as the variable x of the series, 0…1 between `near` and `far`.
fn position(depth: f64, [near, far]: [f64; 2]) -> f64 {
    let offset = at_least_zero(depth - near);
    if offset >= far - near {
        1.0
    } else {
        offset / (far - near)
    }
}

impl Encoding for CosineSeries {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let interval = self.interval(column);
        let falls: Vec<(f64, f64)> = column
            .thicknesses()
            .enumerate()
            .filter(|(_, thickness)| *thickness > 0.0 || thickness.is_nan())
            .map(|(k, thickness)| {
                let depth = column.depth_at(k, column.fraction);
                (position(depth, interval), thickness)
            })
            .collect();
        let coefficient = |j: u32| match j {
            0 => 1.0 - self.projected(&falls, 0),
            _ => 2.0 * self.projected(&falls, j),
        };
        let coefficients = (0..self.coefficients).map(coefficient);
        let mut values: Vec<f64> = coefficients.map(|c| rounding.computed(c)).collect();
        if self.own_bounds {
            values.extend(interval);
        }
        values
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let (coefficients, bounds) = values.split_at(self.coefficients as usize);
        let interval = match bounds {
            [near, _] if look_up.depth <= *near => return 1.0,
            [near, far] => [*near, *far],
            _ => [0.0, 1.0],
        };
        let x = position(look_up.depth, interval);
        let waves = coefficients.iter().enumerate().skip(1);
        let waves = waves.map(|(j, c)| c * (PI * j as f64 * x).cos());
        let sum = 1.0 - coefficients[0] + waves.sum::<f64>();
        at_least_zero(smaller(rounding.computed(sum), 1.0))
    }
}
