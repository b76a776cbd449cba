//! The noise textures of procedural clouds in f64, quantised to 8 bits as the device's are. Definitions:
//! `shaders/noise/*.wgsl` (they define the scene).

use super::{DETAIL_TEXELS, SHAPE_TEXELS, WEATHER_TEXELS};
use crate::density::lattice::{perlin_fbm, worley};
use crate::density::texture::{Filter, Texture};
use glam::DVec3;

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
