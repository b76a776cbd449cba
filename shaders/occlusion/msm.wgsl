// Moment shadow map for transmittance (MSM): optical depth b₀ and power moments b₁…b₄, or b₁…b₆ with MOMENTS_SIX (+ 2 with
// per-texel bounds).
//
//   b₀ = Σ t,  b_i = Σ t zⁱ/b₀,  t = min(σΔ, 10),  z = 2x − 1, x = d/depth_m or (d − front)/(back − front)
//   biased: b + α((0, 3/8, 0, 3/8) − b);  six: (0, .557, 0, .489, 0, .479)
//   V(z) = exp(−b₀ F(z)),  F = the weight of every support point below z, and `overestimation` (0.25) of that at z, of the
//   one distribution of three points (six: four) that has these moments and z among its points
//
// With p₁(t) = t and p₂(t) = t² − s t − m₂ orthogonal under the moments m₂, m₃, m₄ about the mean (t = z − b₁, s = m₃/m₂,
// D = m₄ − m₂² − m₃²/m₂: the last pivot of the Cholesky factors of the Hankel matrix), the kernel
//   K(t, u) = 1 + t u/m₂ + p₂(t) p₂(u)/D
// is 0 between points of support and 1/weight at them. Outside of the zeros of p₂ both other points lie on one side of
// t; between them one lies below it, the lower root u of K(t, u) = 0, whose radicand is never negative. So F stays in
// [0, 1] and grows with t for any m₂, D > 0, rounded or not.
//
// Six: the monic polynomials p₁, p₂, p₃ orthogonal under the moments and their squared norms h₁, h₂, h₃ by the Chebyshev
// algorithm. For any real recurrence and any h > 0 they belong to some distribution (Favard's theorem), so what rounding
// does to them leaves F in [0, 1] and growing. With r roots of p₃ below z, r points of support are: none, all but z's, or all
// but one. So one root u of K(z, u) = Σ pᵢ(z)pᵢ(u)/hᵢ is needed, the only one on its side of z. In v = 1/(u − z) the cubic
// has the leading coefficient K(z, z) ≥ 1 and only real roots, one of them negative (mirrored where u > z): Newton's
// iteration, then one step more in u.
//
// α: f32 5e-7 as published; f16 3e-3, what its rounding calls for: the published 16 bits are fixed point in another basis.
// Six: f32 5e-5, for sums of 1000 steps (as published 5e-6, which 100 can exceed); f16 2e-2.
// A step counts as at most 10, as an opaque fragment does in the code of the paper. BOUNDS_TEXEL: V = 1 in front of the
// interval.
// Sources: Münstermann et al. 2018 (α, what it draws to, overestimation); Peters et al. 2017 (three and four points).
// Cost: look-up two fetches, a square root, an exponential; six, with texel bounds, three fetches, two roots; texel bounds march
// a column twice.
#import map::{map, Tap, fetch}
#import bounds::column_bounds
#import column::{Column, sample_depth, sample_extinction, store}

struct Params {
    overestimation: f32,
}

@group(2) @binding(1) var<uniform> params: Params;

const LARGEST_THICKNESS: f32 = 10.0;
#ifdef MOMENTS_SIX
#ifdef STORAGE_F16
const BIAS: f32 = 2e-2;
#else
const BIAS: f32 = 5e-5;
#endif
const SPREAD_LOW: vec3f = vec3f(0.0, 0.5566, 0.0);
const SPREAD_HIGH: vec3f = vec3f(0.489, 0.0, 0.47869382);
// A tenth of those that the bias alone leaves: reached by rounding only.
const SMALLEST_PIVOTS: vec3f = 0.1 * BIAS * vec3f(0.5566, 0.1791, 0.0490);
#else
#ifdef STORAGE_F16
const BIAS: f32 = 3e-3;
#else
const BIAS: f32 = 5e-7;
#endif
// Reached by rounding only: the least eigenvalue of the Hankel matrix of (1, 0, 3/8, 0, 3/8) is 0.199.
const SMALLEST_PIVOT: f32 = 0.02 * BIAS;
#endif

// z of a depth
fn position(depth: f32, edges: vec2f) -> f32 {
    return 2.0 * saturate((depth - edges.x) / max(edges.y - edges.x, 1e-20)) - 1.0;
}

fn encode(column: Column) {
    let edges = column_bounds(column);
    var total = 0.0;
    var moments = vec4f(0.0);
#ifdef MOMENTS_SIX
    var higher = vec2f(0.0);
#endif
    for (var k = 0u; k < map.steps; k++) {
        let thickness = min(sample_extinction(column, k) * column.step_m, LARGEST_THICKNESS);
        let z = position(sample_depth(column, k) / max(map.depth_m, 1e-20), edges);
        total += thickness;
        moments += thickness * vec4f(z, z * z, z * z * z, z * z * z * z);
#ifdef MOMENTS_SIX
        higher += thickness * vec2f(z * z * z * z * z, z * z * z * z * z * z);
#endif
    }
    // Of no medium, or too little to see, there are no moments.
    let seen = total > 1e-20;
    let b = select(vec4f(0.0), moments / max(total, 1e-20), seen);
    store(column, 0u, vec4f(select(0.0, total, seen), b.xyz));
#ifdef MOMENTS_SIX
    store(column, 1u, vec4f(b.w, select(vec2f(0.0), higher / max(total, 1e-20), seen), edges.x));
#ifdef BOUNDS_TEXEL
    store(column, 2u, vec4f(edges.y, 0.0, 0.0, 0.0));
#endif
#else
    store(column, 1u, vec4f(b.w, edges, 0.0));
#endif
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let first = fetch(tap, 0u);
    let second = fetch(tap, 1u);
#ifdef BOUNDS_TEXEL
#ifdef MOMENTS_SIX
    let edges = vec2f(second.w, fetch(tap, 2u).x);
#else
    let edges = second.yz;
#endif
    if depth <= edges.x {
        return 1.0;
    }
#else
    let edges = vec2f(0.0, 1.0);
#endif
#ifdef MOMENTS_SIX
    let low = mix(first.yzw, SPREAD_LOW, BIAS);
    let high = mix(second.xyz, SPREAD_HIGH, BIAS);
    return exp(-first.x * share_before_of_six(low, high, position(depth, edges)));
#else
    let b = mix(vec4f(first.yzw, second.x), vec4f(0.0, 0.375, 0.0, 0.375), BIAS);
    return exp(-first.x * share_before(b, position(depth, edges)));
#endif
}

#ifdef MOMENTS_SIX
// The orthogonal polynomials, p₀ = 1: p₁ = x − a₀, p₂ = (x − a₁)p₁ − h₁, p₃ = (x − a₂)p₂ − h₂/h₁·p₁
struct Orthogonal {
    a: vec3f,
    h: vec3f,
}

// From b₁…b₃ and b₄…b₆.
fn orthogonal(low: vec3f, high: vec3f) -> Orthogonal {
    // <p₁, xˡ>, l = 1…5, and <p₂, xˡ>, l = 2…4
    let first = vec4f(low.yz, high.xy) - low.x * vec4f(low, high.x);
    let first_5 = high.z - low.x * high.y;
    let h1 = max(first.x, SMALLEST_PIVOTS.x);
    let a1 = first.y / h1 - low.x;
    let second = vec3f(first.zw, first_5) - a1 * first.yzw - h1 * vec3f(low.yz, high.x);
    let h2 = max(second.x, SMALLEST_PIVOTS.y);
    let a2 = second.y / h2 - first.y / h1;
    let third = second.z - a2 * second.y - h2 / h1 * first.z;
    return Orthogonal(vec3f(low.x, a1, a2), vec3f(h1, h2, max(third, SMALLEST_PIVOTS.z)));
}

// p₁, p₂, p₃ at x
fn polynomials(o: Orthogonal, x: f32) -> vec3f {
    let p1 = x - o.a.x;
    let p2 = (x - o.a.y) * p1 - o.h.x;
    return vec3f(p1, p2, (x - o.a.z) * p2 - o.h.y / o.h.x * p1);
}

// Their derivatives, given their values.
fn derivatives(o: Orthogonal, x: f32, p: vec3f) -> vec3f {
    let d2 = (x - o.a.y) + p.x;
    return vec3f(1.0, d2, p.y + (x - o.a.z) * d2 - o.h.y / o.h.x);
}

// 1/K(x, x), from the values at x.
fn point_weight(o: Orthogonal, p: vec3f) -> f32 {
    return 1.0 / (1.0 + dot(p, p / o.h));
}

// The smallest root of x³ + a x² + b x + c, whose roots are real: y = t/√q of t³ − 3q t − 2q^(3/2)r, x = t − a/3, in [−2, −1].
fn smallest_root(a: f32, b: f32, c: f32) -> f32 {
    let middle = a / 3.0;
    let q = max(middle * middle - b / 3.0, 0.0);
    let scale = sqrt(q);
    let r = clamp((0.5 * (middle * b - c) - middle * middle * middle) / max(q * scale, 1e-30), -1.0, 1.0);
    var y = -1.0 - sqrt(0.5 * (1.0 - r));
    for (var i = 0u; i < 3u; i++) {
        y -= (y * (y * y - 3.0) - 2.0 * r) / max(3.0 * (y * y - 1.0), 1e-6);
    }
    return scale * y - middle;
}

// F(z)
fn share_before_of_six(low: vec3f, high: vec3f, z: f32) -> f32 {
    let o = orthogonal(low, high);
    let p = polynomials(o, z);
    let own = point_weight(o, p);
    // Roots of p₃ below z: signs that p₀…p₃ keep.
    let positive = p >= vec3f(0.0);
    let below = u32(positive.x) + u32(positive.y == positive.x) + u32(positive.z == positive.y);
    if below == 0u {
        return params.overestimation * own;
    }
    if below == 3u {
        return 1.0 - (1.0 - params.overestimation) * own;
    }
    // K(z, z + w) = 1/own + k₁w + k₂w² + k₃w³
    let c = p / o.h;
    let d = derivatives(o, z, p);
    let k1 = dot(c, d);
    let k2 = c.y + c.z * ((z - o.a.z) + d.y);
    let side = select(-1.0, 1.0, below == 1u);
    let v = min(smallest_root(side * k1 * own, k2 * own, side * c.z * own), -1e-4);
    var u = z + side / v;
    let at = polynomials(o, u);
    let slope = dot(c, derivatives(o, u, at));
    let reach = 0.1 * abs(u - z);
    u -= select(clamp((1.0 + dot(c, at)) / slope, -reach, reach), 0.0, abs(slope) < 1e-20);
    let other = min(point_weight(o, polynomials(o, u)), 1.0 - own);
    return select(1.0 - (1.0 - params.overestimation) * own - other, params.overestimation * own + other, below == 1u);
}
#else
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
#endif
