//! Reconstructions, which make pictures of the pixels that frames march, and their registry.
//!
//! A reconstruction declares which pixels each frame marches ([`crate::scene::Pattern`]) and implements the rest of the
//! frame: passes on a device ([`DeviceSequence`]) and the same in f64 ([`OracleSequence`]). The schema of experiments,
//! the measurements of a batch and the text of a report follow from its [`ReconstructionInfo`]. A new one is one Rust
//! file, its WGSL file in `shaders/reconstruct` where it has passes, and one line of [`REGISTRY`].

mod full;
mod reprojection;
mod temporal_2x2;
#[cfg(test)]
mod tests;

use crate::config::{Catalogue, MethodCatalogue};
use crate::cost::Counts;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::Gpu;
use crate::occlusion;
use crate::oracle::Occlusion;
use crate::param::ParamSpec;
use crate::progress::Progress;
use crate::raymarch::DeviceSequence;
use crate::scene::{ImageSize, ReconstructionInfo};
use schemars::{Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};
use std::rc::Rc;
use std::sync::LazyLock;

/// Every reconstruction, in the order of lists and menus.
pub const REGISTRY: &[&dyn Reconstruction] = &[&full::Full, &temporal_2x2::TEMPORAL_2X2];

/// A reconstruction: makes pictures of the pixels that frames march.
pub trait Reconstruction: Sync {
    /// Its description: id, pattern, history.
    fn info(&self) -> &'static ReconstructionInfo;

    /// A new sequence of frames on a device, without history.
    fn on_device(&self, gpu: &Gpu, image: ImageSize) -> Result<Rc<dyn DeviceSequence>>;

    /// A new sequence of frames in f64 on the CPU, without history.
    fn on_oracle(&self, image: ImageSize) -> Box<dyn OracleSequence>;
}

/// The f64 part of a reconstruction: a sequence of frames of one image size.
pub trait OracleSequence {
    /// Renders the next frame with a method in its view.
    fn render(&mut self, method: &Occlusion<'_>, progress: Progress) -> Result<Counts>;

    /// The picture of the last frame; `None` before the first.
    fn picture(&self) -> Option<Frame>;
}

/// The registered reconstruction `id`.
pub fn find(id: &str) -> Result<&'static dyn Reconstruction> {
    let found = REGISTRY.iter().find(|r| r.info().id == id).copied();
    found.ok_or_else(|| {
        let problem = format!("there is no reconstruction `{id}`");
        let remedy = format!("Choose one of: {}.", IDS.join(", "));
        Error::input("reconstruct", problem, remedy)
    })
}

/// Description of the reconstruction that marches every pixel.
pub fn full() -> &'static ReconstructionInfo {
    &full::INFO
}

static IDS: LazyLock<Vec<&str>> = LazyLock::new(|| infos().map(|info| info.id).collect());

fn infos() -> impl Iterator<Item = &'static ReconstructionInfo> {
    REGISTRY.iter().map(|r| r.info())
}

/// Deserialises the id of a registered reconstruction, for records.
pub fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<&'static ReconstructionInfo, D::Error> {
    let id = String::deserialize(deserializer)?;
    let found = infos().find(|info| info.id == id);
    found.ok_or_else(|| serde::de::Error::unknown_variant(&id, &IDS))
}

/// Schema of the id of a reconstruction.
pub fn schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": "string", "enum": *IDS})
}

/// The registries as the configuration's catalogue: methods and reconstructions.
pub struct Registry;

impl MethodCatalogue for Registry {
    fn ids(&self) -> Vec<&str> {
        occlusion::Methods.ids()
    }

    fn params(&self, id: &str) -> Option<Vec<&'static ParamSpec>> {
        occlusion::Methods.params(id)
    }
}

impl Catalogue for Registry {
    fn reconstructions(&self) -> Vec<&'static ReconstructionInfo> {
        infos().collect()
    }
}
