// The secondary march: n samples from p toward the sun, up to the layer's exit.
//
//   V = exp(−Σₖ σ(p + ω sₖ) Δₖ),  interval k = [B(k/n), B((k+1)/n)]·L,  B(x) = x², sₖ its midpoint
//
// Quadratic spacing puts half of the samples into the nearest quarter, where the contribution varies most.
// Cost: n density samples.
#import layer::{LayerRay, layer_length, point_at}
#import medium::{extinction, sun_ray}

fn quadratic_march(p: vec3f, steps: u32) -> f32 {
    let ray = sun_ray(p);
    return exp(-quadratic_depth(ray, layer_length(ray), steps));
}

// Optical depth of the first length_m of a ray.
fn quadratic_depth(ray: LayerRay, length_m: f32, steps: u32) -> f32 {
    var tau = 0.0;
    for (var k = 0u; k < steps; k++) {
        let low = f32(k) / f32(steps);
        let high = f32(k + 1u) / f32(steps);
        let q = point_at(ray, 0.5 * (low * low + high * high) * length_m);
        tau += extinction(q) * (high * high - low * low) * length_m;
    }
    return tau;
}
