//! An imported volume on the device.

use super::occupancy::Occupancy;
use super::volume::{Grid, load};
use super::{Built, DensityField};
use crate::error::{Error, Result};
use crate::gpu::{Defs, Gpu, Inputs, Resource, UniformValue};
use crate::scene::{Container, Scene, Volume};

/// Cells of the occupancy grid are at least this many voxels wide: smaller ones cost more than they skip.
const CELL_VOXELS: f64 = 2.0;
/// Most cells along the longest axis.
const MAX_CELLS: f64 = 256.0;

pub(super) fn build(gpu: &Gpu, scene: &Scene, volume: &Volume) -> Result<DensityField> {
    let grid = load(volume)?;
    let limit = gpu.device.limits().max_texture_dimension_3d;
    if grid.size.iter().any(|n| *n > limit) {
        return Err(Error::input(
            volume.path.display().to_string(),
            format!(
                "the volume is {:?} voxels, the adapter's limit is {limit} an axis",
                grid.size
            ),
            "Crop or downsample it, or use another adapter.",
        ));
    }
    let Container::Box { min_m, max_m } = scene.container else {
        return Err(Error::input(
            "scene",
            "a volume needs a box container",
            "Use a `box` container.",
        ));
    };
    let occupancy = occupancy_of(&grid, min_m, max_m);
    let mut inputs = Inputs::default();
    let format = wgpu::TextureFormat::R32Float;
    let values = bytemuck::cast_slice(&grid.values);
    let volume = gpu.texture_3d("volume", format, grid.size, values);
    inputs.resource("volume", Resource::View(volume));
    inputs.uniform(
        "field",
        [
            ("low_m", UniformValue::Vec3(min_m.map(|v| v as f32))),
            ("high_m", UniformValue::Vec3(max_m.map(|v| v as f32))),
        ],
    );
    occupancy.upload(gpu, &mut inputs);
    gpu.check()?;
    Ok(DensityField {
        shader: "density/volume.wgsl",
        defs: Defs::new(),
        inputs,
        built: Built {
            empty_fraction: Some(occupancy.empty_fraction()),
            ..Built::default()
        },
        content_hash: grid.hash.to_string(),
    })
}

/// A cell is occupied when any voxel that its samples may touch is: trilinear support plus a guard for rounding.
pub(crate) fn occupancy_of(grid: &Grid, min_m: [f64; 3], max_m: [f64; 3]) -> Occupancy {
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
