//! Values of a light map, read back from the device.

use super::map_storage::{MapContent, MapStorage};
use crate::error::Result;
use crate::frame::is_nonfinite;
use crate::gpu::{Gpu, read_buffer, read_texture};
use crate::occlusion::plan::{MapLayout, MapNumbers};
use crate::scene::{MapCascades, MapRectangle};
use half::f16;

/// Values of a light map as its method stored them.
#[derive(Clone, Debug, PartialEq)]
pub struct MapTexels {
    /// Edge of a rectangle of the map, texels.
    pub resolution: u32,
    /// Values a texel, of a 3-D texture those of a column of voxels; padding of the format is left out.
    pub values_a_texel: u32,
    /// Values, texel after texel, u fastest.
    pub values: Vec<f32>,
    /// Where the texels lie in the plane perpendicular to the sun: the rectangles of all cascades, the nearest first, one
    /// above the other along v; at least one.
    pub rectangles: Vec<MapRectangle>,
}

impl MapTexels {
    /// The values of texel `(u, v)`; `v` counts through all rectangles.
    pub fn texel(&self, [u, v]: [u32; 2]) -> &[f32] {
        let n = self.values_a_texel as usize;
        let start = (v as usize * self.resolution as usize + u as usize) * n;
        &self.values[start..start + n]
    }

    /// Values that are NaN or infinite, told by their bits.
    pub fn nonfinite(&self) -> u64 {
        self.values.iter().filter(|v| is_nonfinite(**v)).count() as u64
    }

    pub(super) fn read(gpu: &Gpu, map: &MapStorage, cascades: &MapCascades) -> Result<Self> {
        let texels = map.resolution as usize * map.rows as usize;
        let n = map.layout.column_values() as usize;
        let numbers = map.layout.numbers();
        // `channels` numbers stand side by side; the first `together` of them are values of the column.
        let (numbers, channels, together) = match &map.content {
            MapContent::Words(buffer) => {
                let bytes = read_buffer(gpu, buffer, buffer.size())?;
                (decoded(&bytes, numbers, 4), n, n)
            }
            MapContent::Texture(texture, format) => {
                let bytes = read_texture(gpu, texture)?;
                let channels = format.channels as usize;
                let together = match map.layout {
                    MapLayout::Volume { values, .. } => values as usize,
                    _ => channels,
                };
                let numbers = decoded(&bytes, numbers, format.value_bytes);
                (numbers, channels, together)
            }
        };
        let value = |texel: usize, i: usize| {
            numbers[(i / together * texels + texel) * channels + i % together]
        };
        Ok(Self {
            resolution: map.resolution,
            values_a_texel: map.layout.column_values(),
            values: (0..texels * n).map(|i| value(i / n, i % n)).collect(),
            rectangles: cascades.rectangles().to_vec(),
        })
    }
}

/// Stored values as numbers; words as integers.
fn decoded(bytes: &[u8], numbers: MapNumbers, value_bytes: u32) -> Vec<f32> {
    let two = || bytes.as_chunks::<2>().0.iter();
    let four = || bytes.as_chunks::<4>().0.iter();
    match (numbers, value_bytes) {
        (MapNumbers::Unorm8, _) => bytes.iter().map(|b| f32::from(*b) / 255.0).collect(),
        (MapNumbers::Unorm16, _) => two()
            .map(|b| f32::from(u16::from_le_bytes(*b)) / 65_535.0)
            .collect(),
        (MapNumbers::Word, _) => four().map(|b| u32::from_le_bytes(*b) as f32).collect(),
        (MapNumbers::Float, 2) => two().map(|b| f16::from_le_bytes(*b).to_f32()).collect(),
        (MapNumbers::Float, _) => four().map(|b| f32::from_le_bytes(*b)).collect(),
    }
}
