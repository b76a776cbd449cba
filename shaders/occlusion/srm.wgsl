// Secondary march (SRM): n samples from p toward the sun.
//
//   V = exp(−Σₖ σ(p + ω sₖ) Δₖ),  interval k = [B(k), B(k+1)]·L,  sₖ its midpoint (end: its far end; jittered: a fraction)
//   uniform        B(k) = k/n                 L = d(p), the layer's exit
//   uniform_reach  B(k) = k/n                 L = min(d(p), reach_m)
//   quadratic      B(k) = (k/n)²              L = d(p)
//   exponential    B(k) = (2^k − 1)/(2^n − 1) L = d(p)        (thesis K: 6 growing steps)
//
// Source: Harris & Lastra 2001; thesis M, Algorithm 2. Cost: n density samples a view sample.
#import layer::{layer_length, point_at}
#import medium::{extinction, sun_ray}
#import numerics::OPAQUE_TAU

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

fn light_transmittance(p: vec3f, rnd: f32) -> f32 {
    let ray = sun_ray(p);
    var length_m = layer_length(ray);
#ifdef SPACING_UNIFORM_REACH
    length_m = min(length_m, params.reach_m);
#endif
    let n = f32(params.steps);
    var tau = 0.0;
    for (var k = 0u; k < params.steps && tau < OPAQUE_TAU; k++) {
        let low = boundary(f32(k), n) * length_m;
        let width = boundary(f32(k) + 1.0, n) * length_m - low;
#ifdef SAMPLING_END
        let q = point_at(ray, low + width);
#else ifdef SAMPLING_JITTERED
        let q = point_at(ray, low + rnd * width);
#else
        let q = point_at(ray, low + 0.5 * width);
#endif
        tau += extinction(q) * width;
    }
    return exp(-tau);
}
