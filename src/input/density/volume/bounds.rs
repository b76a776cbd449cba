//! Occupancy grid of an imported volume: its provably empty cells.

use super::Grid;
use crate::density::occupancy::Occupancy;

/// Cells of the occupancy grid are at least this many voxels wide: smaller ones cost more than they skip.
const CELL_VOXELS: f64 = 2.0;
/// Most cells along the longest axis.
const MAX_CELLS: f64 = 256.0;

/// A cell is occupied when any voxel that its samples may touch is: trilinear support plus a guard for rounding.
pub(super) fn occupancy_of(grid: &Grid, [min_m, max_m]: [[f64; 3]; 2]) -> Occupancy {
    let n = grid.size.map(|v| v as usize);
    let voxel_m: [f64; 3] = std::array::from_fn(|i| (max_m[i] - min_m[i]) / n[i] as f64);
    let longest_m = (0..3).map(|i| max_m[i] - min_m[i]).fold(0.0, f64::max);
    let cell_m = (CELL_VOXELS * voxel_m.into_iter().fold(0.0, f64::max)).max(longest_m / MAX_CELLS);
    let size = std::array::from_fn(|i| ((max_m[i] - min_m[i]) / cell_m).ceil().max(1.0) as usize);
    let touched = |axis: usize, cell: usize| {
        let texel = |edge: f64| edge * cell_m / voxel_m[axis] - 0.5;
        let last = n[axis] as i64 - 1;
        let low = (texel(cell as f64 - 0.01).floor() as i64).clamp(0, last);
        let high = (texel(cell as f64 + 1.01).floor() as i64 + 1).clamp(0, last);
        low as usize..=high as usize
    };
    Occupancy::new(size, false, min_m, cell_m, |x, y, z| {
        touched(2, z).any(|k| {
            touched(1, y).any(|j| {
                let row = (k * n[1] + j) * n[0];
                touched(0, x).any(|i| grid.values[row + i] > 0.0)
            })
        })
    })
}
