//! The ways to make a picture of what frames march, and their registry.
//!
//! A reconstruction says which pixels each frame marches ([`crate::scene::Pattern`]) and brings what happens after that:
//! passes on a device ([`DeviceSequence`]) and the same in f64 ([`OracleSequence`]). Everything else is told by its
//! [`ReconstructionInfo`]: the schema of experiments, what a batch measures, what a report says of it. A new one is one Rust
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

/// Every reconstruction, in the order they are listed to people.
pub const REGISTRY: &[&dyn Reconstruction] = &[&full::Full, &temporal_2x2::TEMPORAL_2X2];

/// A way to make pictures of what frames march.
pub trait Reconstruction: Sync {
    /// What it is, marches and remembers.
    fn info(&self) -> &'static ReconstructionInfo;

    /// A sequence of frames on a device that remembers nothing yet.
    fn on_device(&self, gpu: &Gpu, image: ImageSize) -> Result<Rc<dyn DeviceSequence>>;

    /// The same in f64 on the CPU.
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

/// What is known of the one that marches every pixel.
pub fn full() -> &'static ReconstructionInfo {
    &full::INFO
}

static IDS: LazyLock<Vec<&str>> = LazyLock::new(|| infos().map(|info| info.id).collect());

fn infos() -> impl Iterator<Item = &'static ReconstructionInfo> {
    REGISTRY.iter().map(|r| r.info())
}

/// Reads an id of the registry, for records.
pub fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<&'static ReconstructionInfo, D::Error> {
    let id = String::deserialize(deserializer)?;
    let found = infos().find(|info| info.id == id);
    found.ok_or_else(|| serde::de::Error::unknown_variant(&id, &IDS))
}

/// Schema of such an id.
pub fn schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": "string", "enum": *IDS})
}

/// Everything that experiments name by an id, as the configuration sees it: methods and reconstructions.
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
