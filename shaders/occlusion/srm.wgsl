// Secondary march (SRM): n samples from p toward the sun.
//
//   V = exp(−Σₖ σ(p + ω sₖ) Δₖ),  interval k = [B(k), B(k+1)]·L,  sₖ its midpoint (end: its far end; jittered: a fraction)
//   uniform        B(k) = k/n                 L = d(p), the layer's exit
//   uniform_reach  B(k) = k/n                 L = min(d(p), reach_m)
//   quadratic      B(k) = (k/n)²              L = d(p)
//   exponential    B(k) = (2^k − 1)/(2^n − 1) L = d(p)        (thesis K: 6 growing steps)
//
//   PLACEMENT_OCCUPIED: L and sₖ are measured along the spans of the ray that may hold medium alone, found in PARTS parts at
//   most (spans.wgsl); the gaps between them are skipped, and no sample is spent on them
//
// Source: Harris & Lastra 2001; thesis M, Algorithm 2. Cost: n density samples a view sample; with placement
// about PARTS look-ups of the occupancy grid more.
#import layer::{layer_length, point_at}
#import medium::{extinction, sun_ray}
#import numerics::OPAQUE_TAU
#ifdef PLACEMENT_OCCUPIED
#import spans::{mark_occupied, occupied_position}
#endif

struct Params {
    steps: u32,
    reach_m: f32,
}

@group(2) @binding(1) var<uniform> params: Params;

fn boundary(k: f32, n: f32) -> f32 {
#ifdef SPACING_QUADRATIC
    return (k / n) * (k / n);
#else ifdef SPACING_EXPONENTIAL
    // 2^(k−n) − 2^(−n) over 1 − 2^(−n): no overflow at any n.
    return (exp2(k - n) - exp2(-n)) / (1.0 - exp2(-n));
#else
    return k / n;
#endif
}

#ifdef PLACEMENT_OCCUPIED
// Coarse parts keep the search cheaper than the samples.
const PARTS: f32 = 24.0;
#endif

// Distance from p of a distance along what is marched.
fn place(travelled_m: f32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    return occupied_position(travelled_m);
#else
    return travelled_m;
#endif
}

fn light_transmittance(p: vec3f, rnd: f32) -> f32 {
    let ray = sun_ray(p);
    var length_m = layer_length(ray);
#ifdef SPACING_UNIFORM_REACH
    length_m = min(length_m, params.reach_m);
#endif
#ifdef PLACEMENT_OCCUPIED
    length_m = mark_occupied(ray, length_m, length_m / PARTS);
    if length_m <= 0.0 {
        return 1.0;
    }
#endif
    let n = f32(params.steps);
    var tau = 0.0;
    for (var k = 0u; k < params.steps && tau < OPAQUE_TAU; k++) {
        let low = boundary(f32(k), n) * length_m;
        let width = boundary(f32(k) + 1.0, n) * length_m - low;
#ifdef SAMPLING_END
        let q = point_at(ray, place(low + width));
#else ifdef SAMPLING_JITTERED
        let q = point_at(ray, place(low + rnd * width));
#else
        let q = point_at(ray, place(low + 0.5 * width));
#endif
        tau += extinction(q) * width;
    }
    return exp(-tau);
}
