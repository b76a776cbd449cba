//! An imported volume on the device.

use super::bounds::occupancy_of;
use super::{Volume, load};
use crate::density::{Built, DeviceField};
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Inputs, Resource, UniformValue};

pub(super) fn build(gpu: &Gpu, field: &Volume, corners: [[f64; 3]; 2]) -> Result<DeviceField> {
    let grid = load(field)?;
    let limit = gpu.device.limits().max_texture_dimension_3d;
    if grid.size.iter().any(|n| *n > limit) {
        return Err(Error::input(
            field.path.display().to_string(),
            format!(
                "the volume is {:?} voxels, the adapter's limit is {limit} an axis",
                grid.size
            ),
            "Crop or downsample it, or use another adapter.",
        ));
    }
    let occupancy = occupancy_of(&grid, corners);
    let mut inputs = Inputs::default();
    let format = wgpu::TextureFormat::R32Float;
    let values = bytemuck::cast_slice(&grid.values);
    let volume = gpu.texture_3d("volume", format, grid.size, values);
    inputs.resource("volume", Resource::View(volume));
    let [low_m, high_m] = corners.map(|corner| UniformValue::Vec3(corner.map(|v| v as f32)));
    inputs.uniform("field", [("low_m", low_m), ("high_m", high_m)]);
    occupancy.upload(gpu, &mut inputs);
    gpu.check()?;
    Ok(DeviceField {
        built: Built {
            empty_fraction: Some(occupancy.empty_fraction()),
            cell_m: Some(occupancy.cell_m),
            ..Built::default()
        },
        content_hash: grid.hash.to_string(),
        ..DeviceField::new(field, inputs)
    })
}
