//! GPU resources that a method needs: the form of its light map, further textures and buffers, and its own passes.
//!
//! The map's geometry, the march of its columns and the fallback outside of it are shared; a method declares the layout
//! of its map ([`MapLayout`]) and exports from its WGSL file what the layout calls for:
//!
//! | layout | stores with | is read by | offers to the view march |
//! |---|---|---|---|
//! | [`MapLayout::Array`] of fractions or floats | `column::store` | `map::fetch` | `transmittance(tap, depth)` |
//! | [`MapLayout::Array`] of words | `map_words::store_words` | `map_words::fetch_words` | `transmittance(tap, depth)` |
//! | [`MapLayout::Volume`] | `map_volume::store_voxel` | `map_volume::sample_volume` | `transmittance_at(uv, depth)` |
//! | [`MapLayout::Buffer`] | `map_buffer::store_word` | `map_buffer::fetch_word` | `transmittance(tap, depth)` |
//!
//! All of them offer `encode(column)` to the column pass. Bindings of group 2 from 16 on are the method's own.

use super::MethodSetup;
use super::rounding::FloatFormat;
use crate::error::{Error, Result};
use crate::scene::WARP_PARTS;
use crate::shader_defs::Defs;

/// Bytes of a warp's table: a knot of two f32 at both ends of every part.
pub const WARP_BYTES: u64 = (WARP_PARTS as u64 + 1) * 8;

/// Bytes that place one of several cascades: origin, extent, reach and padding, f32.
pub const CASCADE_BYTES: u64 = 24;

/// Map and shader definitions that a method needs at given parameters.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The light map; `None` = no map.
    pub map: Option<MapPlan>,
    /// Definitions beside those of the choices, for shader structure that depends on a number.
    pub defs: Defs,
}

/// A light map, with further resources and passes.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPlan {
    /// Layout of the map, which the column pass fills.
    pub layout: MapLayout,
    /// Mip levels of the map's texture, at least 1; the column pass fills the first.
    pub levels: u32,
    /// Further textures and buffers.
    pub resources: Vec<MapResource>,
    /// Passes before the column pass, in their order.
    pub before: Vec<MethodPass>,
    /// Passes after the column pass, in their order.
    pub after: Vec<MethodPass>,
}

/// Storage of a map. The parameter `resolution` is its edge in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapLayout {
    /// A 2-D array texture, read by texels as the parameter `lookup` says.
    Array {
        /// Values a texel.
        values: u32,
        /// How they are stored.
        numbers: MapNumbers,
    },
    /// A 3-D texture, read with one trilinear fetch of the sampler.
    Volume {
        /// Voxels along the depth of the map.
        slices: u32,
        /// Values a voxel, 1 to 4.
        values: u32,
        /// How they are stored; words cannot be interpolated.
        numbers: MapNumbers,
    },
    /// A buffer of 32-bit words, read by texels as the parameter `lookup` says.
    Buffer {
        /// Words a texel.
        words: u32,
    },
}

/// Number format of a stored value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapNumbers {
    /// Floating point of the bits that the parameter `storage` names.
    Float,
    /// A fraction in 0…1 of 8 bits.
    Unorm8,
    /// A fraction in 0…1 of 16 bits; an optional feature of devices.
    Unorm16,
    /// 32 bits that the method packs.
    Word,
}

/// A texture or buffer beside the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapResource {
    /// WGSL variable that reads it.
    pub read: &'static str,
    /// WGSL variable that writes it; of a texture, its first level.
    pub write: &'static str,
    /// Kind and size.
    pub kind: MapResourceKind,
    /// Not read by the view march: an engine can use the memory for something else in the same frame.
    pub temporary: bool,
}

/// Kind and size of a resource beside a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapResourceKind {
    /// A buffer of 32-bit words.
    Buffer {
        /// How many.
        words: u32,
    },
    /// A 2-D array texture.
    Array {
        /// Texels along x and y, and layers.
        size: [u32; 3],
        /// Mip levels, at least 1.
        levels: u32,
        /// Format of a texel.
        format: StorableFormat,
    },
    /// A 3-D texture.
    Volume {
        /// Voxels along x, y and z.
        size: [u32; 3],
        /// Mip levels, at least 1.
        levels: u32,
        /// Format of a voxel.
        format: StorableFormat,
    },
}

/// Texture formats that every device can store to, named as in WGSL. The 32-bit floats are interpolated by some devices
/// only, the integers by none.
#[allow(missing_docs, reason = "the names are WGSL's")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StorableFormat {
    Rgba8Unorm,
    Rgba16Float,
    R32Float,
    Rg32Float,
    Rgba32Float,
    R32Uint,
    Rg32Uint,
    Rgba32Uint,
}

/// A pass of a method's own; its GPU time is part of `generate`, as that of the column pass.
///
/// The entry point is in the method's WGSL file and imports `method_pass::{in_tile, place, count_samples}`: passes are
/// dispatched in tiles of whole workgroups, and a pass that takes density samples counts them. What passes after the columns
/// mix of neighbouring texels, a twin says in [`Encoding::mix`](super::twin::Encoding::mix).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MethodPass {
    /// Entry point.
    pub entry: &'static str,
    /// Invocations along x and y.
    pub threads: [u32; 2],
    /// Mip level to which a texture variable is restricted in this pass. Other variables see all levels where they read
    /// and the first where they write. A pass cannot read a level that it writes.
    pub levels: Vec<(&'static str, u32)>,
}

impl Plan {
    /// A map of `values` floats a texel.
    pub fn array(values: u32) -> Self {
        Self::of(MapLayout::Array {
            values,
            numbers: MapNumbers::Float,
        })
    }

    /// A map of this layout.
    pub fn of(layout: MapLayout) -> Self {
        Self {
            map: Some(MapPlan::of(layout)),
            defs: Defs::new(),
        }
    }

    /// Values that the map holds for a column; `None` without a map.
    pub fn map_values(&self) -> Option<u32> {
        self.map.as_ref().map(|map| map.layout.column_values())
    }
}

impl MapPlan {
    /// The map alone, without further resources or passes.
    pub fn of(layout: MapLayout) -> Self {
        Self {
            layout,
            levels: 1,
            resources: Vec::new(),
            before: Vec::new(),
            after: Vec::new(),
        }
    }
}

impl MapLayout {
    /// Values stored for one column.
    pub fn column_values(self) -> u32 {
        match self {
            Self::Array { values, .. } => values,
            Self::Volume { slices, values, .. } => slices.saturating_mul(values),
            Self::Buffer { words } => words,
        }
    }

    /// How its values are stored.
    pub fn numbers(self) -> MapNumbers {
        match self {
            Self::Array { numbers, .. } | Self::Volume { numbers, .. } => numbers,
            Self::Buffer { .. } => MapNumbers::Word,
        }
    }
}

impl StorableFormat {
    /// Bytes of a texel.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Rgba8Unorm | Self::R32Float | Self::R32Uint => 4,
            Self::Rgba16Float | Self::Rg32Float | Self::Rg32Uint => 8,
            Self::Rgba32Float | Self::Rgba32Uint => 16,
        }
    }
}

impl MapResourceKind {
    /// Bytes of all levels.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Buffer { words } => 4 * u64::from(words),
            Self::Array {
                size: [x, y, layers],
                levels,
                format,
            } => u64::from(layers) * format.bytes() * texels([x, y, 1], levels),
            Self::Volume {
                size,
                levels,
                format,
            } => format.bytes() * texels(size, levels),
        }
    }
}

/// Texels of a texture with these mip levels: each halves every edge, down to 1.
pub fn texels(size: [u32; 3], levels: u32) -> u64 {
    let edge = |edge: u32, level: u32| u64::from(edge.checked_shr(level).unwrap_or(0).max(1));
    let level = |level: u32| {
        let edges = size.iter().map(|e| edge(*e, level));
        edges.fold(1, u64::saturating_mul)
    };
    (0..levels.max(1)).map(level).fold(0, u64::saturating_add)
}

/// Rows of a workgroup of the column pass.
const ROWS_OF_WORKGROUP: u32 = 8;

impl MethodSetup {
    /// Equal parts in which the map of `plan` is filled, one a frame; an error where its rows do not split evenly, or
    /// where the method has passes of its own, which need the whole map.
    pub fn fill_parts(&self, plan: &MapPlan) -> Result<u32> {
        let (frames, rows) = (self.fill_frames(), self.map_rows()?);
        let place = || format!("method `{}`, fill_frames {frames}", self.method.info().id);
        if frames > 1 && !(plan.before.is_empty() && plan.after.is_empty()) {
            let problem = "it has passes that need the whole map";
            return Err(Error::input(place(), problem, "Choose `fill_frames` 1."));
        }
        let whole = ROWS_OF_WORKGROUP.saturating_mul(frames);
        if frames > 1 && !rows.is_multiple_of(whole) {
            let problem = format!(
                "a map of {rows} rows has no {frames} equal parts of whole workgroups, {ROWS_OF_WORKGROUP} rows each"
            );
            let remedy = format!(
                "Choose a `resolution` with a multiple of {whole} rows, or other `fill_frames`."
            );
            return Err(Error::input(place(), problem, remedy));
        }
        Ok(frames)
    }

    /// Number format of stored values; `None` without a map.
    pub fn stored_format(&self) -> Result<Option<FloatFormat>> {
        let Some(map) = self.method.plan(&self.params)?.map else {
            return Ok(None);
        };
        Ok(Some(match map.layout.numbers() {
            MapNumbers::Float if self.params.choice("storage")? == "f16" => FloatFormat::F16,
            MapNumbers::Float => FloatFormat::F32,
            MapNumbers::Unorm8 => FloatFormat::Unorm8,
            MapNumbers::Unorm16 => FloatFormat::Unorm16,
            MapNumbers::Word => FloatFormat::Packed,
        }))
    }
}
