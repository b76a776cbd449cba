//! The noise of procedural clouds in f64: periodic lattice noise from integer hashes, and the three textures made of it,
//! quantised to 8 bits as the device's are. Definitions: `shaders/noise/*.wgsl` (they define the scene).

use super::texture::{Filter, Texture};
use glam::DVec3;

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

/// Neighbours of a cell along one axis, wrapped: those at −1, 0, 1.
fn neighbours(base: f64, period: i32) -> [u32; 3] {
    [-1, 0, 1].map(|offset| (base as i32 + offset).rem_euclid(period).cast_unsigned())
}

/// Hash of a lattice cell.
fn lattice_hash([x, y, z]: [u32; 3], seed: u32) -> [u32; 3] {
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
    let cells = base.to_array().map(|b| neighbours(b, period));
    let mut sum = 0.0;
    for corner in 0..8 {
        let offset = [corner & 1, corner >> 1 & 1, corner >> 2];
        let cell = std::array::from_fn(|i| cells[i][offset[i] + 1]);
        let share: f64 = (0..3)
            .map(|i| {
                if offset[i] == 1 {
                    weight[i]
                } else {
                    1.0 - weight[i]
                }
            })
            .product();
        let distance = f - DVec3::from(offset.map(|o| o as f64));
        sum += share * gradient(lattice_hash(cell, seed)[0], distance);
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
    let [xs, ys, zs] = base.to_array().map(|b| neighbours(b, period));
    // The own cell first: it makes most of the others too far to matter.
    let order = |cells: [u32; 3]| [(0.0, cells[1]), (-1.0, cells[0]), (1.0, cells[2])];
    let mut nearest = f64::INFINITY;
    for (dz, z) in order(zs) {
        for (dy, y) in order(ys) {
            for (dx, x) in order(xs) {
                let corner = DVec3::new(dx, dy, dz);
                let to_cell = (corner - f).max(f - corner - DVec3::ONE).max(DVec3::ZERO);
                if to_cell.length_squared() >= nearest {
                    continue;
                }
                let hash = lattice_hash([x, y, z], seed);
                let feature = DVec3::from(hash.map(|h| f64::from(h >> 8) / 16_777_216.0));
                nearest = nearest.min((corner + feature - f).length_squared());
            }
        }
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

/// Worley noise of one cell count, scaled from a tile of unit edge.
fn octave(p: DVec3, cells: i32, seed: u32) -> f64 {
    worley(p * f64::from(cells), cells, seed)
}

/// Shape: R Perlin–Worley, G, B, A Worley fBm of rising frequency (Schneider & Vos 2015).
pub(super) fn shape(seed: u32, filter: Filter) -> Texture {
    Texture::new(filter, [SHAPE_TEXELS; 3], |p| {
        let w: [f64; 4] =
            std::array::from_fn(|j| octave(p, 4 << j, seed.wrapping_add(100 + j as u32)));
        let fbm = |j: usize| 0.625 * w[j] + 0.25 * w[(j + 1).min(3)] + 0.125 * w[(j + 2).min(3)];
        let base = (0.5 + 0.8 * perlin_fbm(p * 4.0, 4, 4, seed)).clamp(0.0, 1.0);
        let billow = (mix(fbm(0), 1.0, base) - 0.45) / 0.55;
        [billow, fbm(1), fbm(2), fbm(3)]
    })
}

/// Detail: RGB Worley noise of rising frequency, each with a third of the next octave.
pub(super) fn detail(seed: u32, filter: Filter) -> Texture {
    Texture::new(filter, [DETAIL_TEXELS; 3], |p| {
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
pub(super) fn weather(seed: u32, filter: Filter) -> Texture {
    Texture::new(filter, [WEATHER_TEXELS, WEATHER_TEXELS, 1], |p| {
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
