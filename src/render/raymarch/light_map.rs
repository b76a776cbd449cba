//! Uniform and warp table of a light map's placement.

use super::map_storage::MapStorage;
use crate::error::Result;
use crate::gpu::{Gpu, Inputs, Resource, UniformValue};
use crate::occlusion::MethodSetup;
use crate::occlusion::plan::WARP_BYTES;
use crate::occlusion::spans::Grain;
use crate::scene::{MapRectangle, MapWarp};

/// Offers the geometry of a map to its passes and to the view march. `cell_m` is the edge of the cells of the grid of empty
/// space.
pub(super) fn offer_geometry(
    gpu: &Gpu,
    rectangle: &MapRectangle,
    storage: &MapStorage,
    setup: &MethodSetup,
    cell_m: Option<f64>,
    inputs: &mut Inputs,
) -> Result<()> {
    let mut members = map_uniform(rectangle, storage.resolution, setup)?;
    let Grain { part_m, step_m } = Grain::new(cell_m, rectangle.depth_m);
    members.push(("part_m", UniformValue::F32(part_m as f32)));
    members.push(("shortest_step_m", UniformValue::F32(step_m as f32)));
    inputs.uniform("map", members);
    if let Some(warp) = &rectangle.warp {
        let buffer = gpu.buffer("warp", &warp_table(warp), wgpu::BufferUsages::STORAGE);
        inputs.resource("map_warp", Resource::Buffer(buffer));
    }
    Ok(())
}

/// Members of `Map` in shared/map.wgsl.
fn map_uniform(
    rectangle: &MapRectangle,
    resolution: u32,
    setup: &MethodSetup,
) -> Result<Vec<(&'static str, UniformValue)>> {
    let vec2 = |v: [f64; 2]| UniformValue::Vec2(v.map(|v| v as f32));
    let vec3 = |v: glam::DVec3| UniformValue::Vec3(v.as_vec3().into());
    let params = &setup.params;
    Ok(vec![
        ("u_axis", vec3(rectangle.u_axis)),
        ("v_axis", vec3(rectangle.v_axis)),
        ("origin_m", vec2(rectangle.origin_m)),
        ("extent_m", vec2(rectangle.extent_m)),
        ("depth_m", UniformValue::F32(rectangle.depth_m as f32)),
        ("resolution", UniformValue::U32(resolution)),
        ("steps", UniformValue::U32(params.int("steps")?)),
        ("near_steps", UniformValue::U32(params.int("near_steps")?)),
        ("near_m", UniformValue::F32(params.number("near_m")? as f32)),
    ])
}

/// Knots of both axes side by side, f32.
fn warp_table(warp: &MapWarp) -> Vec<u8> {
    let [u, v] = &warp.knots;
    let pairs = u.iter().zip(v).flat_map(|(u, v)| [*u as f32, *v as f32]);
    let bytes: Vec<u8> = pairs.flat_map(f32::to_le_bytes).collect();
    debug_assert_eq!(bytes.len() as u64, WARP_BYTES);
    bytes
}
