// Optical depth of a column before given depths, marched once: for maps that store τ at depths of their own choice.
//
//   τ(d) = Σ σΔ over the steps before d, the step at d in part
//
// Cost: one density sample a step in all, for depths asked for in growing order.
#import map::map
#import column::{Column, sample_extinction, steps_before}

var<private> marched: u32;          // steps whose optical depth is in `marched_tau`
var<private> marched_tau: f32;
var<private> last_sigma: f32;       // extinction of the last of them

fn optical_depth_before(column: Column, depth_m: f32) -> f32 {
    let x = clamp(steps_before(column, depth_m), 0.0, f32(map.steps));
    while marched < map.steps && f32(marched) < x {
        last_sigma = sample_extinction(column, marched);
        marched_tau += last_sigma * column.step_m;
        marched += 1u;
    }
    return marched_tau - last_sigma * max(f32(marched) - x, 0.0) * column.step_m;
}
