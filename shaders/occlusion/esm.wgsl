// Exponential shadow map (ESM), one value a texel.
//
//   stable     stores z, the front: where the column's transmittance first falls below 0.99, or its first medium (front.wgsl);
//              V = exp(−c·max(0, d − z))
//   published  stores f = exp(c z);  V = clamp(f·exp(−c d), 0, 1)   overflows f16 at c z ≥ 11.09, f32 at 88.7
//
// z, d over depth_m. Sources: Annen et al. 2008; thesis M, Algorithms 3 and 4. Cost: look-up one exponential.
#import map::{Tap, fetch}
#import column::{Column, store}
#import front::front_depth

struct Params {
    c: f32,
}

@group(2) @binding(1) var<uniform> params: Params;

fn encode(column: Column) {
    let z = front_depth(column);
#ifdef FORM_PUBLISHED
    store(column, 0u, vec4f(exp(params.c * z)));
#else
    store(column, 0u, vec4f(z));
#endif
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let stored = fetch(tap, 0u).x;
#ifdef FORM_PUBLISHED
    return clamp(stored * exp(-params.c * depth), 0.0, 1.0);
#else
    return exp(-params.c * max(0.0, depth - stored));
#endif
}
