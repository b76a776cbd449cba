//! GPU storage of a light map, with the textures and buffers beside it, offered to kernels by name.

use super::map_format::{TexelFormat, memory};
use crate::cost::Memory;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Inputs, Resource};
use crate::occlusion::MethodSetup;
use crate::occlusion::plan::{
    MapLayout, MapNumbers, MapPlan, MapResource, MapResourceKind, MethodPass, StorableFormat,
};

/// COPY_DST although nothing is copied there: without it wgpu zeroes the texture in a render pass, and a software adapter
/// (llvmpipe) then defers the timestamps of later compute passes until that frame buffer is flushed.
const TEXTURE_USAGE: wgpu::TextureUsages = wgpu::TextureUsages::STORAGE_BINDING
    .union(wgpu::TextureUsages::TEXTURE_BINDING)
    .union(wgpu::TextureUsages::COPY_SRC)
    .union(wgpu::TextureUsages::COPY_DST);

/// The map and the resources beside it, which the map's passes fill.
pub(super) struct MapStorage {
    pub layout: MapLayout,
    /// Texels along u, and along v of a rectangle.
    pub resolution: u32,
    /// Texels along v of all rectangles.
    pub rows: u32,
    pub memory: Memory,
    pub content: MapContent,
    textures: Vec<NamedTexture>,
}

/// Storage of the map itself.
pub(super) enum MapContent {
    Texture(wgpu::Texture, TexelFormat),
    Words(wgpu::Buffer),
}

/// A texture and the WGSL variables that read and write it.
struct NamedTexture {
    read: &'static str,
    write: &'static str,
    texture: wgpu::Texture,
    dimension: wgpu::TextureViewDimension,
}

/// Size and format of a texture to create.
struct TextureSpec {
    label: &'static str,
    size: [u32; 3],
    levels: u32,
    dimension: wgpu::TextureDimension,
    format: wgpu::TextureFormat,
}

impl MapStorage {
    /// Allocates the resources of `plan` and offers them to `inputs`.
    pub fn new(
        gpu: &Gpu,
        setup: &MethodSetup,
        plan: &MapPlan,
        format: Option<TexelFormat>,
        inputs: &mut Inputs,
    ) -> Result<Self> {
        let resolution = setup.params.int("resolution")?;
        let rows = setup.map_rows()?;
        let mut textures = Vec::new();
        let content = match format {
            None => {
                let words = u64::from(plan.layout.column_values());
                let bytes = 4 * words * u64::from(resolution) * u64::from(rows);
                let buffer = buffer(gpu, "light map", bytes)?;
                offer_buffer(
                    inputs,
                    ["map_word_buffer", "map_word_buffer_store"],
                    &buffer,
                );
                MapContent::Words(buffer)
            }
            Some(format) => {
                let named = map_texture(gpu, plan, format, [resolution, rows])?;
                let content = MapContent::Texture(named.texture.clone(), format);
                textures.push(named);
                content
            }
        };
        for resource in &plan.resources {
            textures.extend(beside(gpu, resource, inputs)?);
        }
        for texture in &textures {
            texture.offer(inputs);
        }
        let filter = match plan.levels {
            0 | 1 => wgpu::MipmapFilterMode::Nearest,
            _ => wgpu::MipmapFilterMode::Linear,
        };
        let sampler = clamping_sampler(gpu, filter);
        inputs.resource("map_sampler", Resource::Sampler(sampler));
        gpu.check()?;
        Ok(Self {
            layout: plan.layout,
            resolution,
            rows,
            memory: memory(plan, format, setup)?,
            content,
            textures,
        })
    }

    /// Restricts texture variables to the mip levels that a pass names.
    pub fn narrow(&self, pass: &MethodPass, inputs: &mut Inputs) -> Result<()> {
        for (variable, level) in &pass.levels {
            let named = |t: &&NamedTexture| [t.read, t.write].contains(variable);
            let found = self.textures.iter().find(named);
            let found = found.filter(|t| *level < t.texture.mip_level_count());
            let Some(texture) = found else {
                return Err(Error::defect(
                    format!("pass `{}`", pass.entry),
                    format!("its plan has no level {level} of a texture `{variable}`"),
                ));
            };
            inputs.resource(variable, Resource::View(texture.view(*level, Some(1))));
        }
        Ok(())
    }
}

impl NamedTexture {
    /// Levels from `first` on: `count` of them, or all.
    fn view(&self, first: u32, count: Option<u32>) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(self.dimension),
            base_mip_level: first,
            mip_level_count: count,
            ..Default::default()
        })
    }

    fn offer(&self, inputs: &mut Inputs) {
        inputs.resource(self.read, Resource::View(self.view(0, None)));
        inputs.resource(self.write, Resource::View(self.view(0, Some(1))));
    }
}

/// Creates the texture of a map: array layers, or slices of a volume.
fn map_texture(
    gpu: &Gpu,
    plan: &MapPlan,
    format: TexelFormat,
    [columns, rows]: [u32; 2],
) -> Result<NamedTexture> {
    let (names, depth, dimension) = match plan.layout {
        MapLayout::Volume { slices, .. } => (
            ["map_volume_texture", "map_volume_store"],
            slices,
            wgpu::TextureDimension::D3,
        ),
        layout => (
            match layout.numbers() {
                MapNumbers::Word => ["map_word_texture", "map_word_store"],
                _ => ["map_texture", "map_store"],
            },
            format.layers(layout.column_values()),
            wgpu::TextureDimension::D2,
        ),
    };
    check_limits(gpu, rows, depth, dimension)?;
    let spec = TextureSpec {
        label: "light map",
        size: [columns, rows, depth],
        levels: plan.levels,
        dimension,
        format: format.texture,
    };
    named_texture(gpu, names, &spec)
}

/// Creates a texture beside the map; a buffer is created and offered at once, with `None` returned.
fn beside(gpu: &Gpu, resource: &MapResource, inputs: &mut Inputs) -> Result<Option<NamedTexture>> {
    let names = [resource.read, resource.write];
    let (size, levels, format, dimension) = match resource.kind {
        MapResourceKind::Buffer { .. } => {
            let buffer = buffer(gpu, resource.read, resource.kind.bytes())?;
            offer_buffer(inputs, names, &buffer);
            return Ok(None);
        }
        MapResourceKind::Array {
            size,
            levels,
            format,
        } => (size, levels, format, wgpu::TextureDimension::D2),
        MapResourceKind::Volume {
            size,
            levels,
            format,
        } => (size, levels, format, wgpu::TextureDimension::D3),
    };
    check_limits(gpu, size[0].max(size[1]), size[2], dimension)?;
    let spec = TextureSpec {
        label: resource.read,
        size,
        levels,
        dimension,
        format: texture_format(format),
    };
    named_texture(gpu, names, &spec).map(Some)
}

fn named_texture(
    gpu: &Gpu,
    [read, write]: [&'static str; 2],
    spec: &TextureSpec,
) -> Result<NamedTexture> {
    let [width, height, depth_or_array_layers] = spec.size;
    let halved = match spec.dimension {
        wgpu::TextureDimension::D3 => width.max(height).max(depth_or_array_layers),
        _ => width.max(height),
    };
    if spec.levels > u32::BITS - halved.leading_zeros() {
        return Err(Error::gpu(
            format!(
                "a texture of {halved} texels an edge has no {} mip levels",
                spec.levels
            ),
            "Choose a larger `resolution`.",
        ));
    }
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers,
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(spec.label),
        size,
        mip_level_count: spec.levels.max(1),
        sample_count: 1,
        dimension: spec.dimension,
        format: spec.format,
        usage: TEXTURE_USAGE,
        view_formats: &[],
    });
    gpu.check()?;
    Ok(NamedTexture {
        read,
        write,
        texture,
        dimension: match spec.dimension {
            wgpu::TextureDimension::D3 => wgpu::TextureViewDimension::D3,
            _ => wgpu::TextureViewDimension::D2Array,
        },
    })
}

fn texture_format(format: StorableFormat) -> wgpu::TextureFormat {
    match format {
        StorableFormat::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        StorableFormat::Rgba16Float => wgpu::TextureFormat::Rgba16Float,
        StorableFormat::R32Float => wgpu::TextureFormat::R32Float,
        StorableFormat::Rg32Float => wgpu::TextureFormat::Rg32Float,
        StorableFormat::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
        StorableFormat::R32Uint => wgpu::TextureFormat::R32Uint,
        StorableFormat::Rg32Uint => wgpu::TextureFormat::Rg32Uint,
        StorableFormat::Rgba32Uint => wgpu::TextureFormat::Rgba32Uint,
    }
}

fn buffer(gpu: &Gpu, label: &str, bytes: u64) -> Result<wgpu::Buffer> {
    let limits = gpu.device.limits();
    let allowed = limits
        .max_buffer_size
        .min(limits.max_storage_buffer_binding_size);
    if bytes > allowed {
        return Err(Error::gpu(
            format!("the map needs a buffer of {bytes} bytes, the adapter's limit is {allowed}"),
            "Choose a smaller `resolution`.",
        ));
    }
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let buffer = gpu.empty_buffer(label, bytes, usage);
    gpu.check()?;
    Ok(buffer)
}

fn offer_buffer(inputs: &mut Inputs, names: [&'static str; 2], buffer: &wgpu::Buffer) {
    for name in names {
        inputs.resource(name, Resource::Buffer(buffer.clone()));
    }
}

fn check_limits(gpu: &Gpu, edge: u32, depth: u32, dimension: wgpu::TextureDimension) -> Result<()> {
    let limits = gpu.device.limits();
    let exceeded = |what: &str, wanted: u32, allowed: u32, remedy: &str| {
        Err(Error::gpu(
            format!("the map needs {what} {wanted}, the adapter's limit is {allowed}"),
            remedy,
        ))
    };
    let volume = dimension == wgpu::TextureDimension::D3;
    let (most_edge, most_depth) = match volume {
        true => (
            limits.max_texture_dimension_3d,
            limits.max_texture_dimension_3d,
        ),
        false => (
            limits.max_texture_dimension_2d,
            limits.max_texture_array_layers,
        ),
    };
    if edge > most_edge {
        return exceeded(
            "an edge of",
            edge,
            most_edge,
            "Choose a smaller `resolution`.",
        );
    }
    if depth > most_depth && volume {
        return exceeded("slices:", depth, most_depth, "Choose fewer slices.");
    }
    if depth > most_depth {
        return exceeded(
            "array layers:",
            depth,
            most_depth,
            "Choose fewer `steps` or a lower `order`.",
        );
    }
    Ok(())
}

fn clamping_sampler(gpu: &Gpu, mipmap_filter: wgpu::MipmapFilterMode) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("light map"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter,
        ..Default::default()
    })
}
