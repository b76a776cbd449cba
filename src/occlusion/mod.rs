//! The light-occlusion strategies and their registry.
//!
//! A strategy answers one question for the view march: V(p) = exp(−τ between p and the sun). It is declared by a
//! [`MethodInfo`] and a WGSL file, and brings no GPU code of its own:
//!
//! - without a map, the file exports `fn light_transmittance(p: vec3f, rnd: f32) -> f32`;
//! - with a map, it exports `fn encode(column: Column)` (what a texel keeps of its column) and
//!   `fn transmittance(tap: Tap, depth: f32) -> f32` (what a texel says of a depth); the map's geometry, look-up rule and
//!   fallback are shared.
//!
//! Numeric parameters are members of the file's `Params` uniform (or of the shared `Map`), choices are shader
//! definitions `NAME_OPTION`. The Rust file also holds the method's f64 [`Twin`], written from the equations: what the
//! oracle runs. A new method is one Rust file, one WGSL file and one line of [`REGISTRY`].

pub mod param;
pub mod rounding;
pub mod twin;

mod bsm;
mod esm;
mod floor;
mod fom;
mod none;
mod srm;
#[cfg(test)]
mod tests;
mod truth;

pub use fom::thickness_of_opacity;

use crate::error::{Error, Result};
use crate::gpu::Defs;
use crate::scene::Scene;
use param::{Applies, ParamKind, ParamSpec, ParamValue, Params};
use twin::Twin;

/// Every strategy, in the order of menus and charts.
pub const REGISTRY: &[&dyn LightOcclusion] = &[
    &srm::Srm,
    &esm::Esm,
    &bsm::Bsm,
    &fom::Fom,
    &floor::Floor,
    &none::None,
    &truth::Truth,
];

/// What a method is.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// Short name in JSON, on the command line and in reports.
    pub id: &'static str,
    /// Full name.
    pub title: &'static str,
    /// Paper, year, equation.
    pub citation: &'static str,
    /// Path of its WGSL file below `shaders/`.
    pub shader: &'static str,
    /// Text of that file.
    pub source: &'static str,
    /// Parameter lists; together they are the method's parameters.
    pub params: &'static [&'static [ParamSpec]],
    /// V never increases with depth along a light column (with look-up `nearest` and form `stable`).
    pub monotone: bool,
    /// Largest relative RMSE between a picture's sunlight on a device and by the oracle, at the same parameters, with
    /// storage rounding emulated and nothing filtered by hardware. What it is made of: `tests/oracle_gpu.rs`.
    pub tolerance: f64,
}

/// What a method needs at given parameters.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Values a map texel holds; `None` = no map.
    pub map_values: Option<u32>,
    /// Definitions beside those of the choices, for structure that depends on a number.
    pub defs: Defs,
}

/// A strategy.
pub trait LightOcclusion: Sync {
    /// Its description.
    fn info(&self) -> &'static MethodInfo;

    /// Map size and structure at `params`; the default is a method without a map.
    fn plan(&self, _params: &Params) -> Result<Plan> {
        Ok(Plan::default())
    }

    /// Its f64 twin at `params`.
    fn oracle(&self, params: &Params) -> Result<Twin>;

    /// Most loop turns that one `light_transmittance` takes, when no ray is longer than `longest_path_m`. The default
    /// covers look-ups with their fallback march.
    fn light_turns(&self, _params: &Params, _longest_path_m: f64) -> Result<f64> {
        Ok(64.0)
    }
}

/// Parameters every map shares.
pub const MAP_PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "resolution",
        unit: "texels",
        doc: "Edge of the square map.",
        kind: ParamKind::Int {
            min: 1,
            max: 65536,
            default: 512,
        },
        applies: Applies::Always,
    },
    ParamSpec {
        name: "steps",
        unit: "",
        doc: "Samples a map column takes over its own length inside the layer.",
        kind: ParamKind::Int {
            min: 1,
            max: 1000,
            default: 100,
        },
        applies: Applies::Always,
    },
    ParamSpec {
        name: "storage",
        unit: "",
        doc: "Bits of a stored value: half or single precision.",
        kind: ParamKind::Choice {
            options: &["f16", "f32"],
            default: "f16",
        },
        applies: Applies::Always,
    },
    ParamSpec {
        name: "lookup",
        unit: "",
        doc: "nearest: one texel; hardware: stored values interpolated by the sampler; blend: T of four texels, interpolated.",
        kind: ParamKind::Choice {
            options: &["nearest", "hardware", "blend"],
            default: "blend",
        },
        applies: Applies::Always,
    },
    ParamSpec {
        name: "sampling",
        unit: "",
        doc: "Where a step is sampled: its midpoint, or its far end as in thesis M. quadratic reproduces a misprint (thesis M, Algorithm 7): step k of n is sampled at k(k+1)/(n(n−1)) of the column but counts at k/n.",
        kind: ParamKind::Choice {
            options: &["midpoint", "end", "quadratic"],
            default: "midpoint",
        },
        applies: Applies::Always,
    },
];

const FRONT: ParamSpec = ParamSpec {
    name: "front",
    unit: "",
    doc: "Where a column's cloud begins: threshold = T first falls below 0.99 (thesis M), first = near edge of the first occupied step.",
    kind: ParamKind::Choice {
        options: &["threshold", "first"],
        default: "threshold",
    },
    applies: Applies::Always,
};

const FORM: ParamSpec = ParamSpec {
    name: "form",
    unit: "",
    doc: "stable = cannot overflow; published = the formula as printed, kept to show where it fails.",
    kind: ParamKind::Choice {
        options: &["stable", "published"],
        default: "stable",
    },
    applies: Applies::Always,
};

/// A method with a complete set of parameters, those that do not apply included: uniforms hold them all.
#[derive(Clone)]
pub struct MethodSetup {
    /// The strategy.
    pub method: &'static dyn LightOcclusion,
    /// A value for each of its parameters.
    pub params: Params,
}

impl PartialEq for MethodSetup {
    fn eq(&self, other: &Self) -> bool {
        self.method.info().id == other.method.info().id && self.applying() == other.applying()
    }
}

impl std::fmt::Debug for MethodSetup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {:?}", self.method.info().id, self.params)
    }
}

impl MethodInfo {
    /// All parameters.
    pub fn specs(&self) -> impl Iterator<Item = &'static ParamSpec> {
        self.params.iter().copied().flatten()
    }
}

/// The registered method `id`; the error lists what exists.
pub fn find(id: &str) -> Result<&'static dyn LightOcclusion> {
    let found = REGISTRY.iter().find(|m| m.info().id == id).copied();
    found.ok_or_else(|| {
        let problem = format!("there is no method `{id}`");
        Error::input("--method", problem, one_of(ids()))
    })
}

/// Ids of the registry, in its order.
fn ids() -> impl Iterator<Item = &'static str> {
    REGISTRY.iter().map(|m| m.info().id)
}

fn one_of<'a>(names: impl Iterator<Item = &'a str>) -> String {
    match names.collect::<Vec<_>>().join(", ") {
        none if none.is_empty() => "It has none.".to_owned(),
        names => format!("Choose one of: {names}."),
    }
}

impl MethodSetup {
    /// The method at its defaults.
    pub fn defaults(id: &str) -> Result<Self> {
        let method = find(id)?;
        Ok(Self {
            method,
            params: Params::defaults(method.info().specs()),
        })
    }

    /// A method at recorded or listed values; all others have their defaults.
    pub fn of(id: &str, params: &Params) -> Result<Self> {
        let Self {
            method,
            params: defaults,
        } = Self::defaults(id)?;
        let params = defaults.with(params);
        Ok(Self { method, params })
    }

    /// The values of the parameters that apply.
    pub fn applying(&self) -> Params {
        self.params.applying(self.method.info().specs())
    }

    /// The truth of `scene`, with the light step that its shape asks for.
    pub fn truth(scene: &Scene) -> Result<Self> {
        let step_m = scene.truth_step_m();
        let setup = Self::defaults("truth")?.with("step_m", &step_m.to_string());
        setup.map_err(|_| {
            let place = format!("scene `{}`, at /container/box", scene.name);
            let problem =
                format!("its truth would march in steps of {step_m} m, the shortest is 1e-9 m");
            Error::input(place, problem, "Choose a larger box.")
        })
    }

    /// The same with one parameter changed, from text as on the command line.
    pub fn with(mut self, name: &str, text: &str) -> Result<Self> {
        let info = self.method.info();
        let place = || format!("--set {name}={text}");
        let Some(spec) = info.specs().find(|s| s.name == name) else {
            let problem = format!("`{}` has no parameter `{name}`", info.id);
            let remedy = one_of(info.specs().map(|s| s.name));
            return Err(Error::input(place(), problem, remedy));
        };
        let value = spec.parse_text(text).map_err(|problem| {
            Error::input(place(), problem, "`occlab methods` lists what is allowed.")
        })?;
        self.params.set(spec.name, value);
        Ok(self)
    }

    /// What to tell somebody who named a parameter that has no effect at this setting.
    pub fn idle_note(&self, name: &str) -> Option<String> {
        let mut specs = self.method.info().specs();
        let spec = specs.find(|s| s.name == name && !s.applies_at(&self.params))?;
        let condition = spec.applies.words()?;
        Some(format!(
            "`{name}` has no effect: it applies where {condition}"
        ))
    }

    /// Shader definitions of the choices and of the plan.
    pub fn defs(&self, plan: &Plan) -> Defs {
        let mut defs = plan.defs.clone();
        for (name, value) in self.params.iter() {
            if let ParamValue::Choice(option) = value {
                defs.insert(format!("{name}_{option}").to_uppercase(), None);
            }
        }
        defs
    }
}

/// The registry as the configuration sees it.
pub struct Registry;

impl crate::config::MethodCatalogue for Registry {
    fn ids(&self) -> Vec<&str> {
        ids().collect()
    }

    fn params(&self, id: &str) -> Option<Vec<&'static ParamSpec>> {
        find(id).ok().map(|m| m.info().specs().collect())
    }
}
