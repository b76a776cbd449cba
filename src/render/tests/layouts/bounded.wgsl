// A column's optical depth as a fraction of the largest of its tile of 8 × 8 texels, found by a pass before.
#import map::{map, Tap, fetch, column_length}
#import column::{Column, column_of, sample_extinction, store}
#import method_pass::{in_tile, place, count_samples}

@group(2) @binding(16) var<storage, read> tile_bounds: array<f32>;
@group(2) @binding(17) var<storage, read_write> tile_bounds_store: array<f32>;
var<workgroup> depths: array<f32, 64>;

fn optical_depth(column: Column) -> f32 {
    var tau = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        tau += sample_extinction(column, k) * column.step_m;
    }
    return tau;
}

fn tile_of(texel: vec2u) -> u32 {
    return texel.y / 8u * ((map.resolution + 7u) / 8u) + texel.x / 8u;
}

@compute @workgroup_size(8, 8)
fn bound_tile(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
    let texel = place(id);
    depths[index] = 0.0;
    if in_tile(id) {
        depths[index] = optical_depth(column_of(texel));
        count_samples(texel, map.resolution);
    }
    workgroupBarrier();
    if index == 0u {
        var most = 0.0;
        for (var i = 0u; i < 64u; i++) {
            most = max(most, depths[i]);
        }
        tile_bounds_store[tile_of(texel)] = most;
    }
}

fn encode(column: Column) {
    let share = optical_depth(column) / max(tile_bounds[tile_of(column.texel)], 1e-20);
    store(column, 0u, vec4f(share));
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let tau = fetch(tap, 0u).x * tile_bounds[tile_of(vec2u(tap.texel))];
    return exp(-tau * min(depth * map.depth_m / max(column_length(tap), 1e-20), 1.0));
}
