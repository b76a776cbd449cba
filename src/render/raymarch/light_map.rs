//! Uniform and warp table of a light map's placement.

use crate::error::Result;
use crate::gpu::{Gpu, Inputs, Resource, UniformValue};
use crate::occlusion::MethodSetup;
use crate::occlusion::plan::WARP_BYTES;
use crate::occlusion::spans::Grain;
use crate::scene::{MapCascades, MapRectangle, MapWarp, Scene};
use glam::DVec3;

/// Offers the geometry of a map of `scene` to its passes and to the view march. `cell_m` is the edge of the cells of the
/// grid of empty space.
pub(super) fn offer_geometry(
    gpu: &Gpu,
    cascades: &MapCascades,
    setup: &MethodSetup,
    scene: &Scene,
    cell_m: Option<f64>,
    inputs: &mut Inputs,
) -> Result<()> {
    // The last rectangle is the whole one.
    let rectangles = cascades.rectangles();
    let whole = &rectangles[rectangles.len() - 1];
    let mut members = map_uniform(whole, setup, scene)?;
    let Grain { part_m, step_m } = Grain::new(cell_m, cascades.depth_m());
    members.push(("part_m", UniformValue::F32(part_m as f32)));
    members.push(("shortest_step_m", UniformValue::F32(step_m as f32)));
    inputs.uniform("map", members);
    let warps = rectangles.iter().filter_map(|r| r.warp.as_ref());
    let tables: Vec<u8> = warps.flat_map(warp_table).collect();
    if !tables.is_empty() {
        let buffer = gpu.buffer("warp", &tables, wgpu::BufferUsages::STORAGE);
        inputs.resource("map_warp", Resource::Buffer(buffer));
    }
    if rectangles.len() > 1 {
        let table = cascade_table(cascades);
        let buffer = gpu.buffer("cascades", &table, wgpu::BufferUsages::STORAGE);
        inputs.resource("map_cascades", Resource::Buffer(buffer));
    }
    Ok(())
}

/// Members of `Map` in shared/map.wgsl.
fn map_uniform(
    rectangle: &MapRectangle,
    setup: &MethodSetup,
    scene: &Scene,
) -> Result<Vec<(&'static str, UniformValue)>> {
    let vec2 = |v: [f64; 2]| UniformValue::Vec2(v.map(|v| v as f32));
    let vec3 = |v: DVec3| UniformValue::Vec3(v.as_vec3().into());
    let params = &setup.params;
    Ok(vec![
        ("u_axis", vec3(rectangle.u_axis)),
        ("v_axis", vec3(rectangle.v_axis)),
        ("origin_m", vec2(rectangle.origin_m)),
        ("extent_m", vec2(rectangle.extent_m)),
        ("depth_m", UniformValue::F32(rectangle.depth_m as f32)),
        ("resolution", UniformValue::U32(params.int("resolution")?)),
        ("steps", UniformValue::U32(params.int("steps")?)),
        ("near_steps", UniformValue::U32(params.int("near_steps")?)),
        ("near_m", UniformValue::F32(params.number("near_m")? as f32)),
        ("camera_m", vec3(scene.camera.position_m.into())),
        ("sun_direction", vec3(scene.sun.direction())),
    ])
}

/// `Cascade`s of shared/map.wgsl: origin, extent, reach and 4 bytes of padding.
fn cascade_table(cascades: &MapCascades) -> Vec<u8> {
    let rectangles = cascades.rectangles().iter().zip(cascades.reaches_m());
    let members = rectangles.flat_map(|(r, reach_m)| {
        let [u_m, v_m] = r.origin_m;
        let [width_m, height_m] = r.extent_m;
        [u_m, v_m, width_m, height_m, reach_m.min(1e30), 0.0]
    });
    members.flat_map(|m| (m as f32).to_le_bytes()).collect()
}

/// Knots of both axes side by side, f32.
fn warp_table(warp: &MapWarp) -> Vec<u8> {
    let [u, v] = &warp.knots;
    let pairs = u.iter().zip(v).flat_map(|(u, v)| [*u as f32, *v as f32]);
    let bytes: Vec<u8> = pairs.flat_map(f32::to_le_bytes).collect();
    debug_assert_eq!(bytes.len() as u64, WARP_BYTES);
    bytes
}
