//! The pass that fills a light map, and the texture it fills.

use super::light_map::{TexelFormat, map_uniform};
use super::tiles::{Pass, SLOW_SAMPLES_A_MS, Tiles};
use super::{Renderer, View};
use crate::cost::Memory;
use crate::error::{Error, Result};
use crate::gpu::{Defs, Flight, Gpu, Inputs, Kernel, PassTime, Program, Resource, Span};
use crate::occlusion::MethodSetup;
use crate::progress::Progress;
use crate::scene::MapRectangle;
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
    tiles: Tiles,
    pub counts: Option<wgpu::Buffer>,
    pub texture: MapTexture,
}

impl MapPass {
    pub fn new(
        renderer: &Renderer,
        view: &View,
        shader: &str,
        defs: &Defs,
        inputs: &Inputs,
        texture: MapTexture,
        counting: bool,
    ) -> Result<Self> {
        let gpu = &renderer.gpu;
        let kernel = renderer.kernel(&Program {
            entry: "generate.wgsl",
            roles: view.roles(shader),
            defs: defs.clone(),
        })?;
        let mut inputs = inputs.clone();
        let counts = counting.then(|| counts_buffer(gpu, [texture.resolution; 2]));
        offer_counts(&mut inputs, counts.as_ref());
        let threads = renderer.tiling.target_ms * SLOW_SAMPLES_A_MS / f64::from(texture.steps);
        let tiles = Tiles::new(gpu, &mut inputs, renderer.tiling, threads);
        let groups = kernel.bind(gpu, &[&inputs, &view.inputs, &view.density.inputs])?;
        Ok(Self {
            kernel,
            groups,
            tiles,
            counts,
            texture,
        })
    }

    /// Fills the map, tile by tile; its GPU time.
    pub fn fill(&self, gpu: &Gpu, progress: Progress) -> Result<PassTime> {
        self.tiles.run(gpu, &self.pass(), progress)
    }

    /// Records the same without waiting.
    pub fn record(&self, flight: &mut Flight) -> Vec<Span> {
        self.tiles.record(flight, &self.pass())
    }

    fn pass(&self) -> Pass<'_> {
        Pass {
            kernel: &self.kernel,
            groups: &self.groups,
            size: [self.texture.resolution; 2],
            steps: [1, 1],
        }
    }
}

/// The map as allocated.
pub(super) struct MapTexture {
    pub texture: wgpu::Texture,
    pub format: TexelFormat,
    pub resolution: u32,
    /// Samples of a column.
    pub steps: u32,
    pub values_a_texel: u32,
    pub memory: Memory,
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
        let steps = setup.params.int("steps")?;
        inputs.uniform("map", map_uniform(&rectangle, resolution, steps));
        let memory = format.memory(values, storage, resolution);
        Ok(Self {
            texture,
            format,
            resolution,
            steps,
            values_a_texel: values,
            memory,
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
