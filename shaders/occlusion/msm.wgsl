// Moment shadow map for transmittance (MSM): optical depth b₀ and four power moments b₁…b₄ (+ 2 with per-texel bounds).
//
//   b₀ = Σ t,  b_i = Σ t zⁱ/b₀,  t = min(σΔ, 10),  z = 2x − 1, x = d/depth_m or (d − front)/(back − front)
//   biased: b + α((0, 3/8, 0, 3/8) − b)
//   V(z) = exp(−b₀ F(z)),  F = the weight of every support point below z, and `overestimation` (0.25) of that at z, of the
//   one distribution of three points that has these moments and z among its points
//
// With p₁(t) = t and p₂(t) = t² − s t − m₂ orthogonal under the moments m₂, m₃, m₄ about the mean (t = z − b₁, s = m₃/m₂,
// D = m₄ − m₂² − m₃²/m₂: the last pivot of the Cholesky factors of the Hankel matrix), the kernel
//   K(t, u) = 1 + t u/m₂ + p₂(t) p₂(u)/D
// is 0 between points of support and 1/weight at them. Outside of the zeros of p₂ both other points lie on one side of
// t; between them one lies below it, the lower root u of K(t, u) = 0, whose radicand is never negative. So F stays in
// [0, 1] and grows with t for any m₂, D > 0, rounded or not.
//
// α: f32 5e-7 as published; f16 3e-3, what its rounding calls for: the published 16 bits are fixed point in another basis.
// A step counts as at most 10, as an opaque fragment does in the code of the paper. BOUNDS_TEXEL: V = 1 in front of the
// interval.
// Sources: Münstermann et al. 2018 (α, overestimation); Peters et al. 2017 (three points).
// Cost: look-up two fetches, a square root, an exponential; texel bounds march a column twice.
#import map::{map, Tap, fetch}
#import column::{Column, sample_depth, sample_extinction, step_depth, store}

struct Params {
    overestimation: f32,
}

@group(2) @binding(1) var<uniform> params: Params;

const LARGEST_THICKNESS: f32 = 10.0;
#ifdef STORAGE_F16
const BIAS: f32 = 3e-3;
#else
const BIAS: f32 = 5e-7;
#endif
// Reached by rounding only: the least eigenvalue of the Hankel matrix of (1, 0, 3/8, 0, 3/8) is 0.199.
const SMALLEST_PIVOT: f32 = 0.02 * BIAS;

// Edges of the occupied part of the column, over depth_m.
fn bounds(column: Column) -> vec2f {
#ifdef BOUNDS_TEXEL
    var first = map.steps;
    var last = 0u;
    for (var k = 0u; k < map.steps; k++) {
        if sample_extinction(column, k) > 0.0 {
            first = min(first, k);
            last = k + 1u;
        }
    }
    let edges_m = vec2f(step_depth(column, f32(min(first, last))), step_depth(column, f32(last)));
    return edges_m / max(map.depth_m, 1e-20);
#else
    return vec2f(0.0, 1.0);
#endif
}

// z of a depth
fn position(depth: f32, edges: vec2f) -> f32 {
    return 2.0 * saturate((depth - edges.x) / max(edges.y - edges.x, 1e-20)) - 1.0;
}

fn encode(column: Column) {
    let edges = bounds(column);
    var total = 0.0;
    var moments = vec4f(0.0);
    for (var k = 0u; k < map.steps; k++) {
        let thickness = min(sample_extinction(column, k) * column.step_m, LARGEST_THICKNESS);
        let z = position(sample_depth(column, k) / max(map.depth_m, 1e-20), edges);
        total += thickness;
        moments += thickness * vec4f(z, z * z, z * z * z, z * z * z * z);
    }
    // Of no medium, or too little to see, there are no moments.
    let seen = total > 1e-20;
    let b = select(vec4f(0.0), moments / max(total, 1e-20), seen);
    store(column, 0u, vec4f(select(0.0, total, seen), b.xyz));
    store(column, 1u, vec4f(b.w, edges, 0.0));
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let first = fetch(tap, 0u);
    let second = fetch(tap, 1u);
#ifdef BOUNDS_TEXEL
    let edges = second.yz;
    if depth <= edges.x {
        return 1.0;
    }
#else
    let edges = vec2f(0.0, 1.0);
#endif
    let b = mix(vec4f(first.yzw, second.x), vec4f(0.0, 0.375, 0.0, 0.375), BIAS);
    return exp(-first.x * share_before(b, position(depth, edges)));
}

// F(z)
fn share_before(b: vec4f, z: f32) -> f32 {
    let mean = b.x;
    let second = max(b.y - mean * mean, SMALLEST_PIVOT);
    let off = b.z - mean * b.y;
    let slope = off / second - 2.0 * mean;
    let pivot = max(b.w - b.y * b.y - off * off / second, SMALLEST_PIVOT);
    let t = z - mean;
    let p2 = t * (t - slope) - second;
    let own = 1.0 / (1.0 + t * t / second + p2 * p2 / pivot);
    if p2 >= 0.0 {
        return select(params.overestimation * own, 1.0 - (1.0 - params.overestimation) * own, t > 0.0);
    }
    // K(t, u) = 0 as a u² − l u − c = 0 with a, c > 0.
    let a = -p2 / pivot;
    let l = t / second + a * slope;
    let c = 1.0 + a * second;
    let root = sqrt(l * l + 4.0 * a * c);
    let u = max(select((l - root) / max(2.0 * a, 1e-20), -2.0 * c / (l + root), l > 0.0), -1e4);
    let q2 = u * (u - slope) - second;
    let lower = 1.0 / (1.0 + u * u / second + q2 * q2 / pivot);
    return params.overestimation * own + min(lower, 1.0 - own);
}
