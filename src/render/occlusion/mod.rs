//! The light-occlusion methods and their registry.
//!
//! A method gives the view march V(p) = exp(−τ between p and the sun). It is declared by a [`MethodInfo`] and a WGSL
//! file, and brings no GPU code of its own:
//!
//! - without a map, the file exports `fn light_transmittance(p: vec3f, rnd: f32) -> f32`;
//! - with a map, it exports `fn encode(column: Column)` (stores the texel of a column) and
//!   `fn transmittance(tap: Tap, depth: f32) -> f32` (V at a depth, from a texel); the map's geometry, look-up rule and
//!   fallback are shared. The layout of the map, a 2-D array of floats by default, and the passes before and after the
//!   column pass are in its [`Plan`]: see [`plan`].
//!
//! Numeric parameters are members of the file's `Params` uniform (or of the shared `Map`), choices are shader
//! definitions `NAME_OPTION`. The Rust file also holds the method's f64 [`Twin`], written from the equations, which the
//! oracle runs. A new method is one Rust file, one WGSL file, and here its `mod` and its line of [`REGISTRY`]: lists,
//! tables, colours, menus and tests are generated from its [`MethodInfo`].

mod info;
mod map_params;
pub mod plan;
pub mod rounding;
pub mod spans;
pub mod twin;

mod alq;
mod avsm;
mod bsm;
mod dom;
mod esm;
mod floor;
mod fom;
mod msm;
mod none;
mod odv;
mod srm;
#[cfg(test)]
mod tests;
mod tfm;
mod truth;

pub use alq::shares as quantile_shares;
pub use fom::thickness_of_opacity;
pub use info::{Marker, MethodInfo, Role, Trial, Trials, trial};
use map_params::{FORM, FRONT, map_rows};
pub use map_params::{GEOMETRY, LOOKUP, READ_BY_RENDERER, STORAGE, TEXEL_LOOKUP, TEXELS};
pub use plan::Plan;

use crate::error::{Error, Result};
use crate::param::{ParamSpec, ParamValue, Params};
use crate::scene::{MapCoverage, MapFit, Scene};
use crate::shader_defs::Defs;
use twin::Twin;

/// Every method, in the order of menus and charts.
pub const REGISTRY: &[&dyn LightOcclusion] = &[
    &srm::Srm,
    &esm::Esm,
    &bsm::Bsm,
    &fom::Fom,
    &alq::Alq,
    &odv::Odv,
    &avsm::Avsm,
    &dom::Dom,
    &tfm::Tfm,
    &msm::Msm,
    &floor::Floor,
    &none::None,
    &truth::Truth,
];

/// A light-occlusion method.
pub trait LightOcclusion: Sync {
    /// The method's description.
    fn info(&self) -> &'static MethodInfo;

    /// Map, resources and passes that it needs at `params`; the default is a method without a map.
    fn plan(&self, _params: &Params) -> Result<Plan> {
        Ok(Plan::default())
    }

    /// Names of a texel's values at `params`, in storage order; empty without a map.
    fn value_names(&self, _params: &Params) -> Result<Vec<String>> {
        Ok(Vec::new())
    }

    /// The f64 twin at `params`.
    fn oracle(&self, params: &Params) -> Result<Twin>;

    /// Upper bound of the loop iterations of one `light_transmittance`, when no ray is longer than `longest_path_m`.
    /// The default covers look-ups with their fallback march.
    fn light_turns(&self, _params: &Params, _longest_path_m: f64) -> Result<f64> {
        Ok(64.0)
    }

    /// Relative RMSE of V in a homogeneous medium of optical depth up to 5 at the settings that its trials call exact:
    /// 0 where e^(−σd) is among the functions that it can store.
    fn homogeneous_error(&self) -> f64 {
        0.0
    }

    /// Largest rise of T along a column that the method documents, where what it stores is a series of T itself; `None`
    /// where rises are bounded by the column's optical depth.
    fn largest_rise(&self) -> Option<f64> {
        None
    }
}

/// A method with a complete set of parameters, including those that do not apply: uniforms hold them all.
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

/// The registered method of a role.
pub fn playing(role: Role) -> Result<&'static dyn LightOcclusion> {
    let found = REGISTRY.iter().find(|m| m.info().role == role).copied();
    found.ok_or_else(|| Error::defect("registry", format!("no method has the role {role:?}")))
}

/// Whether `id` is that of the truth.
pub fn is_truth(id: &str) -> bool {
    find(id).is_ok_and(|method| method.info().is_truth())
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
        find(id).map(Self::new)
    }

    /// A method at its defaults, registered or not.
    pub fn new(method: &'static dyn LightOcclusion) -> Self {
        let params = Params::defaults(method.info().specs());
        Self { method, params }
    }

    /// The floor at this method's steps, resolution, storage and look-up: the same map without compression.
    pub fn uncompressed(&self) -> Result<Self> {
        let mut floor = Self::new(playing(Role::Floor)?);
        for spec in floor.method.info().specs() {
            if let Some(value) = self.params.get(spec.name) {
                floor.params.set(spec.name, value);
            }
        }
        Ok(floor)
    }

    /// A method at recorded or listed values; other parameters have their defaults.
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

    /// The truth of `scene`, with the light step for its container.
    pub fn truth(scene: &Scene) -> Result<Self> {
        let step_m = scene.truth_step_m();
        let setup = Self::new(playing(Role::Truth)?).with("step_m", &step_m.to_string());
        setup.map_err(|_| {
            let place = format!("scene `{}`, at /container/box", scene.name);
            let problem =
                format!("its truth would march in steps of {step_m} m, the shortest is 1e-9 m");
            Error::input(place, problem, "Choose a larger box.")
        })
    }

    /// This setting with one parameter changed, from text as on the command line.
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

    /// How the rectangle of its map is laid.
    pub fn map_fit(&self) -> Result<MapFit> {
        Ok(match self.params.choice("fit")? {
            "axes" => MapFit::Axes,
            "warped" => MapFit::Warped(self.params.number("warp_exponent")?),
            _ => MapFit::Square,
        })
    }

    /// Extent of its map and distribution of the texels over it.
    pub fn map_coverage(&self) -> Result<MapCoverage> {
        Ok(MapCoverage {
            fit: self.map_fit()?,
            cascades: self.params.int("cascades")?,
            ratio: self.params.number("cascade_ratio")?,
        })
    }

    /// Rows of texels of its map: those of all cascades.
    pub fn map_rows(&self) -> Result<u32> {
        map_rows(&self.params)
    }

    /// Frames over which its map is filled; 1 without a map.
    pub fn fill_frames(&self) -> u32 {
        self.params.int("fill_frames").unwrap_or(1)
    }

    /// Note for a user who set a parameter that has no effect at this setting; `None` where it has one.
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
        if self.params.int("near_steps").is_ok_and(|steps| steps > 0) {
            defs.insert("NEAR_MARCH".to_owned(), None);
        }
        let cascades = self.params.int("cascades").unwrap_or(1);
        if cascades > 1 {
            defs.insert("CASCADES".to_owned(), Some(cascades.cast_signed()));
        }
        let frames = self.fill_frames();
        if frames > 1 {
            defs.insert("FILL_FRAMES".to_owned(), Some(frames.cast_signed()));
        }
        defs
    }
}

/// The registry as the configuration's catalogue of methods.
pub struct Methods;

impl crate::config::MethodCatalogue for Methods {
    fn ids(&self) -> Vec<&str> {
        ids().collect()
    }

    fn params(&self, id: &str) -> Option<Vec<&'static ParamSpec>> {
        find(id).ok().map(|m| m.info().specs().collect())
    }
}
