//! An imported volume in f64: samples at cell centres, clamped at the faces, trilinear in between.

use super::Grid;
use super::bounds::occupancy_of;
use crate::density::DensityTwin;
use crate::density::occupancy::Occupancy;
use glam::DVec3;

/// The grid and the box that it fills.
pub(super) struct Voxels {
    grid: Grid,
    corners: [[f64; 3]; 2],
    low_m: DVec3,
    size_m: DVec3,
}

impl Voxels {
    pub fn new(grid: Grid, corners: [[f64; 3]; 2]) -> Self {
        let [low_m, high_m] = corners.map(DVec3::from);
        Self {
            grid,
            corners,
            low_m,
            size_m: high_m - low_m,
        }
    }
}

impl DensityTwin for Voxels {
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

    fn occupancy(&self) -> Option<Occupancy> {
        Some(occupancy_of(&self.grid, self.corners))
    }

    fn content_hash(&self) -> String {
        self.grid.hash.to_string()
    }
}
