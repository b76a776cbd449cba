// March of one map column from the sun side, and the store of its values.
//
//   Δ = L/n over the column's own length L,  sample k at (k + ½)Δ, or at (k + 1)Δ when SAMPLING_END is defined
//   SAMPLING_QUADRATIC: at k(k + 1)/(n − 1)·Δ, but counted at kΔ: the misprint p = p + step·dir of thesis M, Algorithm 7
//
//   PLACEMENT_OCCUPIED: n equal steps over the parts of the column that may hold medium; between them none (spans.wgsl)
//
// Cost: one density sample a step.
#import map::{map, column_at, texel_uv}
#ifdef CASCADES
#import map::cascade
#endif
#import layer::{LayerRay, layer_length, point_at}
#import medium::{extinction}
#ifdef PLACEMENT_OCCUPIED
#import spans
#import spans::{mark_occupied, occupied_before, occupied_position}
#endif

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
    step_m: f32,          // of medium: with PLACEMENT_OCCUPIED less than length_m / n
#ifdef PLACEMENT_OCCUPIED
    occupied: u32,        // parts that may hold medium
#endif
}

fn column_of(texel: vec2u) -> Column {
#ifdef CASCADES
    cascade = texel.y / map.resolution;
#endif
    let ray = column_at(texel_uv(vec2i(texel)));
    let length_m = layer_length(ray);
#ifdef PLACEMENT_OCCUPIED
    let occupied = mark_occupied(ray, length_m, map.part_m);
    let step_m = length_m * (f32(occupied) / f32(spans::parts)) / f32(map.steps);
    return Column(texel, ray, length_m, step_m, occupied);
#else
    return Column(texel, ray, length_m, length_m / f32(map.steps));
#endif
}

// Depth after x steps, x in [0, n], metres inside the layer.
fn step_depth(column: Column, x: f32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    if column.occupied == 0u {
        return column.length_m;
    }
    let parts = x * f32(column.occupied) / f32(map.steps);
    return occupied_position(parts, column.occupied) * column.length_m / f32(spans::parts);
#else
    return x * column.step_m;
#endif
}

// The inverse: steps before a depth in metres.
fn steps_before(column: Column, depth_m: f32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    let parts = occupied_before(depth_m / max(column.length_m, 1e-20) * f32(spans::parts));
    return parts * f32(map.steps) / f32(max(column.occupied, 1u));
#else
    return depth_m / max(column.step_m, 1e-20);
#endif
}

// Depth at which sample k counts, metres inside the layer.
fn sample_depth(column: Column, k: u32) -> f32 {
#ifdef SAMPLING_END
    return step_depth(column, f32(k) + 1.0);
#else ifdef SAMPLING_QUADRATIC
    return step_depth(column, f32(k));
#else
    return step_depth(column, f32(k) + 0.5);
#endif
}

// Extinction of step k, m⁻¹.
fn sample_extinction(column: Column, k: u32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    if column.occupied == 0u {
        return 0.0;
    }
#endif
#ifdef SAMPLING_QUADRATIC
    let travelled = f32(k) * (f32(k) + 1.0) / max(f32(map.steps) - 1.0, 1.0);
    return extinction(point_at(column.ray, step_depth(column, travelled)));
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
