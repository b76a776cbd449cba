//! What a light map holds, read back.

use super::map_pass::MapTexture;
use crate::error::Result;
use crate::frame::is_nonfinite;
use crate::gpu::{Gpu, read_texture};
use half::f16;

/// The values of a light map as its method stored them.
#[derive(Clone, Debug, PartialEq)]
pub struct MapTexels {
    /// Edge of the square map, texels.
    pub resolution: u32,
    /// Values a texel; padding of the texture's format is left out.
    pub values_a_texel: u32,
    /// Values, texel after texel, u fastest.
    pub values: Vec<f32>,
}

impl MapTexels {
    /// The values of texel `(u, v)`, both below `resolution`.
    pub fn texel(&self, [u, v]: [u32; 2]) -> &[f32] {
        let n = self.values_a_texel as usize;
        let start = (v as usize * self.resolution as usize + u as usize) * n;
        &self.values[start..start + n]
    }

    /// Values that are NaN or infinite, told by their bits.
    pub fn nonfinite(&self) -> u64 {
        self.values.iter().filter(|v| is_nonfinite(**v)).count() as u64
    }

    pub(super) fn read(gpu: &Gpu, map: &MapTexture) -> Result<Self> {
        let bytes = read_texture(gpu, &map.texture)?;
        let channels = map.format.channels as usize;
        let numbers: Vec<f32> = if map.format.bytes as usize / channels == 2 {
            let two = bytes.as_chunks::<2>().0.iter();
            two.map(|b| f16::from_le_bytes(*b).to_f32()).collect()
        } else {
            let four = bytes.as_chunks::<4>().0.iter();
            four.map(|b| f32::from_le_bytes(*b)).collect()
        };
        let texels = (map.resolution as usize).pow(2);
        let n = map.values_a_texel as usize;
        let value = |texel: usize, i: usize| {
            numbers[(i / channels * texels + texel) * channels + i % channels]
        };
        Ok(Self {
            resolution: map.resolution,
            values_a_texel: map.values_a_texel,
            values: (0..texels * n).map(|i| value(i / n, i % n)).collect(),
        })
    }
}
