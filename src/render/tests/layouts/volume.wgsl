// Optical depth at equal distances in a 3-D texture: slice k of S at k/(S − 1) of L_max.
#import map::map
#import column::{Column, sample_extinction}
#import map_volume::{store_voxel, sample_volume}

const SLICES: u32 = #{SLICES}u;

fn encode(column: Column) {
    var before = 0.0;  // optical depth before step k
    var sigma = 0.0;   // of step k
    var k = 0u;
    for (var slice = 0u; slice < SLICES; slice++) {
        let depth_m = f32(slice) / f32(SLICES - 1u) * map.depth_m;
        while k < map.steps && f32(k) * column.step_m < depth_m {
            before += sigma * column.step_m;
            sigma = sample_extinction(column, k);
            k += 1u;
        }
        let within_m = clamp(depth_m - (f32(k) - 1.0) * column.step_m, 0.0, column.step_m);
        store_voxel(column, slice, vec4f(before + sigma * within_m));
    }
}

fn transmittance_at(uv: vec2f, depth: f32) -> f32 {
    var position = depth * f32(SLICES - 1u);
#ifdef CONTROL_ON
    position = floor(position);
#endif
    return exp(-sample_volume(uv, (position + 0.5) / f32(SLICES)).x);
}
