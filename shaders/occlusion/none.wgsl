// No occlusion: V = 1. The upper bound of light, and the cost of the view march alone.
// Cost: nothing.
fn light_transmittance(p: vec3f, rnd: f32) -> f32 {
    return 1.0;
}
