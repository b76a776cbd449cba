// Phase function: a sum of two Henyey–Greenstein lobes (Henyey & Greenstein 1941), weights summing to 1.
//
//   p(cosθ) = (1 − g²) / (4π (1 + g² − 2g cosθ)^(3/2)),  cosθ between the direction light travels and the direction
//   toward the camera; 1 + g² − 2g cosθ is formed as (1 − g)² + 2g(1 − cosθ), exact near the forward peak
//
// Cost: two square roots a ray.

fn henyey_greenstein(g: f32, cosine: f32) -> f32 {
    let base = max((1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine), 1e-12);
    return (1.0 - g) * (1.0 + g) / (12.566371 * base * sqrt(base));
}

fn phase_function(lobes: vec4f, cosine: f32) -> f32 {
    return lobes.y * henyey_greenstein(lobes.x, cosine) + lobes.w * henyey_greenstein(lobes.z, cosine);
}
