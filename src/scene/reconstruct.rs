//! How a picture comes about: all of it in one frame, or a quarter of its pixels in each of four.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// From frames to a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum Reconstruct {
    /// Every pixel is marched in every frame.
    #[default]
    #[serde(rename = "full")]
    Full,
    /// Temporal integration: one pixel of every 2 × 2 block is marched in a frame, the others come from the picture
    /// before, reprojected (Schneider & Vos 2015 with 4 × 4 blocks; thesis M, 3.1.7, with 2 × 2).
    #[serde(rename = "temporal_2x2")]
    Temporal2x2,
}

impl Reconstruct {
    /// Column and row inside its 2 × 2 block of the pixel that each of four consecutive frames marches: the order of
    /// Bayer's matrix (Bayer 1973). Row by row, a pan of one pixel a frame would march the same half of the cloud for ever.
    ///
    /// No cycle of four is without such a pan: of those along rows, columns and diagonals each reaches all of the cloud
    /// along one alone. On a pan of one pixel a frame along columns or diagonals this one marches every other row of the
    /// cloud for ever, and never those between.
    pub const BAYER_2X2: [[u32; 2]; 4] = [[0, 0], [1, 1], [1, 0], [0, 1]];

    /// Name in experiments and records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Temporal2x2 => "temporal_2x2",
        }
    }

    /// Frames until a resting camera sees the whole picture.
    pub fn frames(self) -> u32 {
        match self {
            Self::Full => 1,
            Self::Temporal2x2 => 4,
        }
    }

    /// For records that say nothing of it.
    pub fn is_full(&self) -> bool {
        *self == Self::Full
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_frames_march_every_pixel_of_a_block_at_rest_and_on_a_pan_along_rows() {
        // Rows and columns of the cloud, modulo 2, that a pan marches.
        let marched = |[across, down]: [u32; 2]| {
            let mut seen = [[false; 2]; 2];
            for (n, [x, y]) in (0..).zip(Reconstruct::BAYER_2X2) {
                seen[((y + n * down) % 2) as usize][((x + n * across) % 2) as usize] = true;
            }
            seen
        };
        for pan in [[0, 0], [1, 0]] {
            assert_eq!(marched(pan), [[true; 2]; 2], "{pan:?}");
        }
        for pan in [[0, 1], [1, 1]] {
            assert_eq!(marched(pan), [[true; 2], [false; 2]], "{pan:?}");
        }
    }

    #[test]
    fn names_are_those_of_the_files() {
        for value in [Reconstruct::Full, Reconstruct::Temporal2x2] {
            assert_eq!(serde_json::json!(value), serde_json::json!(value.name()));
        }
    }
}
