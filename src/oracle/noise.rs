//! The noise of procedural clouds in f64: periodic lattice noise from integer hashes, and the three textures made of it,
//! quantised to 8 bits as the device's are. Definitions: `shaders/noise/*.wgsl` (they define the scene).

use glam::DVec3;
use rayon::prelude::*;

/// Edges of the textures, texels.
pub(super) use crate::density::{DETAIL_TEXELS, SHAPE_TEXELS, WEATHER_TEXELS};

/// pcg3d, Jarzynski & Olano 2020, *Hash Functions for GPU Rendering*.
fn pcg3d(v: [u32; 3]) -> [u32; 3] {
    let mix = |[mut x, mut y, mut z]: [u32; 3]| {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        [x, y, z]
    };
    let v = mix(v.map(|i| i.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)));
    mix(v.map(|i| i ^ (i >> 16)))
}

/// Hash of a lattice cell, periodic.
fn lattice_hash(cell: [i32; 3], period: i32, seed: u32) -> [u32; 3] {
    let [x, y, z] = cell.map(|c| c.rem_euclid(period).cast_unsigned());
    pcg3d([
        x.wrapping_add(seed),
        y.wrapping_add(seed.wrapping_mul(3).wrapping_add(7)),
        z.wrapping_add(seed.wrapping_mul(5).wrapping_add(11)),
    ])
}

/// The twelve edge gradients of Perlin 2002, chosen by the hash's upper four bits, times `d`.
fn gradient(hash: u32, d: DVec3) -> f64 {
    let h = hash >> 28;
    let u = if h < 8 { d.x } else { d.y };
    let v = match h {
        0..4 => d.y,
        12 | 14 => d.x,
        _ => d.z,
    };
    let signed = |value: f64, bit: u32| if h & bit == 0 { value } else { -value };
    signed(u, 1) + signed(v, 2)
}

/// Gradient noise of Perlin 2002 in [−1, 1]; `p` in cells, `period` cells a tile.
fn perlin(p: DVec3, period: i32, seed: u32) -> f64 {
    let base = p.floor();
    let f = p - base;
    let weight = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let mut sum = 0.0;
    for corner in 0..8 {
        let offset = [corner & 1, corner >> 1 & 1, corner >> 2];
        let cell: [i32; 3] = std::array::from_fn(|i| base[i] as i32 + offset[i]);
        let share: f64 = (0..3)
            .map(|i| {
                if offset[i] == 1 {
                    weight[i]
                } else {
                    1.0 - weight[i]
                }
            })
            .product();
        let distance = f - DVec3::from(offset.map(f64::from));
        sum += share * gradient(lattice_hash(cell, period, seed)[0], distance);
    }
    sum
}

/// Octaves of doubled frequency and halved weight; weights sum to 1.
fn perlin_fbm(p: DVec3, period: i32, octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for octave in 0..octaves {
        let (scale, weight) = (1 << octave, 0.5_f64.powi(octave as i32));
        let value = perlin(
            p * f64::from(scale),
            period * scale,
            seed.wrapping_add(octave),
        );
        sum += weight * value;
        total += weight;
    }
    sum / total
}

/// 1 − distance to the nearest feature point, one a cell, in [0, 1] (Worley 1996); `p` in cells.
fn worley(p: DVec3, period: i32, seed: u32) -> f64 {
    let base = p.floor();
    let f = p - base;
    let mut nearest = f64::INFINITY;
    for index in 0..27 {
        let offset = [index % 3 - 1, index / 3 % 3 - 1, index / 9 - 1];
        let cell: [i32; 3] = std::array::from_fn(|i| base[i] as i32 + offset[i]);
        let hash = lattice_hash(cell, period, seed);
        let feature = DVec3::from(hash.map(|h| f64::from(h >> 8) / 16_777_216.0));
        nearest = nearest.min((DVec3::from(offset.map(f64::from)) + feature - f).length_squared());
    }
    (1.0 - nearest.sqrt()).clamp(0.0, 1.0)
}

fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// An RGBA texture of 8 bits a channel, periodic, linearly interpolated; texel centres at (i + ½)/N.
pub(super) struct Texture {
    size: [usize; 3],
    /// x fastest, then y, then z.
    pub texels: Vec<[u8; 4]>,
}

impl Texture {
    fn new(size: [u32; 3], value: impl Fn(DVec3) -> [f64; 4] + Sync) -> Self {
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
        Self { size, texels }
    }

    /// The bytes as a device lays them out.
    pub fn bytes(&self) -> &[u8] {
        self.texels.as_flattened()
    }

    /// Texel indices and weight of the upper one along an axis; `u` in periods.
    fn taps(&self, axis: usize, u: f64) -> ([usize; 2], f64) {
        let n = self.size[axis];
        let position = u * n as f64 - 0.5;
        let low = position.floor();
        let index = (low as i64).rem_euclid(n as i64) as usize;
        ([index, (index + 1) % n], position - low)
    }

    fn accumulate(&self, sum: &mut [f64; 4], index: usize, weight: f64) {
        let texel = self.texels[index];
        for (total, value) in sum.iter_mut().zip(texel) {
            *total += weight * f64::from(value);
        }
    }

    /// Bilinear sample of a flat texture.
    pub fn sample_2d(&self, u: f64, v: f64) -> [f64; 4] {
        let ((x, wx), (y, wy)) = (self.taps(0, u), self.taps(1, v));
        let mut sum = [0.0; 4];
        for (j, share_y) in y.into_iter().zip([1.0 - wy, wy]) {
            for (i, share_x) in x.into_iter().zip([1.0 - wx, wx]) {
                self.accumulate(&mut sum, j * self.size[0] + i, share_x * share_y);
            }
        }
        sum.map(|v| v / 255.0)
    }

    /// Trilinear sample.
    pub fn sample_3d(&self, p: DVec3) -> [f64; 4] {
        let [(x, wx), (y, wy), (z, wz)] = [self.taps(0, p.x), self.taps(1, p.y), self.taps(2, p.z)];
        let mut sum = [0.0; 4];
        for (k, share_z) in z.into_iter().zip([1.0 - wz, wz]) {
            for (j, share_y) in y.into_iter().zip([1.0 - wy, wy]) {
                let row = (k * self.size[1] + j) * self.size[0];
                for (i, share_x) in x.into_iter().zip([1.0 - wx, wx]) {
                    self.accumulate(&mut sum, row + i, share_x * share_y * share_z);
                }
            }
        }
        sum.map(|v| v / 255.0)
    }
}

/// Worley noise of one cell count, scaled from a tile of unit edge.
fn octave(p: DVec3, cells: i32, seed: u32) -> f64 {
    worley(p * f64::from(cells), cells, seed)
}

/// Shape: R Perlin–Worley, G, B, A Worley fBm of rising frequency (Schneider & Vos 2015).
pub(super) fn shape(seed: u32) -> Texture {
    Texture::new([SHAPE_TEXELS; 3], |p| {
        let w: [f64; 4] =
            std::array::from_fn(|j| octave(p, 4 << j, seed.wrapping_add(100 + j as u32)));
        let fbm = |j: usize| 0.625 * w[j] + 0.25 * w[(j + 1).min(3)] + 0.125 * w[(j + 2).min(3)];
        let base = (0.5 + 0.8 * perlin_fbm(p * 4.0, 4, 4, seed)).clamp(0.0, 1.0);
        let billow = (mix(fbm(0), 1.0, base) - 0.45) / 0.55;
        [billow, fbm(1), fbm(2), fbm(3)]
    })
}

/// Detail: RGB Worley noise of rising frequency, each with a third of the next octave.
pub(super) fn detail(seed: u32) -> Texture {
    Texture::new([DETAIL_TEXELS; 3], |p| {
        let w: [f64; 4] =
            std::array::from_fn(|j| octave(p, 2 << j, seed.wrapping_add(200 + j as u32)));
        [
            mix(w[0], w[1], 0.33),
            mix(w[1], w[2], 0.33),
            mix(w[2], w[3], 0.33),
            1.0,
        ]
    })
}

/// Weather: coverage, precipitation, cloud type.
pub(super) fn weather(seed: u32) -> Texture {
    Texture::new([WEATHER_TEXELS, WEATHER_TEXELS, 1], |p| {
        let seeded = |offset: u32| seed.wrapping_add(offset);
        let clumps = 0.65 * octave(p, 6, seeded(300))
            + 0.25 * octave(p, 13, seeded(301))
            + 0.1 * octave(p, 29, seeded(302));
        let drift = 0.5 + 0.8 * perlin_fbm(p * 3.0, 3, 4, seeded(310));
        let coverage = 0.9 * smoothstep(0.2, 0.85, 0.7 * clumps + 0.3 * drift);
        let rain = (2.0 * perlin_fbm(p * 4.0, 4, 3, seeded(320))).clamp(0.0, 1.0);
        let kind = 0.5 * perlin_fbm(p * 5.0, 5, 3, seeded(330)) + smoothstep(0.2, 0.8, coverage);
        [coverage, rain * smoothstep(0.5, 0.9, coverage), kind, 1.0]
    })
}
