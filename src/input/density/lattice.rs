//! Periodic lattice noise from integer hashes, in f64. Definitions: `shaders/noise/lattice.wgsl`.

use glam::DVec3;

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

/// Lattice coordinates −1, 0 and 1 cells from `base` along one axis, wrapped at `period`.
fn neighbours(base: f64, period: i32) -> [u32; 3] {
    [-1, 0, 1].map(|offset| (base as i32 + offset).rem_euclid(period).cast_unsigned())
}

/// Hash of a lattice cell.
pub fn lattice_hash([x, y, z]: [u32; 3], seed: u32) -> [u32; 3] {
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
pub fn perlin_fbm(p: DVec3, period: i32, octaves: u32, seed: u32) -> f64 {
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
pub fn worley(p: DVec3, period: i32, seed: u32) -> f64 {
    let base = p.floor();
    let f = p - base;
    let [xs, ys, zs] = base.to_array().map(|b| neighbours(b, period));
    // The sample's own cell first: its feature point makes most other cells too far to matter.
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
