// Fourier opacity map (FOM), 2n + 1 values a texel (+ 2 with per-texel bounds).
//
//   a₀ = 2Σσ Δs,  a_k = 2Σσ cos(2πk x) Δs,  b_k = 2Σσ sin(2πk x) Δs,  x = d/depth_m or (d − front)/(back − front)
//   τ(x) = a₀x/2 + Σ_k w_k [a_k sin 2πkx + b_k (1 − cos 2πkx)]/(2πk),   V = exp(−max(0, τ))
//   published: accumulates −2 ln(1 − α), α = 1 − exp(−σΔs), in place of 2σΔs: the same number until α rounds to 1 (τ ≈ 17.3)
//   SINES_FIRST: b₁ in place of every b_k;  STEP_LENGTH_METRE: Δs = 1 m: misprints of thesis M, Algorithms 8 and 7
//   window w_k: none 1 | lanczos sinc(k/(n+1)) | fejer 1 − k/(n+1), which makes τ monotone
//
// Harmonics by recurrence from one sine and cosine of the reduced angle 2π·fract(x) − π: WGSL promises 2⁻¹¹ only there.
// Source: Jansen & Bavoil 2010, eqs. 6–9; thesis M, Algorithms 7 and 8. Cost: look-up ⌈values/4⌉ fetches, n rotations.
#import map::{map, Tap, fetch}
#import bounds::column_bounds
#import column::{Column, sample_depth, sample_extinction, store}

const ORDER: u32 = #{ORDER}u;
const LAYERS: u32 = #{LAYERS}u;
const TWO_PI: f32 = 6.2831853;

// (cos 2πx, sin 2πx)
fn unit_rotation(x: f32) -> vec2f {
    let angle = TWO_PI * (fract(x) - 0.5);
    return -vec2f(cos(angle), sin(angle));
}

fn rotate(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

fn optical_thickness(sigma: f32, step_m: f32) -> f32 {
#ifdef FORM_PUBLISHED
    let alpha = 1.0 - exp(-sigma * step_m);
    return -log(1.0 - alpha);
#else
    return sigma * step_m;
#endif
}

// Depth as the series' variable, in [0, 1].
fn series_position(depth: f32, front: f32, back: f32) -> f32 {
#ifdef BOUNDS_TEXEL
    return saturate((depth - front) / max(back - front, 1e-20));
#else
    return saturate(depth);
#endif
}

fn encode(column: Column) {
    let edges = column_bounds(column);
    var values: array<f32, #{PADDED}>;
    for (var k = 0u; k < map.steps; k++) {
        let sigma = sample_extinction(column, k);
        if sigma <= 0.0 {
            continue;
        }
#ifdef STEP_LENGTH_METRE
        let thickness = 2.0 * optical_thickness(sigma, 1.0);
#else
        let thickness = 2.0 * optical_thickness(sigma, column.step_m);
#endif
        let base = unit_rotation(series_position(sample_depth(column, k) / map.depth_m, edges.x, edges.y));
        var harmonic = base;
        values[0] += thickness;
        for (var i = 1u; i <= ORDER; i++) {
            values[2u * i - 1u] += thickness * harmonic.x;
            values[2u * i] += thickness * harmonic.y;
            harmonic = rotate(harmonic, base);
        }
    }
#ifndef FORM_PUBLISHED
    // |a_k|, |b_k| ≤ a₀: one factor keeps all of them inside f16, where V is 0 anyway.
    let scale = min(1.0, 6e4 / max(values[0], 1e-20));
    for (var i = 0u; i <= 2u * ORDER; i++) {
        values[i] *= scale;
    }
#endif
#ifdef BOUNDS_TEXEL
    values[2u * ORDER + 1u] = edges.x;
    values[2u * ORDER + 2u] = edges.y;
#endif
    for (var layer = 0u; layer < LAYERS; layer++) {
        let i = 4u * layer;
        store(column, layer, vec4f(values[i], values[i + 1u], values[i + 2u], values[i + 3u]));
    }
}

fn window(k: u32) -> f32 {
    let x = f32(k) / (f32(ORDER) + 1.0);
#ifdef WINDOW_FEJER
    return 1.0 - x;
#else ifdef WINDOW_LANCZOS
    return sin(0.5 * TWO_PI * x) / (0.5 * TWO_PI * x);
#else
    return 1.0;
#endif
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
    let x = series_position(depth, values[2u * ORDER + 1u], values[2u * ORDER + 2u]);
#else
    let x = series_position(depth, 0.0, 1.0);
#endif
    let base = unit_rotation(x);
    var harmonic = base;
    var tau = 0.5 * values[0] * x;
    for (var k = 1u; k <= ORDER; k++) {
#ifdef SINES_FIRST
        let sine = values[2];
#else
        let sine = values[2u * k];
#endif
        let wave = values[2u * k - 1u] * harmonic.y + sine * (1.0 - harmonic.x);
        tau += window(k) * wave / (TWO_PI * f32(k));
        harmonic = rotate(harmonic, base);
    }
    return exp(-max(0.0, tau));
}
