//! The density field in f64: uniform, procedural, or an imported volume.

use super::layer::field_point;
use super::procedural::Clouds;
use super::texture::Filter;
use crate::density::imported::occupancy_of;
use crate::density::occupancy::Occupancy;
use crate::density::volume::{Grid, load};
use crate::error::{Error, Result};
use crate::scene::{Container, Density, Scene};
use glam::DVec3;

/// Points are good to much less than this share of an occupancy cell.
const CELL_SLACK: f64 = 1e-9;

/// Density and extinction of a scene.
pub(super) struct Field {
    container: Container,
    extinction_per_m: f64,
    kind: Kind,
    occupancy: Option<Occupancy>,
    filter: Filter,
}

enum Kind {
    Uniform(f64),
    Clouds(Box<Clouds>),
    Volume(Box<Volume>),
}

impl Field {
    pub fn new(scene: &Scene, filter: Filter) -> Result<Self> {
        let extinction_per_m = scene.medium.extinction_per_m;
        let (kind, occupancy) = match &scene.density {
            Density::Uniform { value } => (Kind::Uniform(*value), None),
            Density::Procedural(field) => {
                let clouds = Clouds::new(field, extinction_per_m, filter)?;
                let occupancy = clouds.occupancy();
                (Kind::Clouds(Box::new(clouds)), Some(occupancy))
            }
            Density::Volume(volume) => {
                let Container::Box { min_m, max_m } = scene.container else {
                    return Err(Error::input(
                        "scene",
                        "a volume needs a box container",
                        "Use a `box` container.",
                    ));
                };
                let grid = load(volume)?;
                let occupancy = occupancy_of(&grid, min_m, max_m);
                let volume = Volume {
                    grid,
                    low_m: min_m.into(),
                    size_m: DVec3::from(max_m) - DVec3::from(min_m),
                };
                (Kind::Volume(Box::new(volume)), Some(occupancy))
            }
        };
        Ok(Self {
            container: scene.container.clone(),
            extinction_per_m,
            kind,
            occupancy,
            filter,
        })
    }

    /// How its textures are filtered.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Identifies imported data; empty for fields that the scene's JSON determines.
    pub fn content_hash(&self) -> String {
        match &self.kind {
            Kind::Volume(volume) => volume.grid.hash.to_string(),
            _ => String::new(),
        }
    }

    /// Weather thresholds of a procedural field's decks; empty for others.
    pub fn thresholds(&self) -> &[f64] {
        match &self.kind {
            Kind::Clouds(clouds) => clouds.thresholds(),
            _ => &[],
        }
    }

    /// Extinction at a point, m⁻¹.
    pub fn extinction_per_m(&self, p: DVec3) -> f64 {
        let density = match &self.kind {
            Kind::Uniform(value) => *value,
            Kind::Clouds(clouds) => clouds.density(field_point(&self.container, p)),
            Kind::Volume(volume) => volume.density(p),
        };
        density * self.extinction_per_m
    }

    /// Distance within which extinction is provably 0 around `p`, metres; `None` = it may not be.
    pub fn clear_m(&self, p: DVec3) -> Option<f64> {
        let grid = self.occupancy.as_ref()?;
        let cell = (field_point(&self.container, p) - DVec3::from(grid.origin_m)) / grid.cell_m;
        let base = cell.floor();
        let mut index = [0; 3];
        for (axis, index) in index.iter_mut().enumerate() {
            let n = grid.size[axis] as i64;
            let mut i = base[axis] as i64;
            if grid.wrap && axis != 1 {
                i = i.rem_euclid(n);
            }
            if !(0..n).contains(&i) {
                return None;
            }
            *index = i as usize;
        }
        let [x, y, z] = index;
        let rings = grid.rings[(z * grid.size[1] + y) * grid.size[0] + x];
        let to_face = (cell - base).min(DVec3::ONE - (cell - base)).min_element();
        // A height changes no faster than the way to it, so that field distances bound ways.
        (rings > 0).then(|| (f64::from(rings - 1) + to_face - CELL_SLACK).max(0.0) * grid.cell_m)
    }
}

/// Samples at cell centres, clamped at the faces, trilinear in between.
struct Volume {
    grid: Grid,
    low_m: DVec3,
    size_m: DVec3,
}

impl Volume {
    fn density(&self, p: DVec3) -> f64 {
        let unit = (p - self.low_m) / self.size_m;
        let n = self.grid.size.map(|n| n as usize);
        let mut taps = [[(0, 0.0); 2]; 3];
        for (axis, pair) in taps.iter_mut().enumerate() {
            let last = n[axis] as i64 - 1;
            let position = unit[axis] * n[axis] as f64 - 0.5;
            let low = position.floor();
            let weight = position - low;
            let clamped = |i: i64| i.clamp(0, last) as usize;
            *pair = [
                (clamped(low as i64), 1.0 - weight),
                (clamped(low as i64 + 1), weight),
            ];
        }
        let [xs, ys, zs] = taps;
        let mut sum = 0.0;
        for (k, wz) in zs {
            for (j, wy) in ys {
                let row = (k * n[1] + j) * n[0];
                for (i, wx) in xs {
                    sum += wx * wy * wz * f64::from(self.grid.values[row + i]);
                }
            }
        }
        sum
    }
}
