//! Texel formats of light maps on a device, and the memory the maps take.

use super::map_pass::maps_of;
use crate::cost::Memory;
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::occlusion::plan::{CASCADE_BYTES, MapLayout, MapNumbers, MapPlan, WARP_BYTES, texels};
use crate::occlusion::{MethodSetup, Plan};
use crate::scene::{MapCoverage, MapFit};
use crate::shader_defs::Defs;
use wgpu::TextureFormat as F;

/// Texture format of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TexelFormat {
    /// wgpu's name.
    pub texture: F,
    /// Values a layer or voxel holds.
    pub channels: u32,
    /// Bytes of a value.
    pub value_bytes: u32,
    /// Definition that selects the format of the storage declaration in the shaders.
    define: &'static str,
}

/// Capabilities of a device for a format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FormatUse {
    /// A compute shader can write it.
    pub stored: bool,
    /// A sampler can interpolate it.
    pub filtered: bool,
}

/// The formats of one kind of number, with 1, 2 and 4 channels; there is none with three. Most formats under 32 bits
/// need optional features.
fn formats(numbers: MapNumbers, half: bool) -> [(F, u32, &'static str); 3] {
    match (numbers, half) {
        (MapNumbers::Float, true) => [
            (F::R16Float, 2, "TEXEL_R16"),
            (F::Rg16Float, 2, "TEXEL_RG16"),
            (F::Rgba16Float, 2, "TEXEL_RGBA16"),
        ],
        (MapNumbers::Float, false) => [
            (F::R32Float, 4, "TEXEL_R32"),
            (F::Rg32Float, 4, "TEXEL_RG32"),
            (F::Rgba32Float, 4, "TEXEL_RGBA32"),
        ],
        (MapNumbers::Unorm8, _) => [
            (F::R8Unorm, 1, "TEXEL_R8UNORM"),
            (F::Rg8Unorm, 1, "TEXEL_RG8UNORM"),
            (F::Rgba8Unorm, 1, "TEXEL_RGBA8UNORM"),
        ],
        (MapNumbers::Unorm16, _) => [
            (F::R16Unorm, 2, "TEXEL_R16UNORM"),
            (F::Rg16Unorm, 2, "TEXEL_RG16UNORM"),
            (F::Rgba16Unorm, 2, "TEXEL_RGBA16UNORM"),
        ],
        (MapNumbers::Word, _) => [
            (F::R32Uint, 4, "TEXEL_R32UINT"),
            (F::Rg32Uint, 4, "TEXEL_RG32UINT"),
            (F::Rgba32Uint, 4, "TEXEL_RGBA32UINT"),
        ],
    }
}

/// Wanted size of floats and filtering, from the parameters that the layout depends on.
struct StorageRequest {
    half: bool,
    filtered: bool,
}

impl StorageRequest {
    fn new(setup: &MethodSetup, layout: MapLayout) -> Result<Self> {
        let half = match layout.numbers() {
            MapNumbers::Float => setup.params.choice("storage")? == "f16",
            _ => false,
        };
        let filtered = match layout {
            MapLayout::Volume { .. } => true,
            MapLayout::Array { .. } | MapLayout::Buffer { .. } => {
                setup.params.choice("lookup")? == "hardware"
            }
        };
        let defect = |problem: &str| Err(Error::defect(setup.method.info().id, problem));
        if filtered && layout.numbers() == MapNumbers::Word {
            return defect("its map holds words, which no sampler interpolates");
        }
        if matches!(layout, MapLayout::Volume { values, .. } if values > 4) {
            return defect("a voxel of its map holds more than 4 values");
        }
        if layout.column_values() == 0 {
            return defect("its map holds no value");
        }
        Ok(Self { half, filtered })
    }
}

impl TexelFormat {
    /// The smallest format that `device` stores, and interpolates where the method asks for it; `None` for a buffer.
    pub fn choose(
        setup: &MethodSetup,
        layout: MapLayout,
        device: impl Fn(F) -> FormatUse,
    ) -> Result<Option<Self>> {
        let wanted = StorageRequest::new(setup, layout)?;
        let (values, numbers) = match layout {
            MapLayout::Buffer { .. } => return Ok(None),
            MapLayout::Array { values, numbers }
            | MapLayout::Volume {
                values, numbers, ..
            } => (values, numbers),
        };
        // Arrays of floats use one or four channels: two would change the memory of maps of two values against earlier
        // records.
        let skips_two = matches!(layout, MapLayout::Array { .. }) && numbers == MapNumbers::Float;
        let fits = |channels: u32| channels >= values.min(4) && !(channels == 2 && skips_two);
        let mut missing = None;
        for (channels, (texture, value_bytes, define)) in
            [1, 2, 4].into_iter().zip(formats(numbers, wanted.half))
        {
            let able = device(texture);
            if fits(channels) && able.stored && (able.filtered || !wanted.filtered) {
                return Ok(Some(Self {
                    texture,
                    channels,
                    value_bytes,
                    define,
                }));
            }
            missing = Some((texture, able));
        }
        Err(unable(layout, missing))
    }

    /// Array layers that hold `values` values a texel.
    pub fn layers(self, values: u32) -> u32 {
        values.div_ceil(self.channels)
    }
}

/// The error that tells what the widest format lacks.
fn unable(layout: MapLayout, missing: Option<(F, FormatUse)>) -> Error {
    match (layout.numbers(), missing) {
        (MapNumbers::Float, Some((_, able))) if able.stored => Error::gpu(
            "this adapter cannot interpolate f32 textures (feature float32-filterable)",
            match layout {
                MapLayout::Volume { .. } => "Use storage `f16`.",
                _ => "Use lookup `blend` or `nearest`, or storage `f16`.",
            },
        ),
        (MapNumbers::Unorm16, _) => Error::gpu(
            "this adapter cannot store textures of 16-bit fractions (feature texture-format-16bit-norm)",
            "Use a method or setting that stores floats or 8-bit fractions, or another adapter.",
        ),
        (_, missing) => {
            let name = missing.map_or("such".to_owned(), |(texture, _)| format!("{texture:?}"));
            Error::gpu(
                format!("this adapter cannot store {name} textures as the map needs them"),
                "Use another method or setting, or another adapter.",
            )
        }
    }
}

/// Capabilities of `gpu` for a format.
pub(super) fn usable(gpu: &Gpu, format: F) -> FormatUse {
    let features = gpu.device.features();
    let specific = wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
    if !features.contains(format.required_features()) {
        return FormatUse {
            stored: false,
            filtered: false,
        };
    }
    match features.contains(specific) {
        true => of_flags(gpu.adapter.get_texture_format_features(format).flags),
        false => guaranteed(format, features),
    }
}

/// Capabilities that every device with these features has for a format.
fn guaranteed(format: F, features: wgpu::Features) -> FormatUse {
    of_flags(format.guaranteed_format_features(features).flags)
}

fn of_flags(flags: wgpu::TextureFormatFeatureFlags) -> FormatUse {
    FormatUse {
        stored: flags.contains(wgpu::TextureFormatFeatureFlags::STORAGE_WRITE_ONLY),
        filtered: flags.contains(wgpu::TextureFormatFeatureFlags::FILTERABLE),
    }
}

/// A device that stores and interpolates every format.
fn anything(_: F) -> FormatUse {
    FormatUse {
        stored: true,
        filtered: true,
    }
}

/// Memory of a plan's map in `format`, with everything beside it.
pub(super) fn memory(
    plan: &MapPlan,
    format: Option<TexelFormat>,
    setup: &MethodSetup,
) -> Result<Memory> {
    let (resolution, rows) = (setup.params.int("resolution")?, setup.map_rows()?);
    let MapCoverage { fit, cascades, .. } = setup.map_coverage()?;
    let warp_bytes = match fit {
        MapFit::Warped(_) => WARP_BYTES,
        MapFit::Square | MapFit::Axes => 0,
    };
    let cascade_bytes = match cascades {
        1 => 0,
        _ => CASCADE_BYTES,
    };
    let table_bytes = u64::from(cascades) * (warp_bytes + cascade_bytes);
    let (values, slices) = match plan.layout {
        MapLayout::Array { values, .. } => (values, 1),
        MapLayout::Volume { values, slices, .. } => (values, slices),
        MapLayout::Buffer { words } => (words, 1),
    };
    let (value_bytes, stored_values) = match format {
        Some(format) => (format.value_bytes, format.layers(values) * format.channels),
        None => (4, values),
    };
    let places = texels([resolution, rows, slices], plan.levels);
    let bytes = |values: u32| u64::from(values) * u64::from(value_bytes) * places;
    let beside = |temporary: bool| -> u64 {
        let resources = plan.resources.iter();
        let bytes = resources.filter(|r| r.temporary == temporary);
        bytes.map(|r| r.kind.bytes()).sum()
    };
    let (kept, temporary_bytes) = (beside(false) + table_bytes, beside(true));
    let maps = maps_of(setup.fill_parts(plan)?);
    Ok(Memory {
        payload_bytes: maps * (bytes(values) + kept),
        map_bytes: maps * (bytes(stored_values) + kept) + temporary_bytes,
        allocator_bytes: None,
        temporary_bytes,
    })
}

/// Memory of a method on an assumed device that stores every format.
pub fn planned_memory(setup: &MethodSetup) -> Result<Memory> {
    let Some(map) = setup.method.plan(&setup.params)?.map else {
        return Ok(Memory::default());
    };
    let format = TexelFormat::choose(setup, map.layout, anything)?;
    memory(&map, format, setup)
}

/// Definitions of a map in `format`.
pub(super) fn defs(layout: MapLayout, format: Option<TexelFormat>) -> Defs {
    let mut defs = Defs::from([("HAS_MAP".to_owned(), None)]);
    defs.extend(format.map(|format| (format.define.to_owned(), None)));
    match layout {
        MapLayout::Array { .. } => {}
        MapLayout::Volume { .. } => {
            defs.insert("MAP_VOLUME".to_owned(), None);
        }
        MapLayout::Buffer { words } => {
            defs.insert("MAP_WORDS".to_owned(), Some(words.cast_signed()));
        }
    }
    defs
}

/// Definitions that a method's map adds to its shaders, on an assumed device that stores every format, or only the
/// formats that every device stores.
pub fn map_defs(setup: &MethodSetup, plan: &Plan, every_format: bool) -> Result<Defs> {
    let Some(map) = &plan.map else {
        return Ok(Defs::new());
    };
    let device = |format: F| match every_format {
        true => anything(format),
        false => FormatUse {
            stored: format.required_features().is_empty()
                && guaranteed(format, wgpu::Features::empty()).stored,
            filtered: true,
        },
    };
    let format = TexelFormat::choose(setup, map.layout, device)?;
    Ok(defs(map.layout, format))
}
