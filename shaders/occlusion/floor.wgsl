// Floor: the uncompressed column, optical depth at the far edge of every step. Its error is that of the march alone,
// which no map of the same steps and texels can go below, whatever it stores.
//
//   τ_k = Σ_{j<k} σ_j Δ,  k = 1…n (τ_0 = 0);  V = exp(−lerp(τ_k, τ_{k+1})) at d = s·Δ, k = ⌊s⌋
//
// Source: cumulative (opacity) column as in deep shadow maps, Lokovic & Veach 2000, without their compression.
// Cost: n values a texel; look-up two fetches.
#import map::{map, Tap, column_length, fetch}
#import column::{Column, sample_extinction, store}
#ifdef PLACEMENT_OCCUPIED
#import cumulative::optical_depth_before
#endif

// f16 holds 65504: between two infinite values a look-up would interpolate NaN, and exp(−6e4) is 0 anyway.
const LARGEST_TAU: f32 = 6e4;

fn encode(column: Column) {
    var tau = 0.0;
    var values = vec4f(0.0);
    for (var k = 0u; k < map.steps; k++) {
#ifdef PLACEMENT_OCCUPIED
        // Samples lie elsewhere than what is stored.
        tau = optical_depth_before(column, f32(k + 1u) / f32(map.steps) * column.length_m);
#else
        tau += sample_extinction(column, k) * column.step_m;
#endif
        let channel = k % 4u;
        values = select(values, vec4f(min(tau, LARGEST_TAU)), vec4u(channel) <= vec4u(0u, 1u, 2u, 3u));
        if channel == 3u || k + 1u == map.steps {
            store(column, k / 4u, values);
        }
    }
}

// Optical depth after k steps.
fn depth_after(tap: Tap, k: u32) -> f32 {
    if k == 0u {
        return 0.0;
    }
    let four = fetch(tap, (k - 1u) / 4u);
    let channel = vec4u((k - 1u) % 4u) == vec4u(0u, 1u, 2u, 3u);
    return dot(select(vec4f(0.0), four, channel), vec4f(1.0));
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let length_m = column_length(tap);
    let last = f32(map.steps);
    let s = clamp(depth * map.depth_m / max(length_m, 1e-20) * last, 0.0, last);
    let k = min(u32(s), map.steps - 1u);
    return exp(-mix(depth_after(tap, k), depth_after(tap, k + 1u), s - f32(k)));
}
