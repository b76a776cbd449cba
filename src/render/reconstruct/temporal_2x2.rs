//! Temporal integration with blocks of 2 × 2 pixels.

use super::reprojection::Reprojection;
use crate::scene::{HistoryInfo, Pattern, ReconstructionInfo, RestInfo};

/// Column and row of the pixel that each of four consecutive frames marches inside its 2 × 2 block: the order of
/// Bayer's matrix (Bayer 1973). In row-by-row order, a pan of one pixel a frame would always march the same half of the
/// cloud.
///
/// Every cycle of four has such a pan: of pans along rows, columns and diagonals, each cycle reaches all of the cloud
/// along one kind alone. With this cycle, a pan of one pixel a frame along columns or diagonals marches every other row
/// of the cloud only, and never those between.
const BAYER: [[u32; 2]; 4] = [[0, 0], [1, 1], [1, 0], [0, 1]];

static INFO: ReconstructionInfo = ReconstructionInfo {
    id: "temporal_2x2",
    title: "Temporal integration",
    brief: "one pixel of every 2 × 2 block a frame, the others from the picture before, reprojected",
    doc: "Temporal integration: one pixel of every 2 × 2 block is marched in a frame, the others come from the picture\n\
          before, reprojected (Schneider & Vos 2015 with 4 × 4 blocks; thesis M, 3.1.7, with 2 × 2).",
    frame: "A frame marches one pixel of every 2 × 2 block; the others come from the picture before, reprojected by the \
            mean depth of what is seen.",
    citation: "Schneider & Vos 2015; thesis M, 3.1.7; Bayer 1973 (the order of pixels)",
    shaders: &[Reprojection::SHADER],
    pattern: Pattern {
        block: [2, 2],
        offsets: &BAYER,
        shear: 0,
    },
    smallest: [2, 2],
    history: Some(HistoryInfo {
        what: "the two pictures that are remembered",
        pixel_bytes: Reprojection::PIXEL_BYTES,
    }),
    rest: RestInfo {
        frames: 4,
        exact: true,
    },
};

/// The reconstruction.
pub(super) const TEMPORAL_2X2: Reprojection = Reprojection(&INFO);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_frames_march_every_pixel_of_a_block_at_rest_and_on_a_pan_along_rows() {
        // Rows and columns of the cloud, modulo 2, that a pan marches.
        let marched = |[across, down]: [u32; 2]| {
            let mut seen = [[false; 2]; 2];
            for (n, [x, y]) in (0..).zip(BAYER) {
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
}
