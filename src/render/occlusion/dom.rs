//! Deep opacity map: the front of each light column, and its optical depth at the ends of a few layers behind it.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, Front, LookUp, Twin, at_least_zero, smaller};
use super::{FRONT, GEOMETRY, LightOcclusion, Plan, TEXELS};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};
use crate::shader_defs::Defs;

/// Deep opacity map.
pub struct Dom;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "layers",
        unit: "",
        doc: "Layers n behind the front, layer i being i times as thick as the first (Yuksel & Keyser 2008); a texel holds 1 + n values.",
        kind: ParamKind::Int {
            min: 1,
            max: 15,
            default: 3,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "layer_m",
        unit: "m",
        doc: "Metres that the layers cover behind the front, at most to the end of the texel's own column; V stays behind them.",
        kind: ParamKind::Float {
            min: 1e-3,
            max: 1e6,
            default: 1500.0,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    FRONT,
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "layers=4"),
        trial("layer_m=200", "layer_m=220"),
        trial("storage=f32", "layers=4 storage=f32"),
        trial("layers=6 front=first", "layers=6"),
        trial("layers=4 lookup=hardware", "layers=4"),
        trial("layers=1 sampling=end", "layers=1"),
    ],
    clouds: &[
        trial("", "layers=4"),
        trial("placement=occupied", "placement=occupied layers=5"),
    ],
    texels: &[
        trial("", "sampling=end"),
        trial("layers=6 layer_m=200", "layers=6 layer_m=210"),
        trial("front=first layers=4", "layers=4"),
    ],
    // With the other front, the threshold leaves out τ = 0.01.
    exact: &[
        "front=first layer_m=1e6",
        "front=first layer_m=1e6 layers=6",
        "front=first layer_m=1e6 layers=1",
    ],
};

impl LightOcclusion for Dom {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "dom",
            title: "Deep opacity map",
            summary: "deep opacity map: front, and optical depth after each of n layers behind it",
            texel: "1 + n",
            expect: "Cloud farther behind the front than the layers reach casts no shadow of its own, and within a thick layer light fades evenly through cloud and gap alike: light leaks into a second deck. Hardware look-ups mix the fronts of neighbours.",
            citation: "Yuksel & Keyser 2008, Deep Opacity Maps",
            role: Role::Practical,
            colour: 0x8a7fe0,
            marker: Marker::Diamond,
            shader: "occlusion/dom.wgsl",
            source: include_str!("../../../shaders/occlusion/dom.wgsl"),
            params: &[GEOMETRY, TEXELS, PARAMS],
            monotone: true,
            bounded: true,
            tolerance: 1e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Layers {
            number: params.int("layers")?,
            all_m: params.number("layer_m")?,
            front: Front::new(params)?,
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let layers = 1..=params.int("layers")?;
        let ends = layers.map(|i| format!("τ after layer {i}"));
        Ok(["front z".to_owned()].into_iter().chain(ends).collect())
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let layers = params.int("layers")?;
        let texture_layers = (1 + layers).div_ceil(4);
        let number = |v: u32| Some(v.cast_signed());
        let defs = Defs::from([
            ("LAYERS".into(), number(layers)),
            ("TEXTURE_LAYERS".into(), number(texture_layers)),
            ("PADDED".into(), number(4 * texture_layers)),
        ]);
        Ok(Plan {
            defs,
            ..Plan::array(1 + layers)
        })
    }
}

/// Largest stored optical depth: f16 ends at 65504, and interpolation between two infinite values gives NaN.
const LARGEST_TAU: f64 = 6e4;

/// τ linear between the ends z + s·i(i + 1)/2 of the layers, level behind the last.
struct Layers {
    number: u32,
    /// What the layers cover at most, metres.
    all_m: f64,
    front: Front,
}

/// i(i + 1)/2: ends of the layers in units of the first.
fn end(i: u32) -> f64 {
    f64::from(i * (i + 1)) / 2.0
}

impl Layers {
    /// Thickness of the first layer over L_max, behind a front at `z` in a column of that `length`.
    fn first(&self, z: f64, length: f64, depth_m: f64) -> f64 {
        smaller(self.all_m / depth_m, at_least_zero(length - z)) / end(self.number)
    }
}

impl Encoding for Layers {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let Some(z) = column.front(self.front) else {
            let empty = (0..=self.number).map(|i| if i == 0 { 1.0 } else { 0.0 });
            return empty.collect();
        };
        let first = self.first(z, column.length_m / column.depth_m, column.depth_m);
        let after = (1..=self.number).map(|i| {
            let end_m = (z + first * end(i)) * column.depth_m;
            let tau = rounding.computed(column.optical_depth_before(end_m));
            smaller(tau, LARGEST_TAU)
        });
        [z].into_iter().chain(after).collect()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let (z, after) = (values[0], &values[1..]);
        let first = self.first(z, look_up.length, look_up.depth_m);
        let behind = look_up.depth - z;
        // The layer that the depth is in: the first that ends behind it.
        let inside = (1..=self.number).find(|i| behind < first * end(*i));
        let tau = match inside {
            _ if behind <= 0.0 => 0.0,
            None => after[after.len() - 1],
            Some(i) => {
                let near = if i == 1 { 0.0 } else { after[i as usize - 2] };
                let share = (behind - first * end(i - 1)) / (first * f64::from(i));
                near + (after[i as usize - 1] - near) * share
            }
        };
        rounding.computed((-rounding.computed(tau)).exp())
    }
}
