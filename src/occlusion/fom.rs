//! Fourier opacity map: extinction along a column as a truncated Fourier series.

use super::param::{ParamKind, ParamSpec, Params};
use super::{FORM, LightOcclusion, MAP_PARAMS, MethodInfo, Plan};
use crate::error::Result;
use crate::gpu::Defs;

/// See the module.
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
    },
    ParamSpec {
        name: "window",
        unit: "",
        doc: "Weights of the harmonics against ringing: none, lanczos, or fejer (monotone, blurrier).",
        kind: ParamKind::Choice {
            options: &["none", "lanczos", "fejer"],
            default: "none",
        },
    },
    ParamSpec {
        name: "bounds",
        unit: "",
        doc: "Interval of the series: the longest column of the map, or each texel's own occupied part (2 values more).",
        kind: ParamKind::Choice {
            options: &["map", "texel"],
            default: "map",
        },
    },
    FORM,
];

impl LightOcclusion for Fom {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "fom",
            title: "Fourier opacity map",
            citation: "Jansen & Bavoil 2010, Fourier Opacity Mapping, eqs. 6–9; thesis M, Algorithms 7 and 8",
            shader: "occlusion/fom.wgsl",
            source: include_str!("../../shaders/occlusion/fom.wgsl"),
            params: &[MAP_PARAMS, PARAMS],
            monotone: false,
        }
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
            map_values: Some(values),
            defs,
        })
    }
}
