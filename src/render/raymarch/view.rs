//! A scene on the device at one image size, shared by every method and the truth.

use super::inputs::scene_inputs;
use super::picture::{DevicePicture, RGBA_BYTES};
use crate::density::DeviceField;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::{Gpu, Inputs};
use crate::scene::ImageSize;
use crate::scene::{Container, Integration, Scene};
use crate::shader_defs::Defs;
use std::rc::Rc;

/// A scene on the device at one image size.
pub struct DeviceView {
    /// The scene.
    pub scene: Scene,
    /// Picture size.
    pub image: ImageSize,
    /// Density field of the scene.
    pub density: Rc<DeviceField>,
    pub(super) inputs: Inputs,
    pub(super) defs: Defs,
    skip: bool,
    pub(super) picture: DevicePicture,
}

impl DeviceView {
    pub(super) fn new(
        gpu: &Gpu,
        scene: &Scene,
        image: ImageSize,
        density: Rc<DeviceField>,
        inputs: Inputs,
    ) -> Result<Self> {
        let pixels = u64::from(image.width) * u64::from(image.height);
        let bytes = pixels.saturating_mul(RGBA_BYTES);
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        if bytes == 0 || bytes > limit {
            return Err(Error::input(
                "image",
                format!(
                    "{} × {} pixels need {bytes} bytes a buffer, the adapter allows {limit}",
                    image.width, image.height
                ),
                "Choose another size.",
            ));
        }
        let picture = DevicePicture::new(gpu, image, false);
        gpu.check()?;
        Ok(Self {
            defs: defs(scene, &density),
            scene: scene.clone(),
            image,
            density,
            inputs,
            skip: true,
            picture,
        })
    }

    /// Turns the skipping of provably empty space on or off: a uniform, the pipelines are the same. Pictures must not
    /// change; prepare methods again afterwards.
    pub fn set_skip(&mut self, skip: bool) {
        let fresh = scene_inputs(&self.scene, self.image, skip);
        self.inputs.take_uniforms(fresh);
        self.skip = skip;
    }

    /// Whether provably empty space is skipped.
    pub fn skips(&self) -> bool {
        self.skip
    }

    /// Role → file of a march in this view.
    pub(super) fn roles<'a>(&'a self, occlusion: &'a str) -> Vec<(&'a str, &'a str)> {
        vec![
            ("container", container_shader(&self.scene)),
            ("density", &self.density.shader),
            ("sky", "sky/preetham.wgsl"),
            ("occlusion", occlusion),
        ]
    }

    /// The last picture that was rendered into this view.
    pub fn read(&self, gpu: &Gpu) -> Result<Frame> {
        self.picture.read(gpu)
    }
}

/// File that plays the role `container`.
pub(super) fn container_shader(scene: &Scene) -> &'static str {
    match scene.container {
        Container::Shell { .. } => "container/shell.wgsl",
        Container::Box { .. } => "container/box.wgsl",
    }
}

fn defs(scene: &Scene, density: &DeviceField) -> Defs {
    let mut defs = density.defs.clone();
    let mut define = |name: &str, on: bool| {
        if on {
            defs.insert(name.to_owned(), None);
        }
    };
    define("SKY", scene.sky.is_some());
    define("AMBIENT", scene.ambient.is_some());
    define(
        "INTEGRATION_THESIS",
        scene.march.integration == Integration::Thesis,
    );
    defs
}
