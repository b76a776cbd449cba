//! The density field on the device: textures, occupancy, and the shader file that evaluates it.

pub(crate) mod bounds;
pub(crate) mod calibrate;
pub(crate) mod imported;
pub mod occupancy;
mod procedural;
pub mod volume;

pub(crate) use procedural::{DETAIL_TEXELS, SHAPE_TEXELS, WEATHER_TEXELS, weather_offset};

use crate::error::Result;
use crate::gpu::{Defs, Gpu, Inputs, UniformValue};
use crate::scene::{Density, Scene};

/// A density field ready to be bound.
pub struct DensityField {
    /// File that plays the role `density`.
    pub shader: &'static str,
    /// Structure of the field: decks, detail, precipitation.
    pub defs: Defs,
    /// Textures, buffers and uniforms of group 1.
    pub inputs: Inputs,
    /// What it took to build, for reports.
    pub built: Built,
    /// Identifies imported data; empty for fields that the scene's JSON determines.
    pub content_hash: String,
}

/// Facts about a field.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Built {
    /// Time for noise textures, ms of wall time with the queue drained; `None` without noise.
    pub noise_ms: Option<f64>,
    /// Share of the occupancy grid's cells that are provably empty; `None` without a grid.
    pub empty_fraction: Option<f64>,
    /// Covered share of each deck as measured after calibration.
    pub measured_coverage: Vec<f64>,
}

impl DensityField {
    /// Builds the field of `scene`; `scene_inputs` supplies container and medium to the calibration pass.
    pub fn new(
        gpu: &Gpu,
        scene: &Scene,
        container_shader: &'static str,
        scene_inputs: &Inputs,
    ) -> Result<Self> {
        match &scene.density {
            Density::Uniform { value } => Ok(uniform(*value)),
            Density::Procedural(p) => procedural::build(gpu, p, container_shader, scene_inputs),
            Density::Volume(v) => imported::build(gpu, scene, v),
        }
    }
}

fn uniform(value: f64) -> DensityField {
    let mut inputs = Inputs::default();
    inputs.uniform("field", [("value", UniformValue::F32(value as f32))]);
    DensityField {
        shader: "density/uniform.wgsl",
        defs: Defs::new(),
        inputs,
        built: Built::default(),
        content_hash: String::new(),
    }
}
