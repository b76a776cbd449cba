// A column's optical depth, read from the second level of the map, which a pass after the columns makes of the first.
#import map::{map, Tap, column_length, map_texture, map_sampler}
#import column::{Column, sample_extinction, store, store_texel}
#import method_pass::{in_tile, place}

fn encode(column: Column) {
    var tau = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        tau += sample_extinction(column, k) * column.step_m;
    }
    store(column, 0u, vec4f(tau));
}

@compute @workgroup_size(8, 8)
fn halve(@builtin(global_invocation_id) id: vec3u) {
    if !in_tile(id) {
        return;
    }
    let at = place(id);
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        sum += textureLoad(map_texture, 2u * at + vec2u(i % 2u, i / 2u), 0, 0);
    }
    store_texel(at, 0u, sum / 4.0);
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let tau = textureSampleLevel(map_texture, map_sampler, tap.uv, 0, 1.0).x;
    return exp(-tau * min(depth * map.depth_m / max(column_length(tap), 1e-20), 1.0));
}
