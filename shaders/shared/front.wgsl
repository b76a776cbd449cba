// Front of a column: the depth at which its cloud begins, over depth_m in [0, 1]; 1 where there is none.
//
//   FRONT_THRESHOLD (thesis M): T first falls below 0.99, interpolated inside the step with constant σ:
//                    z = near edge + (−ln 0.99 − τ)/σ
//   FRONT_FIRST: near edge of the first step with extinction and length
//
// Cost: one column march up to the front.
#import map::map
#import column::{Column, sample_extinction, step_depth}

const FRONT_TAU: f32 = 0.010050336; // −ln 0.99

// One step of the search: the front, metres, or −1 while it is not reached. `tau` is the depth before step k.
fn front_in_step(column: Column, k: u32, sigma: f32, tau: f32) -> f32 {
    let near_m = step_depth(column, f32(k));
#ifdef FRONT_FIRST
    return select(-1.0, near_m, sigma > 0.0 && column.step_m > 0.0);
#else
    if tau + sigma * column.step_m <= FRONT_TAU {
        return -1.0;
    }
#ifdef PLACEMENT_OCCUPIED
    return step_depth(column, f32(k) + max(FRONT_TAU - tau, 0.0) / (sigma * column.step_m));
#else
    return near_m + max(FRONT_TAU - tau, 0.0) / sigma;
#endif
#endif
}

// A front in metres over depth_m, at most 1; finite too where depth_m is 0 because the view sees nothing of the layer.
fn over_depth(front_m: f32) -> f32 {
    return min(front_m / max(map.depth_m, 1e-20), 1.0);
}

fn front_depth(column: Column) -> f32 {
    var tau = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        let sigma = sample_extinction(column, k);
        let front_m = front_in_step(column, k, sigma, tau);
        if front_m >= 0.0 {
            return over_depth(front_m);
        }
        tau += sigma * column.step_m;
    }
    return 1.0;
}
