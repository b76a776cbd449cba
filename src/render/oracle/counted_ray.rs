//! Extinction along a light ray through a scene, with a counter of density samples.

use super::field::OracleField;
use super::layer::LayerRay;
use crate::occlusion::twin::LightRay;
use std::cell::Cell;

/// A light ray through the medium that counts its samples.
pub(super) struct CountedRay<'a> {
    pub field: &'a OracleField,
    /// Skip provably empty space.
    pub skip: bool,
    pub ray: LayerRay,
    /// Density samples taken.
    pub samples: &'a Cell<u64>,
}

/// Counts one sample.
pub(super) fn count(cell: &Cell<u64>) {
    cell.set(cell.get() + 1);
}

impl LightRay for CountedRay<'_> {
    fn length_m(&self) -> f64 {
        self.ray.length_m()
    }

    fn extinction_per_m(&self, s_m: f64) -> f64 {
        let p = self.ray.point(s_m);
        if self.skip && self.field.clear_m(p).is_some() {
            return 0.0;
        }
        count(self.samples);
        self.field.extinction_per_m(p)
    }

    fn empty_m(&self, s_m: f64) -> Option<f64> {
        let empty_m = self.field.empty_m(self.ray.point(s_m))?;
        Some(empty_m.min(self.ray.distance_to_gap_m(s_m)))
    }

    fn clear_m(&self, s_m: f64) -> Option<f64> {
        if !self.skip {
            return None;
        }
        let clear_m = self.field.clear_m(self.ray.point(s_m))?;
        Some(clear_m.min(self.ray.before_gap_m(s_m)))
    }
}
