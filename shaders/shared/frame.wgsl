// Uniforms of every march, group 0: camera, sun, medium, step rule; and the tile of the dispatch.
// Ray of pixel (i, j): position + t·normalize(forward + x·right + y·up), x = 2(i+½)/W − 1, y = 1 − 2(j+½)/H,
// with right and up scaled by the half extents of the image plane.

struct Frame {
    camera_position_m: vec3f,
    far_m: f32,
    camera_right: vec3f,
    steps: u32,
    camera_up: vec3f,
    step_m: f32,              // > 0 replaces `steps`
    camera_forward: vec3f,
    jitter: u32,              // 1: per-pixel start offset, 0: midpoints
    sun_direction: vec3f,     // toward the sun
    skip: u32,                // 1: skip provably empty space (exact)
    sun_irradiance: vec3f,    // perpendicular to the beam, × sun_gain
    extinction_per_m: f32,    // at density 1
    phase: vec4f,             // g and weight of two Henyey–Greenstein lobes
    image_size: vec2u,
    albedo: f32,
}

// The part of the picture, and of every view ray in it, that one dispatch marches.
struct Tile {
    origin: vec2u,
    size: vec2u,
    steps: vec2u,             // first step, one past the last
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> tile: Tile;

fn camera_ray(pixel: vec2u) -> vec3f {
    let unit = (vec2f(pixel) + 0.5) / vec2f(frame.image_size);
    let x = 2.0 * unit.x - 1.0;
    let y = 1.0 - 2.0 * unit.y;
    return normalize(frame.camera_forward + x * frame.camera_right + y * frame.camera_up);
}
