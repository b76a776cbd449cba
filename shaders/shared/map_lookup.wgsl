// Light transmittance from a map: geometry, look-up rule and fallback; the method supplies `transmittance(tap, depth)`.
//
//   V(p) = transmittance(texel at p, d(p)/depth_m)
//   NEAR_MARCH: V(p) = exp(−Σ σΔ over the first r = min(near_m, d) metres toward the sun) · transmittance(…, (d − r)/depth_m)
//   MAP_VOLUME: V(p) = transmittance_at((u, v) of p, d(p)/depth_m): the sampler interpolates
//   FILL_FRAMES: the map may be that of earlier frames: d(p) is counted along the sun it was filled for
//   CASCADES: the first rectangle whose reach from the camera is not passed and that holds p; over the last tenth of its
//      reach, mixed with the next one (Dimitrov 2007, Cascaded Shadow Maps)
//   blend:  T at the four nearest texels, then bilinear in T (Reeves et al. 1987, percentage-closer filtering)
//
// Outside the rectangle (CASCADES: of all): secondary march with 6 quadratic steps, counted. depth_m = 0: V = 1.
// Cost: one distance to the layer's exit, one (blend: four) method look-ups (CASCADES: twice where mixed), near_steps density samples.
#import map::{map, map_position, map_uv, tap_at, tap_of}
#ifdef CASCADES
#import map::{cascade, map_cascades, CASCADES}
#endif
#import layer::layer_length
#ifdef FILL_FRAMES
#import container::layer_ray
#endif
#import medium
#import medium::sun_ray
#import secondary::{quadratic_depth, quadratic_march}
#ifdef MAP_VOLUME
#import occlusion::transmittance_at
#else
#import occlusion::transmittance
#endif

const FALLBACK_STEPS: u32 = 6u;

fn outside(position: vec2f) -> bool {
    return any(position < vec2f(0.0)) || any(position > vec2f(1.0));
}

#ifdef CASCADES
const BLEND_SHARE: f32 = 0.1;

fn choose_cascade(p: vec3f) {
    let away_m = distance(p, map.camera_m);
    for (cascade = 0u; cascade + 1u < CASCADES; cascade++) {
        if away_m < map_cascades[cascade].reach_m && !outside(map_position(p)) {
            return;
        }
    }
}

// T of the chosen cascade, mixed with that of the next one toward the end of its reach.
fn mixed_transmittance(p: vec3f, depth_m: f32) -> f32 {
    let near = far_transmittance(map_uv(map_position(p)), depth_m);
    let blend_m = BLEND_SHARE * map_cascades[cascade].reach_m;
    let share = saturate((distance(p, map.camera_m) - map_cascades[cascade].reach_m) / blend_m + 1.0);
    if cascade + 1u == CASCADES || share == 0.0 {
        return near;
    }
    cascade += 1u;
    let position = map_position(p);
    if outside(position) {
        return near;
    }
    return mix(near, far_transmittance(map_uv(position), depth_m), share);
}
#endif

fn light_transmittance(p: vec3f, rnd: f32) -> f32 {
#ifdef CASCADES
    choose_cascade(p);
#endif
    let position = map_position(p);
#ifdef COUNT
    medium::look_ups += 1u;
#endif
    if outside(position) {
#ifdef COUNT
        medium::fallbacks += 1u;
#endif
        return quadratic_march(p, FALLBACK_STEPS);
    }
    let ray = sun_ray(p);
#ifdef FILL_FRAMES
    let length_m = layer_length(layer_ray(p, map.sun_direction, 0.0, 1e30));
#else
    let length_m = layer_length(ray);
#endif
#ifdef NEAR_MARCH
    let near_m = min(map.near_m, layer_length(ray));
    let near = exp(-quadratic_depth(ray, near_m, map.near_steps));
    let far_m = max(length_m - near_m, 0.0);
#else
    let near = 1.0;
    let far_m = length_m;
#endif
#ifdef CASCADES
    return near * mixed_transmittance(p, far_m);
#else
    return near * far_transmittance(map_uv(position), far_m);
#endif
}

// Transmittance of the map at a depth in metres.
fn far_transmittance(uv: vec2f, depth_m: f32) -> f32 {
    if map.depth_m <= 0.0 {
        return 1.0;
    }
    let depth = depth_m / map.depth_m;
#ifdef MAP_VOLUME
    return transmittance_at(uv, depth);
#else ifdef LOOKUP_BLEND
    return blended(uv, depth);
#else
    return transmittance(tap_at(uv), depth);
#endif
}

#ifndef MAP_VOLUME
fn blended(uv: vec2f, depth: f32) -> f32 {
    let position = uv * f32(map.resolution) - 0.5;
    let low = floor(position);
    let w = position - low;
    let top = i32(map.resolution) - 1;
    let a = clamp(vec2i(low), vec2i(0), vec2i(top));
    let b = clamp(vec2i(low) + 1, vec2i(0), vec2i(top));
    let upper = mix(transmittance(tap_of(vec2i(a.x, a.y), uv), depth), transmittance(tap_of(vec2i(b.x, a.y), uv), depth), w.x);
    let lower = mix(transmittance(tap_of(vec2i(a.x, b.y), uv), depth), transmittance(tap_of(vec2i(b.x, b.y), uv), depth), w.x);
    return mix(upper, lower, w.y);
}
#endif
