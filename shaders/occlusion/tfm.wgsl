// Transmittance function map (TFM), n cosine coefficients of T(d) a texel (+ 2 with per-texel bounds).
//
//   c_j = ∫ T(x) cos(jπx) dx over [0, 1],   x = d/depth_m or (d − front)/(back − front)
//   T(x) = c₀ + 2 Σ c_j cos(jπx), j = 1…n − 1, clamped to [0, 1]
//
// By parts, because sin(jπx) is 0 at both ends: with a_k = T_k(1 − e^(−σΔ)), the light that step k takes,
//   c_j = Σ a_k sin(jπx_k)/(jπ),   c₀ = 1 − Σ a_k(1 − x_k).
// So gaps between steps and the space behind the column, where T is constant, cost no sample, and an empty column is
// exactly 1. The map holds 1 − c₀, that 1 keeps its digits, and 2c_j: all between −1 and 1.
// BOUNDS_TEXEL: T = 1 in front of the interval.
//
// Harmonics by recurrence from the sine and cosine of πx − π/2: WGSL bounds their error only in [−π, π].
// Source: Delalandre et al. 2011, Transmittance Function Mapping, the Fourier representation of transmittance.
// Cost: look-up ⌈values/4⌉ fetches, n − 2 rotations; a column with texel bounds is marched twice.
#import map::{map, Tap, fetch}
#import bounds::column_bounds
#import column::{Column, sample_depth, sample_extinction, store}
#import numerics::one_minus_exp_neg

const COEFFICIENTS: u32 = #{COEFFICIENTS}u;
const LAYERS: u32 = #{LAYERS}u;
const PI: f32 = 3.1415927;

// (cos πx, sin πx), x in [0, 1]
fn half_rotation(x: f32) -> vec2f {
    let angle = PI * (x - 0.5);
    return vec2f(-sin(angle), cos(angle));
}

fn rotate(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// Depth as the series' variable, in [0, 1].
fn series_position(depth: f32, edges: vec2f) -> f32 {
#ifdef BOUNDS_TEXEL
    return saturate((depth - edges.x) / max(edges.y - edges.x, 1e-20));
#else
    return saturate(depth);
#endif
}

fn encode(column: Column) {
    let edges = column_bounds(column);
    var values: array<f32, #{PADDED}>;
    var light = 1.0;
    for (var k = 0u; k < map.steps; k++) {
        let thickness = sample_extinction(column, k) * column.step_m;
        if thickness <= 0.0 {
            continue;
        }
        let taken = light * one_minus_exp_neg(thickness);
        light *= exp(-thickness);
        let x = series_position(sample_depth(column, k) / max(map.depth_m, 1e-20), edges);
        let base = half_rotation(x);
        var harmonic = base;
        values[0] += taken * (1.0 - x);
        for (var j = 1u; j < COEFFICIENTS; j++) {
            values[j] += 2.0 * taken * harmonic.y / (PI * f32(j));
            harmonic = rotate(harmonic, base);
        }
    }
#ifdef BOUNDS_TEXEL
    values[COEFFICIENTS] = edges.x;
    values[COEFFICIENTS + 1u] = edges.y;
#endif
    for (var layer = 0u; layer < LAYERS; layer++) {
        let i = 4u * layer;
        store(column, layer, vec4f(values[i], values[i + 1u], values[i + 2u], values[i + 3u]));
    }
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    var values: array<f32, #{PADDED}>;
    for (var layer = 0u; layer < LAYERS; layer++) {
        let stored = fetch(tap, layer);
        let i = 4u * layer;
        values[i] = stored.x;
        values[i + 1u] = stored.y;
        values[i + 2u] = stored.z;
        values[i + 3u] = stored.w;
    }
#ifdef BOUNDS_TEXEL
    let edges = vec2f(values[COEFFICIENTS], values[COEFFICIENTS + 1u]);
    if depth <= edges.x {
        return 1.0;
    }
#else
    let edges = vec2f(0.0, 1.0);
#endif
    let base = half_rotation(series_position(depth, edges));
    var harmonic = base;
    var sum = 1.0 - values[0];
    for (var j = 1u; j < COEFFICIENTS; j++) {
        sum += values[j] * harmonic.x;
        harmonic = rotate(harmonic, base);
    }
    return saturate(sum);
}
