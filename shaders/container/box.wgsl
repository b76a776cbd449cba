// Container: axis-aligned box in vacuum, no ground. Slab test (Kay & Kajiya 1986), one interval.
// Cost: six divisions a ray.
#import layer::LayerRay

struct Container {
    low_m: vec3f,
    high_m: vec3f,
}

@group(0) @binding(2) var<uniform> container: Container;

fn height_fraction(p: vec3f) -> f32 {
    return saturate((p.y - container.low_m.y) / (container.high_m.y - container.low_m.y));
}

// Coordinates in which density fields are defined: the world's.
fn field_point(p: vec3f) -> vec3f {
    return p;
}

fn ground_blocks(p: vec3f, direction: vec3f) -> bool {
    return false;
}

fn layer_ray(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32) -> LayerRay {
    // A component of 0 becomes ±1e−30: the quotient is huge with the right sign instead of 0/0.
    let tiny = vec3f(1e-30);
    let d = select(direction, tiny, abs(direction) < tiny);
    let a = (container.low_m - origin) / d;
    let b = (container.high_m - origin) / d;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, t_min));
    let leave = min(min(far.x, far.y), min(far.z, t_max));
    return LayerRay(origin, direction, vec2f(enter), vec2f(max(leave - enter, 0.0), 0.0));
}
