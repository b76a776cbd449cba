//! Exponential shadow map: the front of each light column, one value a texel.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::plan::{MapResource, MapResourceKind, MethodPass, StorableFormat};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, Front, LookUp, Twin, at_least_zero};
use super::{FORM, FRONT, GEOMETRY, LightOcclusion, Plan, TEXELS, map_rows};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};

/// Exponential shadow map.
pub struct Esm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "c",
        unit: "",
        doc: "Sharpness: extinction behind the front is c over the longest column. The published form overflows f16 from c·z = 11.09.",
        kind: ParamKind::Float {
            min: 1e-3,
            max: 1e5,
            default: 11.0,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "blur_texels",
        unit: "texels",
        doc: "Radius r of a blur of the exponentials, the mean of (2r + 1)² texels, before look-ups (Annen et al. 2008); 0 = none.",
        kind: ParamKind::Int {
            min: 0,
            max: 64,
            default: 0,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    FORM,
    FRONT,
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "c=12.1"),
        trial("storage=f32", "c=12.1 storage=f32"),
        trial("lookup=nearest", "lookup=blend"),
        trial("lookup=hardware", "lookup=blend"),
        trial("form=published c=8", "form=published c=8.8"),
        trial(
            "form=published c=80 storage=f32",
            "form=published c=88 storage=f32",
        ),
        trial("blur_texels=3", "blur_texels=2"),
        trial(
            "form=published c=8 blur_texels=3",
            "form=published c=8 blur_texels=2",
        ),
    ],
    clouds: &[trial("", "c=12.1")],
    texels: &[
        trial("", "front=first"),
        trial("blur_texels=2", "blur_texels=1"),
        trial("blur_texels=2 c=500", "blur_texels=1 c=500"),
        trial(
            "form=published c=8 blur_texels=3",
            "form=published c=8 blur_texels=2",
        ),
        trial("form=published c=8", "form=published c=8.1"),
    ],
    // With the other front, the threshold leaves out τ = 0.01.
    exact: &["front=first c={tau}"],
};

impl LightOcclusion for Esm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "esm",
            title: "Exponential shadow map",
            summary: "exponential shadow map",
            texel: "1",
            expect: "Behind the front the extinction is c over the longest column, whatever the cloud: light leaks deep into dense cloud, most at a low sun, where columns are long. A blur (`blur_texels`) leaks more still at the edges of clouds, where columns without a front outweigh their neighbours. The published form stores values that are not finite, in f16 from c·z = 11.09.",
            citation: "Annen et al. 2008, Exponential Shadow Maps, eq. 3; thesis M, Algorithms 3 and 4",
            role: Role::Practical,
            colour: 0x1b9b80,
            marker: Marker::Square,
            shader: "occlusion/esm.wgsl",
            source: include_str!("../../../shaders/occlusion/esm.wgsl"),
            params: &[GEOMETRY, TEXELS, PARAMS],
            monotone: true,
            bounded: false,
            tolerance: 2e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Exponential {
            c: params.number("c")?,
            front: Front::new(params)?,
            blur_texels: params.int("blur_texels")?,
            published: params.choice("form")? == "published",
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let name = match params.choice("form")? {
            "published" => "exp(c z)",
            _ => "front z",
        };
        Ok(vec![name.to_owned()])
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let mut plan = Plan::array(1);
        let radius = params.int("blur_texels")?;
        if radius > 0
            && let Some(map) = &mut plan.map
        {
            plan.defs.insert("BLUR".into(), None);
            let (edge, rows) = (params.int("resolution")?, map_rows(params)?);
            map.resources.push(MapResource {
                read: "rows",
                write: "rows_store",
                kind: MapResourceKind::Array {
                    size: [edge, rows, 1],
                    levels: 1,
                    format: StorableFormat::R32Float,
                },
                temporary: true,
            });
            map.after = ["blur_rows", "blur_columns"]
                .map(|entry| MethodPass {
                    entry,
                    threads: [edge, rows],
                    levels: Vec::new(),
                })
                .into();
        }
        Ok(plan)
    }
}

/// V = exp(−c (d − z)), from z or from exp(c z).
struct Exponential {
    c: f64,
    front: Front,
    /// Radius of the blur, texels.
    blur_texels: u32,
    published: bool,
}

impl Encoding for Exponential {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let z = column.front(self.front).unwrap_or(1.0);
        if self.published {
            vec![rounding.computed(rounding.computed(self.c * z).exp())]
        } else {
            vec![z]
        }
    }

    fn mixed_texels(&self) -> u32 {
        self.blur_texels
    }

    /// f is what is averaged: ln(mean exp(c z))/c where z is stored.
    fn mix(&self, square: &[&[f64]]) -> Vec<f64> {
        let stored = || square.iter().map(|values| values[0]);
        let texels = square.len() as f64;
        if self.published {
            return vec![stored().sum::<f64>() / texels];
        }
        let most = stored().fold(f64::NEG_INFINITY, f64::max);
        let mean = stored().map(|z| (self.c * (z - most)).exp()).sum::<f64>() / texels;
        vec![most + mean.ln() / self.c]
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        if self.published {
            let decay = rounding.computed((-rounding.computed(self.c * look_up.depth)).exp());
            return rounding.computed(values[0] * decay).clamp(0.0, 1.0);
        }
        let behind = at_least_zero(look_up.depth - values[0]);
        rounding.computed((-rounding.computed(self.c * behind)).exp())
    }
}
