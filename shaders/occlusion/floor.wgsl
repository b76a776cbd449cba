// Floor: the uncompressed column, optical depth at the far edge of every step. Its error is that of the march alone,
// which no map of the same steps and texels can go below, whatever it stores.
//
//   τ_k = Σ_{j<k} σ_j Δ,  k = 1…n (τ_0 = 0);  V = exp(−lerp(τ_k, τ_{k+1})) at d = s·Δ, k = ⌊s⌋
//
// Source: cumulative (opacity) column as in deep shadow maps, Lokovic & Veach 2000, without their compression.
// Cost: n values a texel; look-up two fetches.
#import map::{map, Tap, column_length, fetch}
#import column::{Column, sample_extinction, steps_before, store}

// f16 holds 65504: between two infinite values a look-up would interpolate NaN, and exp(−6e4) is 0 anyway.
const LARGEST_TAU: f32 = 6e4;

fn encode(column: Column) {
    var tau = 0.0;
    var values = vec4f(0.0);
    for (var k = 0u; k < map.steps; k++) {
#ifdef PLACEMENT_OCCUPIED
        tau = depth_after_share(column, f32(k + 1u) / f32(map.steps));
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

#ifdef PLACEMENT_OCCUPIED
var<private> marched: u32;          // steps whose depth is in `marched_tau`
var<private> marched_tau: f32;
var<private> marched_sigma: f32;    // extinction of the last of them

// Optical depth of a share of the column's length, asked for in growing order: samples lie elsewhere than what is stored.
fn depth_after_share(column: Column, share: f32) -> f32 {
    let x = clamp(steps_before(column, share * column.length_m), 0.0, f32(map.steps));
    while marched < map.steps && f32(marched) < x {
        marched_sigma = sample_extinction(column, marched);
        marched_tau += marched_sigma * column.step_m;
        marched += 1u;
    }
    return marched_tau - marched_sigma * max(f32(marched) - x, 0.0) * column.step_m;
}
#endif

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
