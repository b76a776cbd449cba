// Light-space map: an orthographic grid of columns along the sun.
//
//   (u, v) = ((p·U, p·V) − origin)/extent in [0, 1]²,  texel = ⌊uv·R⌋;  depths are stored as d/depth_m, extinctions as σ·depth_m
//   value i of a texel is component i mod C of array layer ⌊i/C⌋, C = channels of the texture format
//
// `fetch` reads texel values: exactly at a tap's texel, or interpolated at its uv when LOOKUP_HARDWARE is defined.
// Cost: one texture read a layer.
#import frame::frame
#import layer::{LayerRay, layer_length}
#import container::layer_ray

struct Map {
    u_axis: vec3f,
    extent_m: f32,      // edge of the square rectangle
    v_axis: vec3f,
    depth_m: f32,       // L_max, the longest column
    origin_m: vec2f,    // (p·U, p·V) of the corner of texel (0, 0)
    resolution: u32,
    steps: u32,         // samples a column
}

@group(2) @binding(0) var<uniform> map: Map;
@group(2) @binding(2) var map_texture: texture_2d_array<f32>;
@group(2) @binding(3) var map_sampler: sampler;

struct Tap {
    texel: vec2i,
    uv: vec2f,
}

fn map_uv(p: vec3f) -> vec2f {
    return (vec2f(dot(p, map.u_axis), dot(p, map.v_axis)) - map.origin_m) / map.extent_m;
}

fn tap_at(uv: vec2f) -> Tap {
    return Tap(vec2i(min(uv * f32(map.resolution), vec2f(f32(map.resolution) - 1.0))), uv);
}

fn fetch(tap: Tap, layer: u32) -> vec4f {
#ifdef LOOKUP_HARDWARE
    return textureSampleLevel(map_texture, map_sampler, tap.uv, layer, 0.0);
#else
    return textureLoad(map_texture, tap.texel, layer, 0);
#endif
}

// The column through a point of the map: from the sun side to the end of the layer or the ground.
fn column_at(uv: vec2f) -> LayerRay {
    let plane = map.origin_m + uv * map.extent_m;
    return layer_ray(plane.x * map.u_axis + plane.y * map.v_axis, -frame.sun_direction, -1e30, 1e30);
}

// Length of the column whose values `fetch` returns.
fn column_length(tap: Tap) -> f32 {
#ifdef LOOKUP_HARDWARE
    return layer_length(column_at(tap.uv));
#else
    return layer_length(column_at((vec2f(tap.texel) + 0.5) / f32(map.resolution)));
#endif
}
