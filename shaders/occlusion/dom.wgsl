// Deep opacity map (DOM), n layers behind a column's front, 1 + n values: front z, optical depth τ_i at each layer's end.
//
//   e_i = z + s·i(i + 1)/2,  i = 0…n: layer i is i times as thick as the first
//   s = min(layer_m, L − z)/(n(n + 1)/2): the last layer ends layer_m behind the front, or with the texel's own column
//   τ(d) linear between τ_{i−1} at e_{i−1} and τ_i at e_i, τ_0 = 0, level behind e_n;  V = exp(−τ)
//
// Source: Yuksel & Keyser 2008, Deep Opacity Maps; sizes are free there, those of their talk grow as 1 : 2 : 3.
// Cost: one march; look-up ⌈(n + 1)/4⌉ fetches, the length of the texel's column, n interpolations.
#import map::{map, Tap, column_length, fetch}
#import column::{Column, sample_extinction, steps_before, store}
#import front::{front_in_step, over_depth}

struct Params {
    layer_m: f32,   // from the front to the end of the last layer
}

@group(2) @binding(1) var<uniform> params: Params;

const LAYERS: u32 = #{LAYERS}u;
const TEXTURE_LAYERS: u32 = #{TEXTURE_LAYERS}u;
const PADDED: u32 = #{PADDED}u;
// f16 holds 65504: between two infinite values a look-up would interpolate NaN, and exp(−6e4) is 0 anyway.
const LARGEST_TAU: f32 = 6e4;

// Thickness of the first layer over depth_m, behind a front in a column of length_m; above 0.
fn first_layer(front: f32, length_m: f32) -> f32 {
    let all = min(params.layer_m, length_m - front * map.depth_m) / max(map.depth_m, 1e-20);
    return max(all / (0.5 * f32(LAYERS * (LAYERS + 1u))), 1e-20);
}

var<private> marched: u32;      // steps whose depth is in `tau`
var<private> tau: f32;
var<private> sigma: f32;        // extinction of the last of them

// Steps to the column's front, over depth_m; 1 where there is none.
fn march_to_front(column: Column) -> f32 {
    while marched < map.steps {
        let before = tau;
        sigma = sample_extinction(column, marched);
        tau += sigma * column.step_m;
        marched += 1u;
        let front_m = front_in_step(column, marched - 1u, sigma, before);
        if front_m >= 0.0 {
            return over_depth(front_m);
        }
    }
    return 1.0;
}

// Optical depth before a depth, which is not in front of the step that was marched last.
fn march_to(column: Column, depth: f32) -> f32 {
    let x = clamp(steps_before(column, depth * map.depth_m), 0.0, f32(map.steps));
    while marched < map.steps && f32(marched) < x {
        sigma = sample_extinction(column, marched);
        tau += sigma * column.step_m;
        marched += 1u;
    }
    return tau - sigma * column.step_m * clamp(f32(marched) - x, 0.0, 1.0);
}

fn encode(column: Column) {
    var values: array<f32, PADDED>;
    let front = march_to_front(column);
    let first = first_layer(front, column.length_m);
    values[0] = front;
    for (var i = 1u; i <= LAYERS; i++) {
        // A column without a front holds next to nothing.
        let end = front + first * 0.5 * f32(i * (i + 1u));
        values[i] = select(0.0, min(march_to(column, end), LARGEST_TAU), front < 1.0);
    }
    for (var layer = 0u; layer < TEXTURE_LAYERS; layer++) {
        let i = 4u * layer;
        store(column, layer, vec4f(values[i], values[i + 1u], values[i + 2u], values[i + 3u]));
    }
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    var values: array<f32, PADDED>;
    for (var layer = 0u; layer < TEXTURE_LAYERS; layer++) {
        let stored = fetch(tap, layer);
        let i = 4u * layer;
        values[i] = stored.x;
        values[i + 1u] = stored.y;
        values[i + 2u] = stored.z;
        values[i + 3u] = stored.w;
    }
    let first = first_layer(values[0], column_length(tap));
    let behind = max(depth - values[0], 0.0) / first;
    var near = 0.0;
    var optical_depth = 0.0;
    for (var i = 1u; i <= LAYERS; i++) {
        let start = 0.5 * f32(i * (i - 1u));
        optical_depth += (values[i] - near) * saturate((behind - start) / f32(i));
        near = values[i];
    }
    return exp(-optical_depth);
}
