// Beer shadow map (BSM), three values a texel (+ 1 with a tail): front z, mean extinction σ̄·depth_m, largest optical depth
// τ_max, tail τ_t.
//
//   stable     V = exp(−min(τ_max, σ̄·max(0, d − z)))
//   published  od = min(τ_max, σ̄·max(0, d − z)), V = exp(−od)·od; z = −1 for columns that never pass the threshold
//
// Mean:  all       Σσ/n over the whole column (thesis M)
//        occupied  Σσ/m over the m steps with extinction (Hillaire 2020; Unreal Engine); 0 when there is none
//        fitted    σ̄ = Σ w τ x/Σ w x²,  x = max(0, d − z),  w = σT: least squares of τ(d) on σ̄ alone
// Front: front.wgsl, or FRONT_WEIGHTED: z = Σ T d/Σ T over the steps with extinction, T behind the step
// Tail:  the column ends with the step behind which T ≤ ε, its n-th with extinction: TAIL_DARK ε = 1e-4, TAIL_DIM 1e-2.
//        V's bound becomes τ_max + τ_t, τ_t = min(2Δe^(1 − n), Δ/2) with Δ in metres: a column that is dark after few
//        steps is taken to hold much more. A column that stays lit has τ_t = 0.
// Because τ_max ≥ −ln ε where a column ends, τ_t changes V by less than ε; it was made for sums over powers of V. What changes
// V more is that σ̄ and a weighted z know nothing of what lies behind the end.
// Sources: Hillaire 2020; thesis M, Algorithms 5 and 6; Matsuda 2025, three-clouds (weighted front, tail).
// Cost: look-up one exponential; fitted marches the column twice; a tail saves the steps behind its end.
#import map::{map, Tap, fetch}
#import column::{Column, sample_depth, sample_extinction, step_depth, store}
#import front::{front_in_step, over_depth}

// f16 holds 65504: a larger σ̄·depth_m would become infinite, and exp(−64) is 0 for any picture.
const LARGEST_MEAN: f32 = 6e4;
const LARGEST_TAU: f32 = 64.0;
// −ln ε
#ifdef TAIL_DIM
const END_TAU: f32 = 4.6051702;
#else
const END_TAU: f32 = 9.2103404;
#endif

fn encode(column: Column) {
    var tau = 0.0;
    var occupied = 0.0;
    var front = -1.0;
    var tail = 0.0;
    var end = map.steps;
#ifdef FRONT_WEIGHTED
    var first_tau = 0.0;
    var weighted_m = 0.0;
    var weights = 0.0;
#endif
    for (var k = 0u; k < map.steps; k++) {
        let sigma = sample_extinction(column, k);
#ifndef FRONT_WEIGHTED
        if front < 0.0 {
            let front_m = front_in_step(column, k, sigma, tau);
            front = select(over_depth(front_m), -1.0, front_m < 0.0);
        }
#endif
        occupied += select(0.0, 1.0, sigma > 0.0);
        tau += sigma * column.step_m;
#ifdef FRONT_WEIGHTED
        if sigma > 0.0 && column.step_m > 0.0 {
            // T over that behind the first such step, which can be 0 in f32.
            first_tau = select(first_tau, tau, weights == 0.0);
            let weight = exp(first_tau - tau);
            weighted_m += weight * sample_depth(column, k);
            weights += weight;
        }
#endif
#ifndef TAIL_OFF
        if tau >= END_TAU {
            tail = min(2.0 * column.step_m * exp(1.0 - occupied), 0.5 * column.step_m);
            end = k + 1u;
            break;
        }
#endif
    }
#ifdef FRONT_WEIGHTED
    if weights > 0.0 {
        front = over_depth(weighted_m / weights);
    }
#endif
#ifdef FORM_PUBLISHED
    let z = select(front, -1.0, front < 0.0);
    store(column, 0u, vec4f(z, mean_extinction(column, tau, occupied, z, end), tau, tail));
#else
    let z = select(front, 1.0, front < 0.0);
    let mean = mean_extinction(column, tau, occupied, z, end);
    store(column, 0u, vec4f(z, min(mean, LARGEST_MEAN), min(tau, LARGEST_TAU), min(tail, LARGEST_TAU)));
#endif
}

// σ̄·depth_m of a column's first `steps` steps: optical depth tau, `occupied` of them hold medium.
fn mean_extinction(column: Column, tau: f32, occupied: f32, front: f32, steps: u32) -> f32 {
#ifdef MEAN_ALL
    return tau / max(column.length_m, 1e-20) * map.depth_m;
#else ifdef MEAN_FITTED
    return fitted_extinction(column, front, steps);
#else
    return tau / max(occupied * column.step_m, 1e-20) * map.depth_m;
#endif
}

fn fitted_extinction(column: Column, front: f32, steps: u32) -> f32 {
    var tau = 0.0;
    var cross = 0.0;
    var square = 0.0;
    for (var k = 0u; k < steps; k++) {
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
#ifdef TAIL_OFF
    let tau = min(stored.z, stored.y * max(0.0, depth - stored.x));
#else
    let tau = min(stored.z + stored.w, stored.y * max(0.0, depth - stored.x));
#endif
#ifdef FORM_PUBLISHED
    return exp(-tau) * tau;
#else
    return exp(-tau);
#endif
}
