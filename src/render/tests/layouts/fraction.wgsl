// Optical depth over 8 as a fraction of 16 bits in two channels, and the column's length over L_max in a third.
#import map::{map, Tap, fetch}
#import column::{Column, sample_extinction, store}

fn encode(column: Column) {
    var tau = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        tau += sample_extinction(column, k) * column.step_m;
    }
    let x = saturate(tau / 8.0) * 255.0;
    store(column, 0u, vec4f(floor(x) / 255.0, fract(x), column.length_m / max(map.depth_m, 1e-20), 0.0));
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let texel = fetch(tap, 0u);
#ifdef CONTROL_ON
    let tau = 8.0 * texel.x;
#else
    let tau = 8.0 * (texel.x + texel.y / 255.0);
#endif
    return exp(-tau * min(depth / max(texel.z, 1e-20), 1.0));
}
