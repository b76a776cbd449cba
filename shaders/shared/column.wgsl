// March of one map column from the sun side, and the store of its values.
//
//   Δ = L/n over the column's own length L,  sample k at (k + ½)Δ, or at (k + 1)Δ when SAMPLING_END is defined
//   SAMPLING_QUADRATIC: at k(k + 1)/(n − 1)·Δ, but counted at kΔ: the misprint p = p + step·dir of thesis M, Algorithm 7
//
//   PLACEMENT_OCCUPIED: at most n equal steps over the spans of the column that may hold medium; between them none, and none
//   shorter than shortest_step_m (spans.wgsl)
//   COLUMN_END_DARK: no sample behind the depth where T has fallen below 2⁻⁸; σ is 0 there for every method
//
// Steps are asked for in growing order; a second march begins with step 0 again.
// Cost: one density sample a step.
#import map::{map, column_at, texel_uv}
#ifdef CASCADES
#import map::cascade
#endif
#import layer::{LayerRay, layer_length, point_at}
#import medium::{extinction}
#ifdef PLACEMENT_OCCUPIED
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
    occupied_m: f32,      // length of the spans that may hold medium
    taken: u32,           // steps in them, at most map.steps
#endif
}

fn column_of(texel: vec2u) -> Column {
#ifdef CASCADES
    cascade = texel.y / map.resolution;
#endif
    let ray = column_at(texel_uv(vec2i(texel)));
    let length_m = layer_length(ray);
#ifdef PLACEMENT_OCCUPIED
    let occupied_m = mark_occupied(ray, length_m, map.part_m);
    if occupied_m <= 0.0 {
        return Column(texel, ray, length_m, 0.0, 0.0, 0u);
    }
    // A little less than the quotient: rounding must not decide where the steps fill it exactly.
    let most = ceil(occupied_m / max(map.shortest_step_m, 1e-20) - 1e-3);
    let taken = clamp(most, 1.0, f32(map.steps));
    return Column(texel, ray, length_m, occupied_m / taken, occupied_m, u32(taken));
#else
    return Column(texel, ray, length_m, length_m / f32(map.steps));
#endif
}

// Depth after x steps, x in [0, n], metres inside the layer.
fn step_depth(column: Column, x: f32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    if column.taken == 0u {
        return column.length_m;
    }
    return occupied_position(x * column.step_m);
#else
    return x * column.step_m;
#endif
}

// The inverse: steps before a depth in metres.
fn steps_before(column: Column, depth_m: f32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    return occupied_before(depth_m, column.occupied_m) / max(column.step_m, 1e-20);
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

#ifdef COLUMN_END_DARK
const DARK_TAU: f32 = 5.5451774;    // 8 ln 2
var<private> passed_tau: f32;       // of the steps sampled so far
#endif

// Extinction of step k, m⁻¹.
fn sample_extinction(column: Column, k: u32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    if k >= column.taken {
        return 0.0;
    }
#endif
#ifdef COLUMN_END_DARK
    if k == 0u {
        passed_tau = 0.0;
    }
    if passed_tau > DARK_TAU {
        return 0.0;
    }
    let sigma = extinction_of_step(column, k);
    passed_tau += sigma * column.step_m;
    return sigma;
#else
    return extinction_of_step(column, k);
#endif
}

fn extinction_of_step(column: Column, k: u32) -> f32 {
#ifdef SAMPLING_QUADRATIC
#ifdef PLACEMENT_OCCUPIED
    let steps = column.taken;
#else
    let steps = map.steps;
#endif
    let travelled = f32(k) * (f32(k) + 1.0) / max(f32(steps) - 1.0, 1.0);
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
