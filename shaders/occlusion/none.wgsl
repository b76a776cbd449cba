// No occlusion: V = 1, the upper bound of light; its time is that of the view march alone.
// Cost: nothing.
fn light_transmittance(p: vec3f, rnd: f32) -> f32 {
    return 1.0;
}
