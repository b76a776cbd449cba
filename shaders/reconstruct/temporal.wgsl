// Temporal integration, the pass after the march: pixels that were not marched in this frame take their values from the
// previous picture, reprojected (Schneider & Vos 2015, "The Real-time Volumetric Cloudscapes of Horizon Zero Dawn";
// thesis M, 3.1.7).
//
//   p' = (H·(i + ½, j + ½, 1) + e·q) / w   where the point at depth 1/q behind pixel (i, j) was; w: component 3
//
// H holds the rotation, e the translation of the camera (src/render/reconstruct/reprojection/device.rs). q is the
// inverse depth of the block's marched pixel: the reciprocal of the mean depth along the optical axis, with the weights
// of the march's light; 0 = infinitely far. p' is rounded to 1/256 pixel, the 8 bits that Direct3D asks of texture
// units, so that a camera at rest repeats pixels bit for bit; four neighbours are interpolated. History is rejected
//   - where there is no previous picture, and where p' lies outside the picture or behind either camera;
//   - where the previous camera looked in the opposite direction: it saw another side of the cloud;
//   - after a disocclusion: with the history's own inverse depth at p', this pixel is more than 1 pixel off p'.
// Rejected pixels are interpolated from the pixels marched in this frame.
// Cost: a dozen loads a pixel, no density samples.

#import subset::{Subset, is_marched}

struct Motion {
    turn_x: vec3f,      // columns of H
    turn_y: vec3f,
    turn_w: vec3f,
    shift: vec3f,       // e
    size: vec2u,        // of the picture
    remembers: u32,     // 1: there is a previous picture
}

@group(0) @binding(0) var<uniform> motion: Motion;
@group(0) @binding(1) var<storage, read> radiance_in: array<vec4f>;
@group(0) @binding(2) var<storage, read> sun_in: array<vec4f>;
@group(0) @binding(3) var<storage, read> inverse_depth_in: array<f32>;
@group(0) @binding(4) var<storage, read_write> radiance_out: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> sun_out: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> inverse_depth_out: array<f32>;
@group(0) @binding(7) var<uniform> subset: Subset;   // a rectangular grid: shear 0

const SUBPIXELS: f32 = 256.0;
// Reprojection error above which a pixel counts as disoccluded, pixels.
const DISOCCLUDED: f32 = 1.0;

// Four pixels and their weights.
struct Taps {
    index: vec4u,
    weight: vec4f,
}

// Reprojection of a pixel into the previous picture.
struct Past {
    at: vec2f,
    inverse_depth: f32,
    serves: bool,
}

fn index_of(pixel: vec2u) -> u32 {
    return pixel.y * motion.size.x + pixel.x;
}

// Bilinear taps among `size` points `stride` pixels apart, the first of them at `first`; `at` in points.
fn taps(at: vec2f, size: vec2u, first: vec2u, stride: vec2u) -> Taps {
    let low = floor(at);
    let part = at - low;
    let last = vec2i(size) - 1;
    let a = first + stride * vec2u(clamp(vec2i(low), vec2i(0), last));
    let b = first + stride * vec2u(clamp(vec2i(low) + 1, vec2i(0), last));
    let index = vec4u(index_of(a), index_of(vec2u(b.x, a.y)), index_of(vec2u(a.x, b.y)), index_of(b));
    let rest = 1.0 - part;
    return Taps(index, vec4f(rest.x * rest.y, part.x * rest.y, rest.x * part.y, part.x * part.y));
}

fn past_of(pixel: vec2u, inverse_depth: f32) -> Past {
    let far = motion.turn_x * (f32(pixel.x) + 0.5) + motion.turn_y * (f32(pixel.y) + 0.5) + motion.turn_w;
    let seen = far + motion.shift * inverse_depth;
    let at = round(seen.xy / seen.z * SUBPIXELS) / SUBPIXELS;
    if motion.remembers == 0u || !(seen.z > 0.0) || any(at < vec2f(0.0)) || any(at > vec2f(motion.size)) {
        return Past(at, 0.0, false);
    }
    // Position of the same pixel reprojected with the inverse depth that the history holds there.
    let held = inverse_depth_in[index_of(min(vec2u(at), motion.size - 1u))];
    let scale = 1.0 - motion.shift.z * held;
    let own = far.z * held / scale;
    let other = far + motion.shift * own;
    let agrees = distance(other.xy / other.z, at) <= DISOCCLUDED;
    return Past(at, own, scale > 0.0 && other.z > 0.0 && agrees);
}

@compute @workgroup_size(8, 8)
fn reconstruct(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= motion.size) || is_marched(subset, id.xy) {
        return;
    }
    let index = index_of(id.xy);
    let marched = (motion.size - subset.offset + subset.block - 1u) / subset.block;
    let nearest = min(id.xy / subset.block, marched - 1u);
    let inverse_depth = inverse_depth_out[index_of(subset.block * nearest + subset.offset)];
    let past = past_of(id.xy, inverse_depth);
    var radiance = vec4f(0.0);
    var sun = vec4f(0.0);
    if past.serves {
        let four = taps(past.at - 0.5, motion.size, vec2u(0u), vec2u(1u));
        for (var i = 0u; i < 4u; i++) {
            if four.weight[i] > 0.0 {
                radiance += four.weight[i] * radiance_in[four.index[i]];
                sun += four.weight[i] * sun_in[four.index[i]];
            }
        }
    } else {
        let at = (vec2f(id.xy) - vec2f(subset.offset)) / vec2f(subset.block);
        let four = taps(at, marched, subset.offset, subset.block);
        for (var i = 0u; i < 4u; i++) {
            if four.weight[i] > 0.0 {
                radiance += four.weight[i] * radiance_out[four.index[i]];
                sun += four.weight[i] * sun_out[four.index[i]];
            }
        }
    }
    radiance_out[index] = radiance;
    sun_out[index] = sun;
    inverse_depth_out[index] = select(inverse_depth, past.inverse_depth, past.serves);
}
