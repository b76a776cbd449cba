//! The density field: dimensionless density in `[0, ∞)` at a point, on the device and in f64.
//!
//! A kind of field is one Rust file (or folder), one WGSL file and one entry of the registry at the end of this file:
//!
//! - the Rust file holds its parameters as a struct, which a scene gives under `"density": {"<name>": {…}}`; JSON,
//!   schema and located errors follow from the struct. Its [`DensityField`] holds the rest: checks of the values, the
//!   field on the device, its f64 twin, the file it reads, its seed, the numbers that the window can change, and
//!   examples, with which the tests compare device and twin;
//! - `shaders/density/<name>.wgsl` exports `fn density(p: vec3f) -> f32` (p in world metres, inside the container) and
//!   `fn empty_distance(p: vec3f) -> f32` (a distance around p within which density is provably 0, −1 where it may not
//!   be: `grid_distance` of an [`Occupancy`](occupancy::Occupancy), or a constant).
//!
//! A twin is written from the equations and shares no code with the shader. It may share the bounds of empty space with
//! the CPU part of the device path.

mod field;
pub mod lattice;
pub mod occupancy;
mod procedural;
mod texture;
mod uniform;
pub mod volume;

pub use field::{
    Built, Control, ControlValue, DensityField, DensityKind, DensityTwin, DeviceField, Surroundings,
};
pub use procedural::{Deck, Detail};
pub use texture::Filter;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Makes the type of a scene's `density` and the list of kinds from entries `"name in JSON" => module::Type`, each with the
/// text that the schema shows.
macro_rules! densities {
    ($($(#[doc = $doc:literal])+ $name:literal => $module:ident::$kind:ident,)+) => {
        $(pub use $module::$kind;)+

        /// Where the dimensionless density in `[0, ∞)` comes from; extinction = density × `medium.extinction_per_m`.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub enum Density {
            $($(#[doc = $doc])+ #[serde(rename = $name)] $kind($kind),)+
        }

        impl Density {
            /// Every kind, in the order of the schema.
            pub const KINDS: &[DensityKind] = &[$(DensityKind {
                name: $name,
                examples: |container, folder| {
                    let examples = <$kind as DensityField>::examples(container, folder)?;
                    Ok(examples.into_iter().map(Density::$kind).collect())
                },
            },)+];

            /// Name of its kind in JSON.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => $name,)+
                }
            }

            /// The functions of its kind.
            pub fn field(&self) -> &dyn DensityField {
                match self {
                    $(Self::$kind(field) => field,)+
                }
            }

            /// [`Density::field`], mutable.
            pub fn field_mut(&mut self) -> &mut dyn DensityField {
                match self {
                    $(Self::$kind(field) => field,)+
                }
            }
        }
    };
}

densities! {
    /// The same value everywhere in the container; for analytic checks.
    "uniform" => uniform::Uniform,
    /// Weather map, Perlin–Worley shape and Worley erosion (Schneider & Vos 2015/2017, Hillaire 2016).
    "procedural" => procedural::Procedural,
    /// A NumPy array that fills a box container, samples at cell centres, clamped trilinear interpolation.
    "volume" => volume::Volume,
}
