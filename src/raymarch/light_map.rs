//! What the texels of a light map are made of.

use crate::cost::Memory;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, UniformValue};
use crate::occlusion::MethodSetup;
use crate::scene::MapRectangle;

/// Members of `Map` in shared/map.wgsl.
pub(super) fn map_uniform(
    rectangle: &MapRectangle,
    resolution: u32,
    steps: u32,
) -> Vec<(&'static str, UniformValue)> {
    vec![
        (
            "u_axis",
            UniformValue::Vec3(rectangle.u_axis.as_vec3().into()),
        ),
        (
            "v_axis",
            UniformValue::Vec3(rectangle.v_axis.as_vec3().into()),
        ),
        (
            "origin_m",
            UniformValue::Vec2(rectangle.origin_m.map(|v| v as f32)),
        ),
        ("extent_m", UniformValue::F32(rectangle.extent_m as f32)),
        ("depth_m", UniformValue::F32(rectangle.depth_m as f32)),
        ("resolution", UniformValue::U32(resolution)),
        ("steps", UniformValue::U32(steps)),
    ]
}

/// Texture format of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelFormat {
    /// wgpu's name.
    pub texture: wgpu::TextureFormat,
    /// Values a layer holds.
    pub channels: u32,
    /// Bytes a texel of one layer.
    pub bytes: u32,
    /// Definition that selects the storage declaration in shared/column.wgsl.
    pub define: &'static str,
}

impl TexelFormat {
    /// The smallest storable format for `values` values. No three-channel format can be stored to; one f16 channel needs
    /// an optional feature, without which four are taken (and counted as allocated).
    pub fn choose(gpu: &Gpu, values: u32, storage: &str, hardware: bool) -> Result<Self> {
        let single_f16 = gpu
            .device
            .features()
            .contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
        if hardware
            && storage == "f32"
            && !gpu
                .device
                .features()
                .contains(wgpu::Features::FLOAT32_FILTERABLE)
        {
            return Err(Error::gpu(
                "this adapter cannot interpolate f32 textures (feature float32-filterable)",
                "Use lookup `blend` or `nearest`, or storage `f16`.",
            ));
        }
        Ok(Self::smallest(values, storage, single_f16))
    }

    fn smallest(values: u32, storage: &str, single_f16: bool) -> Self {
        use wgpu::TextureFormat as F;
        let make = |texture, channels, bytes, define| Self {
            texture,
            channels,
            bytes,
            define,
        };
        match (storage, values) {
            ("f16", 1) if single_f16 => make(F::R16Float, 1, 2, "TEXEL_R16"),
            ("f16", _) => make(F::Rgba16Float, 4, 8, "TEXEL_RGBA16"),
            (_, 1) => make(F::R32Float, 1, 4, "TEXEL_R32"),
            _ => make(F::Rgba32Float, 4, 16, "TEXEL_RGBA32"),
        }
    }

    /// Memory of a map of this format.
    pub fn memory(&self, values: u32, storage: &str, resolution: u32) -> Memory {
        let texels = u64::from(resolution).pow(2);
        let value_bytes = if storage == "f16" { 2 } else { 4 };
        let layers = u64::from(values.div_ceil(self.channels));
        Memory {
            payload_bytes: u64::from(values) * value_bytes * texels,
            map_bytes: layers * u64::from(self.bytes) * texels,
            allocator_bytes: None,
        }
    }
}

/// Memory that a method takes on a device that stores every format, where no device is asked.
pub fn planned_memory(setup: &MethodSetup) -> Result<Memory> {
    let Some(values) = setup.method.plan(&setup.params)?.map_values else {
        return Ok(Memory::default());
    };
    let storage = setup.params.choice("storage")?;
    let resolution = setup.params.int("resolution")?;
    Ok(TexelFormat::smallest(values, storage, true).memory(values, storage, resolution))
}
