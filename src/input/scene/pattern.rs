//! Pattern of the pixels that a frame marches: one of every block.

use super::ImageSize;

/// The pixels that one frame marches: one of every block of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subset {
    /// Width and height of a block, pixels, at least 1.
    pub block: [u32; 2],
    /// Column and row of the marched pixel inside a block of the first row of blocks.
    pub offset: [u32; 2],
    /// Columns by which that pixel lies further right in each next row of blocks, modulo the block's width: 0 for a
    /// rectangular grid, 1 with blocks of 2 × 1 for a checkerboard.
    pub shear: u32,
}

impl Subset {
    /// Every pixel.
    pub const EVERY: Self = Self {
        block: [1, 1],
        offset: [0, 0],
        shear: 0,
    };

    /// Columns and rows of blocks that cover a picture.
    pub fn blocks(&self, image: ImageSize) -> [u32; 2] {
        [
            image.width.div_ceil(self.block[0]),
            image.height.div_ceil(self.block[1]),
        ]
    }

    /// Rows of a picture that may hold marched pixels, from the top.
    pub fn rows(&self, image: ImageSize) -> impl Iterator<Item = u32> {
        (self.offset[1]..image.height).step_by(self.block[1] as usize)
    }

    /// Columns of the marched pixels of such a row, from the left.
    pub fn columns(&self, image: ImageSize, row: u32) -> impl Iterator<Item = u32> {
        let first = (self.offset[0] + self.shear * (row / self.block[1])) % self.block[0];
        (first..image.width).step_by(self.block[0] as usize)
    }
}

/// The pixels that consecutive frames march, cyclically: the same blocks, with an offset for each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// See [`Subset::block`].
    pub block: [u32; 2],
    /// See [`Subset::offset`]: one for each frame, at least one.
    pub offsets: &'static [[u32; 2]],
    /// See [`Subset::shear`].
    pub shear: u32,
}

impl Pattern {
    /// Every pixel in every frame.
    pub const EVERY: Self = Self {
        block: [1, 1],
        offsets: &[[0, 0]],
        shear: 0,
    };

    /// Length of the cycle, frames.
    pub fn frames(&self) -> usize {
        self.offsets.len()
    }

    /// The pixels of frame `frame`, counted from the beginning of a sequence.
    pub fn subset(&self, frame: usize) -> Subset {
        Subset {
            block: self.block,
            offset: self.offsets[frame % self.frames()],
            shear: self.shear,
        }
    }

    /// Pixels of a block, of which one is marched in a frame.
    pub fn one_in(&self) -> u32 {
        self.block[0] * self.block[1]
    }

    /// Whether each pixel of a block is marched in some frame of the cycle.
    pub fn is_complete(&self) -> bool {
        let mut offsets = self.offsets.to_vec();
        offsets.sort_unstable();
        offsets.dedup();
        offsets.len() == self.one_in() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often a frame marches each pixel, row by row.
    fn marched(subset: Subset, [width, height]: [u32; 2]) -> Vec<u32> {
        let image = ImageSize { width, height };
        let mut seen = vec![0; (width * height) as usize];
        for row in subset.rows(image) {
            for column in subset.columns(image, row) {
                seen[(row * width + column) as usize] += 1;
            }
        }
        seen
    }

    #[test]
    fn a_complete_pattern_marches_every_pixel_once_whatever_the_picture_measures() {
        const SQUARE: Pattern = Pattern {
            block: [2, 3],
            offsets: &[[0, 0], [1, 2], [0, 1], [1, 1], [0, 2], [1, 0]],
            shear: 0,
        };
        const CHECKERBOARD: Pattern = Pattern {
            block: [2, 1],
            offsets: &[[0, 0], [1, 0]],
            shear: 1,
        };
        for pattern in [Pattern::EVERY, SQUARE, CHECKERBOARD] {
            assert!(pattern.is_complete());
            for size in [[1, 1], [7, 5], [2, 6]] {
                let mut sum = vec![0; (size[0] * size[1]) as usize];
                for frame in 0..pattern.frames() {
                    let one = marched(pattern.subset(frame), size);
                    sum.iter_mut().zip(one).for_each(|(sum, n)| *sum += n);
                }
                assert!(sum.iter().all(|n| *n == 1), "{pattern:?} {size:?}");
            }
        }
        assert_eq!(
            marched(CHECKERBOARD.subset(2), [3, 2]),
            [1, 0, 1, 0, 1, 0],
            "the third frame is the first again"
        );
    }
}
