// A column's optical depth, the mean of 3 × 3 texels: two passes after the columns, through a texture that holds the rows.
#import map::{map, Tap, fetch, column_length, map_texture}
#import column::{Column, sample_extinction, store, store_texel}
#import method_pass::{in_tile, place}

@group(2) @binding(16) var rows: texture_2d_array<f32>;
@group(2) @binding(17) var rows_store: texture_storage_2d_array<r32float, write>;

fn encode(column: Column) {
    var tau = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        tau += sample_extinction(column, k) * column.step_m;
    }
    store(column, 0u, vec4f(tau));
}

fn inside(texel: vec2i) -> vec2i {
    return clamp(texel, vec2i(0), vec2i(i32(map.resolution) - 1));
}

@compute @workgroup_size(8, 8)
fn blur_rows(@builtin(global_invocation_id) id: vec3u) {
    if !in_tile(id) {
        return;
    }
    let at = vec2i(place(id));
    var sum = vec4f(0.0);
    for (var i = -1; i <= 1; i++) {
        sum += textureLoad(map_texture, inside(at + vec2i(i, 0)), 0, 0);
    }
    textureStore(rows_store, at, 0, sum / 3.0);
}

@compute @workgroup_size(8, 8)
fn blur_columns(@builtin(global_invocation_id) id: vec3u) {
    if !in_tile(id) {
        return;
    }
    let at = vec2i(place(id));
    var sum = vec4f(0.0);
    for (var i = -1; i <= 1; i++) {
        sum += textureLoad(rows, inside(at + vec2i(0, i)), 0, 0);
    }
    store_texel(vec2u(at), 0u, sum / 3.0);
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    return exp(-fetch(tap, 0u).x * min(depth * map.depth_m / max(column_length(tap), 1e-20), 1.0));
}
