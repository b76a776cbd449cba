// Container: spherical shell base_m…top_m above a ground sphere that blocks light. Local coordinates: the planet's
// centre is (0, −R, 0).
//
//   height(p) = (x² + y² + z² + 2Ry) / (√(x² + (y+R)² + z²) + R)        no cancellation, f32 up to R = 1e9 m
//   sphere of height h:  t² + 2bt + c = 0,  b = o·d + R d.y,  c = |o|² + 2R(o.y − h) − h²,  roots q and c/q with
//   q = −b − sign(b)√(b² − c)  (Press et al., Numerical Recipes, 5.6: no cancellation in the near root)
//
// Cost: three quadratics a ray.
#import layer::LayerRay

struct Container {
    planet_radius_m: f32,
    base_m: f32,
    top_m: f32,
}

@group(0) @binding(2) var<uniform> container: Container;

// Roots in ascending order; (1, −1) when the sphere is missed.
fn sphere_roots(origin: vec3f, direction: vec3f, height_m: f32) -> vec2f {
    let r = container.planet_radius_m;
    let b = dot(origin, direction) + r * direction.y;
    let c = dot(origin, origin) + 2.0 * r * (origin.y - height_m) - height_m * height_m;
    let discriminant = b * b - c;
    if discriminant <= 0.0 {
        return vec2f(1.0, -1.0);
    }
    let q = -b - select(-1.0, 1.0, b >= 0.0) * sqrt(discriminant);
    let other = c / q;
    return vec2f(min(q, other), max(q, other));
}

fn height_m(p: vec3f) -> f32 {
    let r = container.planet_radius_m;
    let above = p.y + r;
    return (dot(p, p) + 2.0 * r * p.y) / (sqrt(p.x * p.x + above * above + p.z * p.z) + r);
}

fn height_fraction(p: vec3f) -> f32 {
    return saturate((height_m(p) - container.base_m) / (container.top_m - container.base_m));
}

// Coordinates in which density fields are defined: horizontal x and z, height above ground as y.
fn field_point(p: vec3f) -> vec3f {
    return vec3f(p.x, height_m(p), p.z);
}

fn ground_blocks(p: vec3f, direction: vec3f) -> bool {
    let ground = sphere_roots(p, direction, 0.0);
    return ground.x <= ground.y && ground.x > 0.0;
}

fn layer_ray(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32) -> LayerRay {
    var ray = LayerRay(origin, direction, vec2f(0.0), vec2f(0.0));
    let outer = sphere_roots(origin, direction, container.top_m);
    if outer.x > outer.y {
        return ray;
    }
    let enter = max(outer.x, t_min);
    var leave = min(outer.y, t_max);
    let ground = sphere_roots(origin, direction, 0.0);
    if ground.x <= ground.y && ground.x >= t_min {
        leave = min(leave, ground.x);
    }
    let inner = sphere_roots(origin, direction, container.base_m);
    if inner.x > inner.y {
        ray.start_m = vec2f(enter);
        ray.length_m = vec2f(max(leave - enter, 0.0), 0.0);
        return ray;
    }
    ray.start_m = vec2f(enter, max(enter, inner.y));
    ray.length_m = max(vec2f(min(leave, inner.x), leave) - ray.start_m, vec2f(0.0));
    return ray;
}
