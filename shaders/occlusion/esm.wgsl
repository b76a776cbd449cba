// Exponential shadow map (ESM), one value a texel.
//
//   stable     stores z, the front: where the column's transmittance first falls below 0.99, or its first medium (front.wgsl);
//              V = exp(−c·max(0, d − z))
//   published  stores f = exp(c z);  V = clamp(f·exp(−c d), 0, 1)   overflows f16 at c z ≥ 11.09, f32 at 88.7
//
// BLUR, radius r = blur_texels: the mean of f = exp(c z) over the (2r + 1)² texels around each, clamped to the map's edge, as
// the filter of the source before look-ups; rows first, then columns.
//   stable: ẑ = ln(mean exp(c z))/c, taken as M + ln(mean exp(c (z − M)))/c with M the largest z of them: the same V, and
//   nothing overflows. One texel without a front, z = 1, outweighs all around it: light leaks at the edges of clouds.
//
// z, d over depth_m. Sources: Annen et al. 2008; thesis M, Algorithms 3 and 4.
// Cost: look-up one exponential; a blur 2(2r + 1) fetches a texel, twice with its exponentials, and a second map meanwhile.
#import map::{map, Tap, fetch, map_texture}
#import column::{Column, store, store_texel}
#import front::front_depth
#ifdef BLUR
#import method_pass::{in_tile, place}
#endif

struct Params {
    c: f32,
    blur_texels: u32,   // r
}

@group(2) @binding(1) var<uniform> params: Params;

fn encode(column: Column) {
    let z = front_depth(column);
#ifdef FORM_PUBLISHED
    store(column, 0u, vec4f(exp(params.c * z)));
#else
    store(column, 0u, vec4f(z));
#endif
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let stored = fetch(tap, 0u).x;
#ifdef FORM_PUBLISHED
    return clamp(stored * exp(-params.c * depth), 0.0, 1.0);
#else
    return exp(-params.c * max(0.0, depth - stored));
#endif
}

#ifdef BLUR
@group(2) @binding(16) var rows: texture_2d_array<f32>;
@group(2) @binding(17) var rows_store: texture_storage_2d_array<r32float, write>;

// A texel beside `at`, clamped to the edges of its rectangle.
fn beside(at: vec2i, offset: vec2i) -> vec2i {
    let edge = i32(map.resolution);
    let first = vec2i(0, at.y / edge * edge);
    return clamp(at + offset, first, first + edge - 1);
}

// Mean over the texels from −r to r along `axis`.
fn mean_along(source: texture_2d_array<f32>, at: vec2i, axis: vec2i) -> f32 {
    let r = i32(params.blur_texels);
    let n = f32(2 * r + 1);
    var sum = 0.0;
#ifdef FORM_PUBLISHED
    for (var i = -r; i <= r; i++) {
        sum += textureLoad(source, beside(at, i * axis), 0, 0).x;
    }
    return sum / n;
#else
    var most = 0.0;
    for (var i = -r; i <= r; i++) {
        most = max(most, textureLoad(source, beside(at, i * axis), 0, 0).x);
    }
    for (var i = -r; i <= r; i++) {
        sum += exp(params.c * (textureLoad(source, beside(at, i * axis), 0, 0).x - most));
    }
    return max(most + log(sum / n) / params.c, 0.0);
#endif
}

@compute @workgroup_size(8, 8)
fn blur_rows(@builtin(global_invocation_id) id: vec3u) {
    if !in_tile(id) {
        return;
    }
    let at = vec2i(place(id));
    textureStore(rows_store, at, 0, vec4f(mean_along(map_texture, at, vec2i(1, 0))));
}

@compute @workgroup_size(8, 8)
fn blur_columns(@builtin(global_invocation_id) id: vec3u) {
    if !in_tile(id) {
        return;
    }
    let at = vec2i(place(id));
    store_texel(vec2u(at), 0u, vec4f(mean_along(rows, at, vec2i(0, 1))));
}
#endif
