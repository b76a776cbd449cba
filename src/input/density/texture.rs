//! Textures of 8 bits a channel and how a device filters them.

use glam::DVec3;
use rayon::prelude::*;

/// How textures are filtered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Linear interpolation in f64.
    #[default]
    Exact,
    /// Mesa's llvmpipe: weights cut off to 1/256, every interpolation rounded to the texture's 8 bits. Other devices cut
    /// weights alone (Vulkan's `subTexelPrecisionBits` is 8 on most).
    EightBit,
}

impl Filter {
    /// Name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::EightBit => "8 bit",
        }
    }
}

/// An RGBA texture of 8 bits a channel, periodic, linearly interpolated; texel centres at (i + ½)/N.
pub struct Texture {
    filter: Filter,
    size: [usize; 3],
    /// x fastest, then y, then z.
    texels: Vec<[u8; 4]>,
}

/// Position of a sample between two texels of an axis.
struct Tap {
    index: [usize; 2],
    /// Weight of the second texel.
    weight: f64,
}

impl Texture {
    /// `value` at texel centres, in periods, rounded to 8 bits over [0, 1].
    pub fn new(filter: Filter, size: [u32; 3], value: impl Fn(DVec3) -> [f64; 4] + Sync) -> Self {
        let size = size.map(|n| n as usize);
        let [nx, ny, nz] = size;
        let mut texels = vec![[0; 4]; nx * ny * nz];
        texels
            .par_chunks_mut(nx)
            .enumerate()
            .for_each(|(row, line)| {
                for (x, texel) in line.iter_mut().enumerate() {
                    let centre = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
                    let p = DVec3::new(centre(x, nx), centre(row % ny, ny), centre(row / ny, nz));
                    *texel = value(p).map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8);
                }
            });
        Self {
            filter,
            size,
            texels,
        }
    }

    /// The bytes as a device lays them out.
    pub fn bytes(&self) -> &[u8] {
        self.texels.as_flattened()
    }

    /// The two texels around `u`, in periods, along an axis.
    fn tap(&self, axis: usize, u: f64) -> Tap {
        let n = self.size[axis];
        let position = u * n as f64 - 0.5;
        let low = position.floor();
        let first = (low as i64).rem_euclid(n as i64) as usize;
        let weight = position - low;
        Tap {
            index: [first, if first + 1 == n { 0 } else { first + 1 }],
            weight: match self.filter {
                Filter::Exact => weight,
                Filter::EightBit => (weight * 256.0).floor() / 256.0,
            },
        }
    }

    fn lerp(&self, a: [f64; 4], b: [f64; 4], weight: f64) -> [f64; 4] {
        let plain = |i: usize| a[i] + (b[i] - a[i]) * weight;
        match self.filter {
            Filter::Exact => std::array::from_fn(plain),
            Filter::EightBit => std::array::from_fn(|i| (plain(i) + 0.5).floor()),
        }
    }

    /// Bilinear sample of slice `z`, 0…255.
    fn slice(&self, x: &Tap, y: &Tap, z: usize) -> [f64; 4] {
        let row = |j: usize| {
            let at = |i: usize| {
                self.texels[(z * self.size[1] + y.index[j]) * self.size[0] + x.index[i]]
                    .map(f64::from)
            };
            self.lerp(at(0), at(1), x.weight)
        };
        self.lerp(row(0), row(1), y.weight)
    }

    /// Bilinear sample of a flat texture.
    pub fn sample_2d(&self, u: f64, v: f64) -> [f64; 4] {
        self.slice(&self.tap(0, u), &self.tap(1, v), 0)
            .map(|v| v / 255.0)
    }

    /// Trilinear sample.
    pub fn sample_3d(&self, p: DVec3) -> [f64; 4] {
        let [x, y, z] = [self.tap(0, p.x), self.tap(1, p.y), self.tap(2, p.z)];
        let slice = |k: usize| self.slice(&x, &y, z.index[k]);
        self.lerp(slice(0), slice(1), z.weight).map(|v| v / 255.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(filter: Filter) -> Texture {
        Texture::new(filter, [4, 4, 4], |p| [p.x, p.y, p.z, 1.0])
    }

    #[test]
    fn texel_centres_return_texels_and_midpoints_their_mean() {
        let texture = ramp(Filter::Exact);
        let [r, g, b, a] = texture.sample_3d(DVec3::new(0.125, 0.375, 0.875));
        assert_eq!(
            [r, g, b, a].map(|v| (v * 255.0).round()),
            [32.0, 96.0, 223.0, 255.0]
        );
        let [between, ..] = texture.sample_2d(0.25, 0.0);
        assert!((between * 255.0 - 64.0).abs() < 1e-12);
    }

    #[test]
    fn samples_repeat_across_the_seam() {
        for filter in [Filter::Exact, Filter::EightBit] {
            let texture = ramp(filter);
            // Exact in binary: a shift by whole periods gives the same point.
            let p = DVec3::new(0.984375, 0.015625, 0.5);
            assert_eq!(
                texture.sample_3d(p),
                texture.sample_3d(p + DVec3::new(2.0, -3.0, 5.0))
            );
            // Half way from the last texel to the first.
            assert!((texture.sample_2d(1.0, 0.3)[0] * 255.0 - 127.5).abs() <= 0.5);
        }
    }

    #[test]
    fn eight_bits_stay_within_one_unit_of_exact() {
        let (exact, device) = (ramp(Filter::Exact), ramp(Filter::EightBit));
        for i in 0..1000 {
            let p = DVec3::new(
                f64::from(i) * 0.618,
                f64::from(i) * 0.414,
                f64::from(i) * 0.732,
            );
            for (a, b) in exact.sample_3d(p).into_iter().zip(device.sample_3d(p)) {
                assert!((a - b).abs() * 255.0 <= 2.5, "{a} {b}");
            }
        }
    }
}
