// Interval of depths that a map's functions are taken over, over depth_m.
//
//   BOUNDS_TEXEL: [near edge of the first step with extinction, far edge of the last], of each column; 0, 0 where none has
//   otherwise [0, 1], the longest column of the map
//
// Cost: BOUNDS_TEXEL marches the column once more.
#import map::map
#import column::{Column, sample_extinction, step_depth}

fn column_bounds(column: Column) -> vec2f {
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
