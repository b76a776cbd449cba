//! Uniform of a light map's placement.

use crate::gpu::UniformValue;
use crate::scene::MapRectangle;

/// Members of `Map` in shared/map.wgsl.
pub(super) fn map_uniform(
    rectangle: &MapRectangle,
    resolution: u32,
    steps: u32,
) -> Vec<(&'static str, UniformValue)> {
    vec![
        (
            "u_axis",
            UniformValue::Vec3(rectangle.u_axis.as_vec3().into()),
        ),
        (
            "v_axis",
            UniformValue::Vec3(rectangle.v_axis.as_vec3().into()),
        ),
        (
            "origin_m",
            UniformValue::Vec2(rectangle.origin_m.map(|v| v as f32)),
        ),
        ("extent_m", UniformValue::F32(rectangle.extent_m as f32)),
        ("depth_m", UniformValue::F32(rectangle.depth_m as f32)),
        ("resolution", UniformValue::U32(resolution)),
        ("steps", UniformValue::U32(steps)),
    ]
}
