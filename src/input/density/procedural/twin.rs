//! Procedural clouds in f64: density of the decks, and the thresholds that give them their coverage.

use super::bounds::Bounds;
use super::calibrate::{CALIBRATION_COLUMNS, CALIBRATION_STEPS, search};
use super::noise::{detail, shape, weather};
use super::{Deck, Procedural, weather_offset};
use crate::container::Container;
use crate::density::DensityTwin;
use crate::density::occupancy::Occupancy;
use crate::density::texture::{Filter, Texture};
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::LN_2;

/// A field with its textures.
pub(super) struct Clouds {
    field: Procedural,
    container: Container,
    weather: Texture,
    shape: Texture,
    detail: Option<Texture>,
    thresholds: Vec<f64>,
}

/// Values of the weather map for a vertical column of a deck.
#[derive(Clone, Copy)]
struct Weather {
    coverage: f64,
    cloud_type: f64,
    rain_factor: f64,
}

/// Trapezoid of density against height: ramps up over the first two, down over the last two (Häggström 2018), for
/// stratus, stratocumulus and cumulus.
const TRAPEZOIDS: [[f64; 4]; 3] = [
    [0.02, 0.05, 0.09, 0.11],
    [0.02, 0.20, 0.48, 0.625],
    [0.0, 0.0625, 0.45, 1.0],
];

fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Density against height `h` of a cloud type: 0 stratus, 0.5 stratocumulus, 1 cumulus, linear in between.
fn height_gradient(h: f64, cloud_type: f64) -> f64 {
    let position = 2.0 * cloud_type.clamp(0.0, 1.0);
    let (lower, share) = if position < 1.0 {
        (0, position)
    } else {
        (1, position - 1.0)
    };
    let [x, y, z, w] = std::array::from_fn(|i| {
        TRAPEZOIDS[lower][i] + (TRAPEZOIDS[lower + 1][i] - TRAPEZOIDS[lower][i]) * share
    });
    smoothstep(x, y, h) * (1.0 - smoothstep(z, w, h))
}

impl Clouds {
    /// Makes the textures and calibrates every deck for `extinction_per_m`.
    pub fn new(
        field: &Procedural,
        container: &Container,
        extinction_per_m: f64,
        filter: Filter,
    ) -> Result<Self> {
        let mut clouds = Self {
            field: field.clone(),
            container: container.clone(),
            weather: weather(field.seed, filter),
            shape: shape(field.seed, filter),
            detail: field.detail.as_ref().map(|_| detail(field.seed, filter)),
            thresholds: Vec::new(),
        };
        for (i, deck) in field.decks.iter().enumerate() {
            let covered = |threshold| Ok(clouds.covered(i, deck, threshold, extinction_per_m));
            let (threshold, _) = search(i, deck, covered)?;
            clouds.thresholds.push(threshold);
        }
        Ok(clouds)
    }

    fn deck_density(&self, q: DVec3, index: usize, deck: &Deck, threshold: f64) -> f64 {
        if q.y <= deck.base_m || q.y >= deck.top_m {
            return 0.0;
        }
        self.density_under(q, deck, self.weather_at(q, index, deck, threshold))
    }

    fn weather_at(&self, q: DVec3, index: usize, deck: &Deck, threshold: f64) -> Weather {
        let period = |x_m: f64| x_m / self.field.weather_tile_m + weather_offset(index);
        let [coverage, rain, kind, _] = self.weather.sample_2d(period(q.x), period(q.z));
        let [low, high] = deck.cloud_type;
        Weather {
            coverage: (coverage + 2.0 * threshold - 1.0).clamp(0.0, 1.0),
            cloud_type: low + (high - low) * kind,
            rain_factor: 1.0 + self.field.precipitation_gain.unwrap_or(0.0) * rain,
        }
    }

    /// Density between a deck's base and top.
    fn density_under(&self, q: DVec3, deck: &Deck, weather: Weather) -> f64 {
        let h = (q.y - deck.base_m) / (deck.top_m - deck.base_m);
        let gradient = height_gradient(h, weather.cloud_type);
        // Shape is at most 1.
        if gradient <= 1.0 - weather.coverage {
            return 0.0;
        }
        let base = self.base(q, gradient, weather.coverage);
        if base <= 0.0 {
            return 0.0;
        }
        self.eroded(q, h, base) * weather.rain_factor
    }

    /// saturate(remap(shape·gradient, 1 − c, 1, 0, 1))·c, shape = remap(R, fbm − 1, 1, 0, 1).
    fn base(&self, q: DVec3, gradient: f64, c: f64) -> f64 {
        let [r, g, b, a] = self.shape.sample_3d(q / self.field.shape_tile_m);
        let fbm = 0.625 * g + 0.25 * b + 0.125 * a;
        let shape = (r - (fbm - 1.0)) / (1.0 - (fbm - 1.0));
        ((shape * gradient - (1.0 - c)) / c).clamp(0.0, 1.0) * c
    }

    /// saturate(remap(base, strength·m, 1, 0, 1)), m = mix(e, 1 − e, saturate(10 h)).
    fn eroded(&self, q: DVec3, h: f64, base: f64) -> f64 {
        let Some((texture, detail)) = self.detail.as_ref().zip(self.field.detail.as_ref()) else {
            return base;
        };
        let [r, g, b, _] = texture.sample_3d(q / detail.tile_m);
        let e = 0.625 * r + 0.25 * g + 0.125 * b;
        let m = e + (1.0 - 2.0 * e) * (10.0 * h).clamp(0.0, 1.0);
        let erosion = detail.strength * m;
        ((base - erosion) / (1.0 - erosion)).clamp(0.0, 1.0)
    }

    /// Share of vertical columns of a deck, alone, whose opacity exceeds ½.
    fn covered(&self, index: usize, deck: &Deck, threshold: f64, extinction_per_m: f64) -> f64 {
        let n = CALIBRATION_COLUMNS;
        let step_m = (deck.top_m - deck.base_m) / f64::from(CALIBRATION_STEPS);
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(n) * self.field.weather_tile_m;
        let opaque = |x: u32, z: u32| {
            let ground = DVec3::new(at(x), 0.0, at(z));
            let weather = self.weather_at(ground, index, deck, threshold);
            let mut tau = 0.0;
            (0..CALIBRATION_STEPS).any(|k| {
                let y_m = deck.base_m + (f64::from(k) + 0.5) * step_m;
                let density = self.density_under(ground.with_y(y_m), deck, weather);
                tau += density * extinction_per_m * step_m;
                tau > LN_2
            })
        };
        let rows = (0..n).into_par_iter();
        let count: usize = rows.map(|z| (0..n).filter(|x| opaque(*x, z)).count()).sum();
        count as f64 / f64::from(n * n)
    }
}

impl DensityTwin for Clouds {
    /// Largest density of the decks.
    fn density(&self, p: DVec3) -> f64 {
        let q = self.container.field_point(p);
        let decks = self.field.decks.iter().zip(&self.thresholds).enumerate();
        decks
            .map(|(i, (deck, threshold))| self.deck_density(q, i, deck, *threshold))
            .fold(0.0, f64::max)
    }

    fn occupancy(&self) -> Option<Occupancy> {
        let (shape, weather) = (self.shape.bytes(), self.weather.bytes());
        Some(Bounds::new(shape, weather, &self.field, &self.thresholds).occupancy())
    }

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }
}
