//! Interfaces of a kind of density field: its parameters, its device form and its f64 twin.

use super::Density;
use super::occupancy::Occupancy;
use super::texture::Filter;
use crate::container::Container;
use crate::error::Result;
use crate::gpu::{Gpu, Inputs};
use crate::problem::Problem;
use crate::shader_defs::Defs;
use glam::DVec3;
use std::borrow::Cow;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// A kind of density field; implemented by the struct of its parameters.
pub trait DensityField {
    /// Checks everything that types cannot: ranges, order, finiteness, whether it fits the container. Pointers start at
    /// `/density/<name>`.
    fn validate(&self, container: &Container) -> Result<(), Problem>;

    /// WGSL file that evaluates it, path below `shaders/`.
    fn shader(&self) -> Cow<'static, str>;

    /// Shader definitions for the parameters: decks, detail and the like.
    fn defs(&self) -> Defs {
        Defs::new()
    }

    /// The field on the device; [`DeviceField::new`] fills in what is the same for all.
    fn build(&self, gpu: &Gpu, around: &Surroundings) -> Result<DeviceField>;

    /// The field in f64 on the CPU, with textures filtered as `filter` says; `None` where the kind has no twin: the
    /// oracle then refuses the scene.
    fn twin(
        &self,
        _container: &Container,
        _extinction_per_m: f64,
        _filter: Filter,
    ) -> Result<Option<Box<dyn DensityTwin>>> {
        Ok(None)
    }

    /// Texture filterings that devices may use for it. More than one where hardware filters, since each device does it
    /// in its own way: comparisons then ask the twin for each and take the nearest.
    fn filters(&self) -> &'static [Filter] {
        &[Filter::Exact]
    }

    /// Whether density is the same everywhere, so that the truth can take large steps.
    fn is_uniform(&self) -> bool {
        false
    }

    /// The file that the field reads; an array in it is named behind a colon: `clouds.npz:density`.
    fn input_file(&self) -> Option<&Path> {
        None
    }

    /// [`DensityField::input_file`], mutable.
    fn input_file_mut(&mut self) -> Option<&mut PathBuf> {
        None
    }

    /// Seed of its noise; `None` without noise.
    fn seed_mut(&mut self) -> Option<&mut u32> {
        None
    }

    /// Numbers that the window can change, in the order in which they are shown.
    fn controls(&mut self) -> Vec<Control<'_>> {
        Vec::new()
    }

    /// Example fields, valid in `container`, that between them use every variant of the shader; none where the kind
    /// does not fit such a container, but at least one in a box or in a shell. Clouds in them fill the container's
    /// height, so that they are opaque enough to be calibrated when it is a few tens of mean free paths. The last has
    /// the most structure. Files that they read are written below `folder`.
    fn examples(container: &Container, folder: &Path) -> Result<Vec<Self>>
    where
        Self: Sized;
}

/// An entry of the registry.
pub struct DensityKind {
    /// Name in JSON.
    pub name: &'static str,
    /// See [`DensityField::examples`].
    pub examples: fn(&Container, &Path) -> Result<Vec<Density>>,
}

/// Context in which a field is built.
pub struct Surroundings<'a> {
    /// The container that it fills.
    pub container: &'a Container,
    /// Extinction at density 1, m⁻¹.
    pub extinction_per_m: f64,
    /// File that plays the role `container`, for passes that evaluate the field while it is built.
    pub container_shader: &'a str,
    /// Uniforms of group 0, for the same passes.
    pub inputs: &'a Inputs,
}

/// A density field ready to be bound.
pub struct DeviceField {
    /// File that plays the role `density`.
    pub shader: Cow<'static, str>,
    /// Structure of the field: decks, detail, precipitation.
    pub defs: Defs,
    /// Textures, buffers and uniforms of group 1.
    pub inputs: Inputs,
    /// Facts of the build, for reports.
    pub built: Built,
    /// Identifies imported data; empty for fields that the scene's JSON determines.
    pub content_hash: String,
}

impl DeviceField {
    /// `field` with the inputs of its shader; without build facts or imported data.
    pub fn new(field: &dyn DensityField, inputs: Inputs) -> Self {
        Self {
            shader: field.shader(),
            defs: field.defs(),
            inputs,
            built: Built::default(),
            content_hash: String::new(),
        }
    }
}

/// Facts about a field that was built.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Built {
    /// Wall time to make the noise textures, ms, with the queue drained; `None` without noise.
    pub noise_ms: Option<f64>,
    /// Share of the occupancy grid's cells that are provably empty; `None` without a grid.
    pub empty_fraction: Option<f64>,
    /// Edge of that grid's cells, metres; `None` without a grid.
    pub cell_m: Option<f64>,
    /// Share of columns that each deck covers, 0…1, measured after calibration.
    pub measured_coverage: Vec<f64>,
}

/// A density field in f64 on the CPU.
pub trait DensityTwin: Send + Sync {
    /// Density at a point inside the container, world metres.
    fn density(&self, p: DVec3) -> f64;

    /// Occupancy grid of provably empty space; `None` where nothing is known. Made once.
    fn occupancy(&self) -> Option<Occupancy> {
        None
    }

    /// Weather thresholds that give each deck its coverage; empty for fields without decks.
    fn thresholds(&self) -> &[f64] {
        &[]
    }

    /// Identifies imported data; empty for fields that the scene's JSON determines.
    fn content_hash(&self) -> String {
        String::new()
    }
}

/// A number of a field that the window offers to change.
pub struct Control<'a> {
    /// Label.
    pub name: String,
    /// One sentence that is shown beside it.
    pub doc: &'static str,
    /// Unit behind the number, with its leading blank; empty for a plain number.
    pub unit: &'static str,
    /// The number and its range.
    pub value: ControlValue<'a>,
}

/// The number behind a [`Control`].
pub enum ControlValue<'a> {
    /// A real number.
    Real(&'a mut f64, RangeInclusive<f64>),
    /// A whole number.
    Whole(&'a mut u32, RangeInclusive<u32>),
}
