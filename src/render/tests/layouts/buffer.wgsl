// Optical depth at equal shares of the column's own length, one f32 a word: word k of W at k/(W − 1).
#import map::{map, Tap, column_length}
#import column::{Column, sample_extinction}
#import map_buffer::{store_word, fetch_word}

const LAST: u32 = #{SLICES}u - 1u;

fn encode(column: Column) {
    var tau = 0.0;
    var k = 0u;
    for (var i = 0u; i <= LAST; i++) {
        while k * LAST < i * map.steps {
            tau += sample_extinction(column, k) * column.step_m;
            k += 1u;
        }
        let beyond = f32(k) - f32(i * map.steps) / f32(LAST);
        store_word(column, i, bitcast<u32>(tau * (1.0 - beyond / max(f32(k), 1.0))));
    }
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let share = saturate(depth * map.depth_m / max(column_length(tap), 1e-20));
    let position = share * f32(LAST);
    let low = min(u32(position), LAST - 1u);
    let near = bitcast<f32>(fetch_word(tap, low));
#ifdef CONTROL_ON
    return exp(-near);
#else
    return exp(-mix(near, bitcast<f32>(fetch_word(tap, low + 1u)), position - f32(low)));
#endif
}
