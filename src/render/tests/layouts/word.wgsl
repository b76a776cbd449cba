// Optical depth over 8 in the upper 24 bits of a word, the column's length over L_max in the lower 8.
#import map::{map, Tap}
#import column::{Column, sample_extinction}
#import map_words::{store_words, fetch_words}

fn encode(column: Column) {
    var tau = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        tau += sample_extinction(column, k) * column.step_m;
    }
    let length = saturate(column.length_m / max(map.depth_m, 1e-20));
    let word = (min(u32(saturate(tau / 8.0) * 16777215.0 + 0.5), 16777215u) << 8u) | u32(length * 255.0 + 0.5);
    store_words(column, 0u, vec4u(word, 0u, 0u, 0u));
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let word = fetch_words(tap, 0u).x;
#ifdef CONTROL_ON
    let tau = 8.0 * f32(word >> 24u) / 255.0;
#else
    let tau = 8.0 * f32(word >> 8u) / 16777215.0;
#endif
    let length = f32(word & 255u) / 255.0;
    return exp(-tau * min(depth / max(length, 1e-20), 1.0));
}
