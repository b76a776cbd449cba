// Light-space map: an orthographic grid of columns along the sun.
//
//   x = ((p·U, p·V) − origin)/extent in [0, 1]²,  (u, v) = x, or W(x) with a warp,  texel = ⌊uv·R⌋
//   W: on each axis piecewise linear between equally spaced knots, so that texels are dense where the view takes its
//      samples (Rosen 2012, Rectilinear Texture Warping); a column inverts it by bisection
//   depths are stored as d/depth_m, extinctions as σ·depth_m
//   value i of a texel is component i mod C of array layer ⌊i/C⌋, C = channels of the texture format
//
// `fetch` reads texel values: exactly at a tap's texel, or interpolated at its uv when LOOKUP_HARDWARE is defined.
// Cost: one texture read a layer; FIT_WARPED: four reads of a table of 520 bytes more, in a column 14.
#import frame::frame
#import layer::{LayerRay, layer_length}
#import container::layer_ray

struct Map {
    u_axis: vec3f,
    depth_m: f32,       // L_max, the longest column
    v_axis: vec3f,
    resolution: u32,
    origin_m: vec2f,    // (p·U, p·V) of the corner of texel (0, 0)
    extent_m: vec2f,    // edges of the rectangle
    steps: u32,         // samples a column
    near_steps: u32,    // marched before the map is asked
    near_m: f32,        // their reach
    part_m: f32,        // from look-up to look-up where a column may hold medium (spans.wgsl)
    shortest_step_m: f32,   // of a column whose steps are placed; 0 = any
}

@group(2) @binding(0) var<uniform> map: Map;
@group(2) @binding(2) var map_texture: texture_2d_array<f32>;
@group(2) @binding(3) var map_sampler: sampler;
#ifdef FIT_WARPED
@group(2) @binding(11) var<storage, read> map_warp: array<vec2f>;   // W at the knots

const WARP_PARTS: u32 = 64u;

fn warped(position: vec2f) -> vec2f {
    let s = saturate(position) * f32(WARP_PARTS);
    let i = min(vec2u(s), vec2u(WARP_PARTS - 1u));
    let low = vec2f(map_warp[i.x].x, map_warp[i.y].y);
    let high = vec2f(map_warp[i.x + 1u].x, map_warp[i.y + 1u].y);
    return mix(low, high, s - vec2f(i));
}

fn unwarped(uv: vec2f) -> vec2f {
    var i = vec2u(0u);
    for (var step = WARP_PARTS / 2u; step > 0u; step /= 2u) {
        let knots = vec2f(map_warp[i.x + step].x, map_warp[i.y + step].y);
        i += select(vec2u(0u), vec2u(step), knots <= uv);
    }
    let low = vec2f(map_warp[i.x].x, map_warp[i.y].y);
    let high = vec2f(map_warp[i.x + 1u].x, map_warp[i.y + 1u].y);
    return (vec2f(i) + saturate((uv - low) / (high - low))) / f32(WARP_PARTS);
}
#endif

struct Tap {
    texel: vec2i,
    uv: vec2f,
}

// Position in the rectangle, outside [0, 1]² where the map knows nothing.
fn map_position(p: vec3f) -> vec2f {
    return (vec2f(dot(p, map.u_axis), dot(p, map.v_axis)) - map.origin_m) / map.extent_m;
}

fn map_uv(position: vec2f) -> vec2f {
#ifdef FIT_WARPED
    return warped(position);
#else
    return position;
#endif
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
#ifdef FIT_WARPED
    let plane = map.origin_m + unwarped(uv) * map.extent_m;
#else
    let plane = map.origin_m + uv * map.extent_m;
#endif
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
