//! A picture on the device: the output of a march and the input of the passes after it.

use crate::error::Result;
use crate::frame::Frame;
use crate::gpu::{Gpu, Inputs, Resource, read_buffer};
use crate::scene::ImageSize;

/// Bytes of the radiance of a pixel, and of its sunlight.
pub(super) const RGBA_BYTES: u64 = 16;
/// Bytes of the inverse depth of a pixel.
const INVERSE_DEPTH_BYTES: u64 = 4;

/// Buffers of one value a pixel, row by row from the top.
#[derive(Clone)]
pub struct DevicePicture {
    image: ImageSize,
    /// RGB and opacity.
    radiance: wgpu::Buffer,
    /// Sunlight and mean V.
    sun: wgpu::Buffer,
    /// 1/mean depth along the optical axis, m⁻¹; 0 where there is no medium. `None` where no pass needs it.
    inverse_depth: Option<wgpu::Buffer>,
}

impl DevicePicture {
    /// An empty picture; [`Gpu::check`] tells whether memory sufficed.
    pub fn new(gpu: &Gpu, image: ImageSize, inverse_depth: bool) -> Self {
        let pixels = u64::from(image.width) * u64::from(image.height);
        let buffer = |name, pixel_bytes: u64| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            gpu.empty_buffer(name, pixels * pixel_bytes, usage)
        };
        Self {
            image,
            radiance: buffer("radiance", RGBA_BYTES),
            sun: buffer("sun", RGBA_BYTES),
            inverse_depth: inverse_depth.then(|| buffer("inverse depth", INVERSE_DEPTH_BYTES)),
        }
    }

    /// Offers the buffers of radiance, sunlight and inverse depth under the names that shaders give them.
    pub fn offer(&self, inputs: &mut Inputs, names: [&'static str; 3]) {
        let buffers = [Some(&self.radiance), Some(&self.sun), self.inverse_depth()];
        for (name, buffer) in names.into_iter().zip(buffers) {
            if let Some(buffer) = buffer {
                inputs.resource(name, Resource::Buffer(buffer.clone()));
            }
        }
    }

    /// Reads the picture back.
    pub fn read(&self, gpu: &Gpu) -> Result<Frame> {
        let ImageSize { width, height } = self.image;
        let bytes = u64::from(width) * u64::from(height) * RGBA_BYTES;
        let read = |buffer| -> Result<Vec<[f32; 4]>> {
            let bytes = read_buffer(gpu, buffer, bytes)?;
            Ok(bytemuck::pod_collect_to_vec(&bytes))
        };
        Ok(Frame {
            width,
            height,
            radiance: read(&self.radiance)?,
            sun: read(&self.sun)?,
        })
    }

    /// Size in pixels.
    pub(super) fn image(&self) -> ImageSize {
        self.image
    }

    pub(super) fn inverse_depth(&self) -> Option<&wgpu::Buffer> {
        self.inverse_depth.as_ref()
    }

    /// Bytes of its buffers.
    pub(super) fn bytes(&self) -> u64 {
        let buffers = [Some(&self.radiance), Some(&self.sun), self.inverse_depth()];
        buffers.into_iter().flatten().map(wgpu::Buffer::size).sum()
    }
}
