//! The pass that fills a light map, and the texture it fills.

use super::cost::Memory;
use super::light_map::{MapRectangle, TexelFormat};
use super::{Renderer, View};
use crate::error::{Error, Result};
use crate::frame::is_nonfinite;
use crate::gpu::{Defs, Gpu, Inputs, Kernel, Program, Resource, read_texture};
use crate::occlusion::MethodSetup;
use std::rc::Rc;

/// COPY_DST although nothing is copied there: without it wgpu zeroes the texture in a render pass, and a software adapter
/// (llvmpipe) then defers the timestamps of later compute passes until that frame buffer is flushed.
const MAP_USAGE: wgpu::TextureUsages = wgpu::TextureUsages::STORAGE_BINDING
    .union(wgpu::TextureUsages::TEXTURE_BINDING)
    .union(wgpu::TextureUsages::COPY_SRC)
    .union(wgpu::TextureUsages::COPY_DST);

/// The compiled pass with its resources.
pub(super) struct MapPass {
    pub kernel: Rc<Kernel>,
    pub groups: Vec<wgpu::BindGroup>,
    pub resolution: u32,
    pub counts: Option<wgpu::Buffer>,
    texture: wgpu::Texture,
}

impl MapPass {
    pub fn new(
        renderer: &Renderer,
        view: &View,
        shader: &str,
        defs: &Defs,
        inputs: &Inputs,
        map: &MapTexture,
        counting: bool,
    ) -> Result<Self> {
        let gpu = &renderer.gpu;
        let kernel = renderer.kernel(&Program {
            entry: "generate.wgsl",
            roles: view.roles(shader),
            defs: defs.clone(),
        })?;
        let mut inputs = inputs.clone();
        let counts = counting.then(|| counts_buffer(gpu, [map.resolution; 2]));
        offer_counts(&mut inputs, counts.as_ref());
        let groups = kernel.bind(gpu, &[&inputs, &view.inputs, &view.density.inputs])?;
        Ok(Self {
            kernel,
            groups,
            resolution: map.resolution,
            counts,
            texture: map.texture.clone(),
        })
    }

    /// Values of the map whose exponent bits are all ones: NaN or infinite.
    pub fn nonfinite_stored(&self, gpu: &Gpu) -> Result<u64> {
        let bytes = read_texture(gpu, &self.texture)?;
        let half = matches!(
            self.texture.format(),
            wgpu::TextureFormat::R16Float | wgpu::TextureFormat::Rgba16Float
        );
        let count = if half {
            let values = bytemuck::pod_collect_to_vec::<u8, u16>(&bytes);
            values.iter().filter(|v| **v & 0x7c00 == 0x7c00).count()
        } else {
            let values = bytemuck::pod_collect_to_vec::<u8, f32>(&bytes);
            values.iter().filter(|v| is_nonfinite(**v)).count()
        };
        Ok(count as u64)
    }
}

/// The map as allocated.
pub(super) struct MapTexture {
    pub resolution: u32,
    pub memory: Memory,
    texture: wgpu::Texture,
}

impl MapTexture {
    pub fn new(
        gpu: &Gpu,
        view: &View,
        setup: &MethodSetup,
        values: u32,
        defs: &mut Defs,
        inputs: &mut Inputs,
    ) -> Result<Self> {
        let resolution = setup.params.int("resolution")?;
        let storage = setup.params.choice("storage")?;
        let hardware = setup.params.choice("lookup")? == "hardware";
        let format = TexelFormat::choose(gpu, values, storage, hardware)?;
        let layers = values.div_ceil(format.channels);
        check_limits(gpu, resolution, layers)?;
        defs.insert(format.define.to_owned(), None);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("light map"),
            size: wgpu::Extent3d {
                width: resolution,
                height: resolution,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: format.texture,
            usage: MAP_USAGE,
            view_formats: &[],
        });
        gpu.check()?;
        let array = wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        };
        inputs.resource("map_texture", Resource::View(texture.create_view(&array)));
        inputs.resource("map_store", Resource::View(texture.create_view(&array)));
        inputs.resource("map_sampler", Resource::Sampler(clamping_sampler(gpu)));
        let rectangle = MapRectangle::fit(&view.scene, view.image, resolution);
        inputs.uniform(
            "map",
            rectangle.uniform(resolution, setup.params.int("steps")?),
        );
        let texels = u64::from(resolution).pow(2);
        let value_bytes = if storage == "f16" { 2 } else { 4 };
        let memory = Memory {
            payload_bytes: u64::from(values) * value_bytes * texels,
            map_bytes: u64::from(layers) * u64::from(format.bytes) * texels,
            allocator_bytes: None,
        };
        Ok(Self {
            resolution,
            memory,
            texture,
        })
    }
}

fn check_limits(gpu: &Gpu, resolution: u32, layers: u32) -> Result<()> {
    let limits = gpu.device.limits();
    let exceeded = |what: &str, wanted: u32, allowed: u32, remedy: &str| {
        Err(Error::gpu(
            format!("the map needs {what} {wanted}, the adapter's limit is {allowed}"),
            remedy,
        ))
    };
    if resolution > limits.max_texture_dimension_2d {
        return exceeded(
            "an edge of",
            resolution,
            limits.max_texture_dimension_2d,
            "Choose a smaller `resolution`.",
        );
    }
    if layers > limits.max_texture_array_layers {
        return exceeded(
            "array layers:",
            layers,
            limits.max_texture_array_layers,
            "Choose fewer `steps` or a lower `order`.",
        );
    }
    Ok(())
}

fn clamping_sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("light map"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

/// Four counters for each of `size` threads.
pub(super) fn counts_buffer(gpu: &Gpu, size: [u32; 2]) -> wgpu::Buffer {
    let bytes = u64::from(size[0]) * u64::from(size[1]) * 16;
    gpu.empty_buffer(
        "counts",
        bytes,
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    )
}

/// Offers the counters of a counting pass.
pub(super) fn offer_counts(inputs: &mut Inputs, buffer: Option<&wgpu::Buffer>) {
    if let Some(buffer) = buffer {
        inputs.resource("counts", Resource::Buffer(buffer.clone()));
    }
}
