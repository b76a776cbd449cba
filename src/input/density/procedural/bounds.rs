//! Conservative upper bounds of the procedural density over the cells of its occupancy grid.

use super::{Procedural, SHAPE_TEXELS, WEATHER_TEXELS, weather_offset};
use crate::density::occupancy::Occupancy;

/// Cells of the occupancy grid along one shape tile: two texels a cell.
const CELLS_PER_TILE: u32 = SHAPE_TEXELS / 2;
/// Slack for 8-bit filter weights and texel rounding in the bounds.
const FILTER_SLACK: f32 = 2.0 / 255.0;

/// Upper bounds of the density over cells of the periodic field.
pub(super) struct Bounds<'a> {
    field: &'a Procedural,
    thresholds: &'a [f64],
    /// Largest `shape` (before the height gradient) of each cell of one shape tile, x fastest.
    billow: Vec<f32>,
    weather: &'a [u8],
    cell_m: f64,
}

impl<'a> Bounds<'a> {
    /// `shape` and `weather`: texels of the two textures, RGBA.
    pub fn new(
        shape: &[u8],
        weather: &'a [u8],
        field: &'a Procedural,
        thresholds: &'a [f64],
    ) -> Self {
        let cell_m = field.shape_tile_m / f64::from(CELLS_PER_TILE);
        Self {
            field,
            thresholds,
            billow: billow_bounds(shape),
            weather,
            cell_m,
        }
    }

    pub fn occupancy(&self) -> Occupancy {
        let low_m = self
            .field
            .decks
            .iter()
            .map(|d| d.base_m)
            .fold(f64::INFINITY, f64::min);
        let high_m = self
            .field
            .decks
            .iter()
            .map(|d| d.top_m)
            .fold(f64::NEG_INFINITY, f64::max);
        let first = (low_m / self.cell_m).floor();
        let layers = ((high_m / self.cell_m).ceil() - first) as usize;
        let across = (self.field.weather_tile_m / self.cell_m).round() as usize;
        let columns: Vec<Vec<WeatherBound>> = (0..self.field.decks.len())
            .map(|d| self.weather_bounds(across, d))
            .collect();
        let n = CELLS_PER_TILE as usize;
        Occupancy::new(
            [across, layers, across],
            true,
            [0.0, first * self.cell_m, 0.0],
            self.cell_m,
            |x, y, z| {
                // A box may reach below height 0.
                let level = first as i64 + y as i64;
                let row = level.rem_euclid(n as i64) as usize;
                let billow = self.billow[((z % n) * n + row) * n + x % n];
                self.field
                    .decks
                    .iter()
                    .zip(&columns)
                    .any(|(deck, columns)| {
                        let weather = columns[z * across + x];
                        let height = |edge: f64| {
                            ((edge * self.cell_m - deck.base_m) / (deck.top_m - deck.base_m)) as f32
                        };
                        let gradient = weather.gradient_bound(
                            height(level as f64 - 0.01),
                            height(level as f64 + 1.01),
                        );
                        billow * gradient + FILTER_SLACK > 1.0 - weather.coverage
                    })
            },
        )
    }

    /// Bounds of weather over the footprint of every cell column of a deck.
    fn weather_bounds(&self, across: usize, deck_index: usize) -> Vec<WeatherBound> {
        let deck = &self.field.decks[deck_index];
        let n = WEATHER_TEXELS as usize;
        let offset = weather_offset(deck_index);
        // Texels whose filter footprint touches the cell, one more for rounding.
        let span = |cell: usize| {
            let texel = |edge: f64| (edge / across as f64 + offset) * n as f64 - 0.5;
            (texel(cell as f64).floor() as usize).saturating_sub(1)
                ..=texel(cell as f64 + 1.0).floor() as usize + 2
        };
        let kind = |v: u8| {
            deck.cloud_type[0] as f32
                + (deck.cloud_type[1] - deck.cloud_type[0]) as f32 * f32::from(v) / 255.0
        };
        let mut bounds = Vec::with_capacity(across * across);
        for z in 0..across {
            for x in 0..across {
                let mut bound = WeatherBound {
                    coverage: 0.0,
                    type_low: 1.0,
                    type_high: 0.0,
                };
                for k in span(z) {
                    for i in span(x) {
                        let texel = &self.weather[4 * ((k % n) * n + i % n)..];
                        let coverage = f32::from(texel[0]) / 255.0
                            + 2.0 * self.thresholds[deck_index] as f32
                            - 1.0;
                        bound.coverage = bound.coverage.max(coverage.clamp(0.0, 1.0));
                        bound.type_low = bound.type_low.min(kind(texel[2]) - FILTER_SLACK);
                        bound.type_high = bound.type_high.max(kind(texel[2]) + FILTER_SLACK);
                    }
                }
                bounds.push(bound);
            }
        }
        bounds
    }
}

/// Bounds of the weather map over one cell's footprint.
#[derive(Clone, Copy)]
struct WeatherBound {
    coverage: f32,
    type_low: f32,
    type_high: f32,
}

/// The ramps of density/procedural.wgsl, by cloud type 0, 0.5, 1.
const RAMPS: [[f32; 4]; 3] = [
    [0.02, 0.05, 0.09, 0.11],
    [0.02, 0.20, 0.48, 0.625],
    [0.0, 0.0625, 0.45, 1.0],
];

impl WeatherBound {
    /// Largest height gradient over heights `low..high` and all types of the footprint.
    fn gradient_bound(&self, low: f32, high: f32) -> f32 {
        if high <= 0.0 || low >= 1.0 {
            return 0.0;
        }
        // Ramps are piecewise linear in type with a knot at 0.5: extremes are at the ends or at the knot.
        let mut ramp = [f32::INFINITY, f32::INFINITY, 0.0_f32, 0.0_f32];
        let mut include = |t: f32| {
            let r = ramp_at(t);
            ramp = [
                ramp[0].min(r[0]),
                ramp[1].min(r[1]),
                ramp[2].max(r[2]),
                ramp[3].max(r[3]),
            ];
        };
        include(self.type_low);
        include(self.type_high);
        if (self.type_low..=self.type_high).contains(&0.5) {
            include(0.5);
        }
        (smoothstep(ramp[0], ramp[1], high) * (1.0 - smoothstep(ramp[2], ramp[3], low)) + 1e-4)
            .min(1.0)
    }
}

fn ramp_at(cloud_type: f32) -> [f32; 4] {
    let lower = (2.0 * cloud_type).clamp(0.0, 1.0);
    let upper = (2.0 * cloud_type - 1.0).clamp(0.0, 1.0);
    std::array::from_fn(|i| {
        let low = RAMPS[0][i] + (RAMPS[1][i] - RAMPS[0][i]) * lower;
        low + (RAMPS[2][i] - low) * upper
    })
}

fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Largest (R − fbm + 1)/(2 − fbm) over each cell of the shape tile: it grows with R and falls with fbm (R ≤ 1), and
/// trilinear samples stay between the texels they are made of. A cell of 2 texels touches 4 along each axis.
fn billow_bounds(shape: &[u8]) -> Vec<f32> {
    let (n, cells) = (SHAPE_TEXELS as usize, CELLS_PER_TILE as usize);
    let mut bounds = vec![0.0; cells * cells * cells];
    for (i, bound) in bounds.iter_mut().enumerate() {
        let cell = [i % cells, i / cells % cells, i / cells / cells];
        let (mut most, mut least) = (0.0_f32, 1.0_f32);
        for dz in 0..4 {
            for dy in 0..4 {
                for dx in 0..4 {
                    let at = |axis: usize, d: usize| (2 * cell[axis] + d + n - 1) % n;
                    let texel = &shape[4 * ((at(2, dz) * n + at(1, dy)) * n + at(0, dx))..];
                    let channel = |c: usize| f32::from(texel[c]) / 255.0;
                    most = most.max(channel(0));
                    least = least.min(0.625 * channel(1) + 0.25 * channel(2) + 0.125 * channel(3));
                }
            }
        }
        *bound = (most - least + 1.0) / (2.0 - least);
    }
    bounds
}
