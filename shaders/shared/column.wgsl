// March of one map column from the sun side, and the store of its values.
//
//   Δ = L/n over the column's own length L,  sample k at (k + ½)Δ, or at (k + 1)Δ when SAMPLING_END is defined
//   SAMPLING_QUADRATIC: at k(k + 1)/(n − 1)·Δ, but counted at kΔ: the misprint p = p + step·dir of thesis M, Algorithm 7
//
// Cost: one density sample a step.
#import map::{map, column_at}
#import layer::{LayerRay, layer_length, point_at}
#import medium::{extinction}

@group(2) @binding(4) var map_store: texture_storage_2d_array<
#ifdef TEXEL_R16
    r16float,
#else ifdef TEXEL_R32
    r32float,
#else ifdef TEXEL_RGBA32
    rgba32float,
#else ifdef TEXEL_R8UNORM
    r8unorm,
#else ifdef TEXEL_RG8UNORM
    rg8unorm,
#else ifdef TEXEL_RGBA8UNORM
    rgba8unorm,
#else ifdef TEXEL_R16UNORM
    r16unorm,
#else ifdef TEXEL_RG16UNORM
    rg16unorm,
#else ifdef TEXEL_RGBA16UNORM
    rgba16unorm,
#else
    rgba16float,
#endif
    write>;

struct Column {
    texel: vec2u,
    ray: LayerRay,
    length_m: f32,
    step_m: f32,
}

fn column_of(texel: vec2u) -> Column {
    let ray = column_at((vec2f(texel) + 0.5) / f32(map.resolution));
    let length_m = layer_length(ray);
    return Column(texel, ray, length_m, length_m / f32(map.steps));
}

// Depth at which sample k counts, metres inside the layer.
fn sample_depth(column: Column, k: u32) -> f32 {
#ifdef SAMPLING_END
    return (f32(k) + 1.0) * column.step_m;
#else ifdef SAMPLING_QUADRATIC
    return f32(k) * column.step_m;
#else
    return (f32(k) + 0.5) * column.step_m;
#endif
}

// Extinction of step k, m⁻¹.
fn sample_extinction(column: Column, k: u32) -> f32 {
#ifdef SAMPLING_QUADRATIC
    let travelled = f32(k) * (f32(k) + 1.0) / max(f32(map.steps) - 1.0, 1.0) * column.step_m;
    return extinction(point_at(column.ray, travelled));
#else
    return extinction(point_at(column.ray, sample_depth(column, k)));
#endif
}

fn store(column: Column, layer: u32, values: vec4f) {
    store_texel(column.texel, layer, values);
}

// For passes after the column pass.
fn store_texel(texel: vec2u, layer: u32, values: vec4f) {
    textureStore(map_store, texel, layer, values);
}
