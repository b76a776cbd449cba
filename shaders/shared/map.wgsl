// Light-space map: an orthographic grid of columns along the sun.
//
//   x = ((p·U, p·V) − origin)/extent in [0, 1]²,  (u, v) = x, or W(x) with a warp,  texel = ⌊uv·R⌋
//   W: on each axis piecewise linear between equally spaced knots, so that texels are dense where the view takes its
//      samples (Rosen 2012, Rectilinear Texture Warping); a column inverts it by bisection
//   CASCADES: n rectangles, each with its own texels, one above the other along v in one texture: rectangle c has the
//      rows cR … (c + 1)R − 1, and `cascade` says which of them is asked or filled
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
    resolution: u32,    // edge of a rectangle, texels
    origin_m: vec2f,    // (p·U, p·V) of the corner of texel (0, 0)
    extent_m: vec2f,    // edges of the rectangle
    steps: u32,         // samples a column
    near_steps: u32,    // marched before the map is asked
    near_m: f32,        // their reach
    part_m: f32,        // from look-up to look-up where a column may hold medium (spans.wgsl)
    shortest_step_m: f32,   // of a column whose steps are placed; 0 = any
#ifdef CASCADES
    camera_m: vec3f,        // from which the rectangles were laid
#endif
#ifdef FILL_FRAMES
    sun_direction: vec3f,   // for which the columns are marched
#endif
}

@group(2) @binding(0) var<uniform> map: Map;
@group(2) @binding(2) var map_texture: texture_2d_array<f32>;
@group(2) @binding(3) var map_sampler: sampler;

#ifdef CASCADES
const CASCADES: u32 = #{CASCADES}u;

struct Cascade {
    origin_m: vec2f,
    extent_m: vec2f,
    reach_m: f32,       // distance from the camera up to which it is asked
}

@group(2) @binding(12) var<storage, read> map_cascades: array<Cascade>;

var<private> cascade: u32;
#else
const CASCADES: u32 = 1u;
#endif

fn map_origin_m() -> vec2f {
#ifdef CASCADES
    return map_cascades[cascade].origin_m;
#else
    return map.origin_m;
#endif
}

fn map_extent_m() -> vec2f {
#ifdef CASCADES
    return map_cascades[cascade].extent_m;
#else
    return map.extent_m;
#endif
}

#ifdef FIT_WARPED
@group(2) @binding(11) var<storage, read> map_warp: array<vec2f>;   // W at the knots

const WARP_PARTS: u32 = 64u;

// Knots i.x of u and i.y of v.
fn knots(i: vec2u) -> vec2f {
#ifdef CASCADES
    let first = cascade * (WARP_PARTS + 1u);
    return vec2f(map_warp[first + i.x].x, map_warp[first + i.y].y);
#else
    return vec2f(map_warp[i.x].x, map_warp[i.y].y);
#endif
}

fn warped(position: vec2f) -> vec2f {
    let s = saturate(position) * f32(WARP_PARTS);
    let i = min(vec2u(s), vec2u(WARP_PARTS - 1u));
    return mix(knots(i), knots(i + 1u), s - vec2f(i));
}

fn unwarped(uv: vec2f) -> vec2f {
    var i = vec2u(0u);
    for (var step = WARP_PARTS / 2u; step > 0u; step /= 2u) {
        i += select(vec2u(0u), vec2u(step), knots(i + step) <= uv);
    }
    let low = knots(i);
    let high = knots(i + 1u);
    return (vec2f(i) + saturate((uv - low) / (high - low))) / f32(WARP_PARTS);
}
#endif

struct Tap {
    texel: vec2i,   // of the texture
    uv: vec2f,      // in the rectangle
}

// Position in the rectangle, outside [0, 1]² where the map knows nothing.
fn map_position(p: vec3f) -> vec2f {
    return (vec2f(dot(p, map.u_axis), dot(p, map.v_axis)) - map_origin_m()) / map_extent_m();
}

fn map_uv(position: vec2f) -> vec2f {
#ifdef FIT_WARPED
    return warped(position);
#else
    return position;
#endif
}

fn tap_at(uv: vec2f) -> Tap {
    return tap_of(vec2i(min(uv * f32(map.resolution), vec2f(f32(map.resolution) - 1.0))), uv);
}

// Tap of a texel of the rectangle.
fn tap_of(texel: vec2i, uv: vec2f) -> Tap {
#ifdef CASCADES
    return Tap(vec2i(texel.x, texel.y + i32(cascade * map.resolution)), uv);
#else
    return Tap(texel, uv);
#endif
}

// Texture coordinates of a place in the rectangle; at its edge a sampler reads no texel of the next rectangle.
fn texture_uv(uv: vec2f) -> vec2f {
#ifdef CASCADES
    let half_texel = 0.5 / f32(map.resolution);
    return vec2f(uv.x, (clamp(uv.y, half_texel, 1.0 - half_texel) + f32(cascade)) / f32(CASCADES));
#else
    return uv;
#endif
}

fn fetch(tap: Tap, layer: u32) -> vec4f {
#ifdef LOOKUP_HARDWARE
    return textureSampleLevel(map_texture, map_sampler, texture_uv(tap.uv), layer, 0.0);
#else
    return textureLoad(map_texture, tap.texel, layer, 0);
#endif
}

// The column through a point of the map: from the sun side to the end of the layer or the ground.
fn column_at(uv: vec2f) -> LayerRay {
#ifdef FIT_WARPED
    let plane = map_origin_m() + unwarped(uv) * map_extent_m();
#else
    let plane = map_origin_m() + uv * map_extent_m();
#endif
#ifdef FILL_FRAMES
    let sun_direction = map.sun_direction;
#else
    let sun_direction = frame.sun_direction;
#endif
    return layer_ray(plane.x * map.u_axis + plane.y * map.v_axis, -sun_direction, -1e30, 1e30);
}

// Length of the column whose values `fetch` returns.
fn column_length(tap: Tap) -> f32 {
#ifdef LOOKUP_HARDWARE
    return layer_length(column_at(tap.uv));
#else
    return layer_length(column_at(texel_uv(tap.texel)));
#endif
}

// Middle of a texel of the texture, in its rectangle.
fn texel_uv(texel: vec2i) -> vec2f {
#ifdef CASCADES
    let row = texel.y - i32(cascade * map.resolution);
    return (vec2f(f32(texel.x), f32(row)) + 0.5) / f32(map.resolution);
#else
    return (vec2f(texel) + 0.5) / f32(map.resolution);
#endif
}
