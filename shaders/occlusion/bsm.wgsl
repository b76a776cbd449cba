// Beer shadow map (BSM), three values a texel: front z, mean extinction σ̄·depth_m, largest optical depth τ_max.
//
//   stable     V = exp(−min(τ_max, σ̄·max(0, d − z)))
//   published  od = min(τ_max, σ̄·max(0, d − z)), V = exp(−od)·od; z = −1 for columns that never pass the threshold
//
// Mean:  all       Σσ/n over the whole column (thesis M)
//        occupied  Σσ/m over the m steps with extinction (Hillaire 2020; Unreal Engine); 0 when there is none
//        fitted    σ̄ = Σ w τ x/Σ w x²,  x = max(0, d − z),  w = σT: least squares of τ(d) on σ̄ alone
// Sources: Hillaire 2020; thesis M, Algorithms 5 and 6. Cost: look-up one exponential; fitted marches the column twice.
#import map::{map, Tap, fetch}
#import column::{Column, sample_extinction, step_depth, store}
#import front::{front_in_step, over_depth}

// f16 holds 65504: a larger σ̄·depth_m would become infinite, and exp(−64) is 0 for any picture.
const LARGEST_MEAN: f32 = 6e4;
const LARGEST_TAU: f32 = 64.0;

fn encode(column: Column) {
    var tau = 0.0;
    var occupied = 0.0;
    var front = -1.0;
    for (var k = 0u; k < map.steps; k++) {
        let sigma = sample_extinction(column, k);
        if front < 0.0 {
            let front_m = front_in_step(column, k, sigma, tau);
            front = select(over_depth(front_m), -1.0, front_m < 0.0);
        }
        occupied += select(0.0, 1.0, sigma > 0.0);
        tau += sigma * column.step_m;
    }
#ifdef FORM_PUBLISHED
    let z = select(front, -1.0, front < 0.0);
    store(column, 0u, vec4f(z, mean_extinction(column, tau, occupied, z), tau, 0.0));
#else
    let z = select(front, 1.0, front < 0.0);
    let mean = mean_extinction(column, tau, occupied, z);
    store(column, 0u, vec4f(z, min(mean, LARGEST_MEAN), min(tau, LARGEST_TAU), 0.0));
#endif
}

// σ̄·depth_m of a column of optical depth tau with `occupied` steps that hold medium.
fn mean_extinction(column: Column, tau: f32, occupied: f32, front: f32) -> f32 {
#ifdef MEAN_ALL
    return tau / max(column.length_m, 1e-20) * map.depth_m;
#else ifdef MEAN_FITTED
    return fitted_extinction(column, front);
#else
    return tau / max(occupied * column.step_m, 1e-20) * map.depth_m;
#endif
}

fn fitted_extinction(column: Column, front: f32) -> f32 {
    var tau = 0.0;
    var cross = 0.0;
    var square = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        let sigma = sample_extinction(column, k);
        let at_sample = tau + 0.5 * sigma * column.step_m;
        let x = max(0.0, step_depth(column, f32(k) + 0.5) / map.depth_m - front);
        let weight = sigma * exp(-at_sample);
        cross += weight * at_sample * x;
        square += weight * x * x;
        tau += sigma * column.step_m;
    }
    // All weight in front of the fit's origin: one step holds everything, its own extinction is the limit.
    return select(tau / max(column.step_m, 1e-20) * map.depth_m, cross / square, square > 1e-30);
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    let stored = fetch(tap, 0u);
    let tau = min(stored.z, stored.y * max(0.0, depth - stored.x));
#ifdef FORM_PUBLISHED
    return exp(-tau) * tau;
#else
    return exp(-tau);
#endif
}
