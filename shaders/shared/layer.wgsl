// A ray clipped to the container: one or two intervals, addressed by s = distance travelled INSIDE, gaps excluded.
//
//   point_at(ray, s) = origin + t(s)·direction,  0 ≤ s ≤ layer_length(ray)

struct LayerRay {
    origin: vec3f,
    direction: vec3f,
    start_m: vec2f,   // t at which the intervals begin
    length_m: vec2f,  // their lengths, ≥ 0
}

fn layer_length(ray: LayerRay) -> f32 {
    return ray.length_m.x + ray.length_m.y;
}

fn point_at(ray: LayerRay, s: f32) -> vec3f {
    let t = select(ray.start_m.y + (s - ray.length_m.x), ray.start_m.x + s, s <= ray.length_m.x);
    return ray.origin + t * ray.direction;
}
