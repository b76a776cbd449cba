// Light transmittance from a map: geometry, look-up rule and fallback; the method supplies `transmittance(tap, depth)`.
//
//   V(p) = transmittance(texel at p, d(p)/depth_m)
//   NEAR_MARCH: V(p) = exp(−Σ σΔ over the first r = min(near_m, d) metres toward the sun) · transmittance(…, (d − r)/depth_m)
//   MAP_VOLUME: V(p) = transmittance_at((u, v) of p, d(p)/depth_m): the sampler interpolates
//   blend:  T at the four nearest texels, then bilinear in T (Reeves et al. 1987, percentage-closer filtering)
//
// Outside the rectangle: secondary march with 6 quadratic steps, counted. depth_m = 0: V = 1.
// Cost: one distance to the layer's exit, one (blend: four) method look-ups, near_steps density samples.
#import map::{map, map_position, map_uv, tap_at, Tap}
#import layer::layer_length
#import medium
#import medium::sun_ray
#import secondary::{quadratic_depth, quadratic_march}
#ifdef MAP_VOLUME
#import occlusion::transmittance_at
#else
#import occlusion::transmittance
#endif

const FALLBACK_STEPS: u32 = 6u;

fn light_transmittance(p: vec3f, rnd: f32) -> f32 {
    let position = map_position(p);
#ifdef COUNT
    medium::look_ups += 1u;
#endif
    if any(position < vec2f(0.0)) || any(position > vec2f(1.0)) {
#ifdef COUNT
        medium::fallbacks += 1u;
#endif
        return quadratic_march(p, FALLBACK_STEPS);
    }
    let ray = sun_ray(p);
    let length_m = layer_length(ray);
#ifdef NEAR_MARCH
    let near_m = min(map.near_m, length_m);
    let near = exp(-quadratic_depth(ray, near_m, map.near_steps));
    return near * far_transmittance(map_uv(position), length_m - near_m);
#else
    return far_transmittance(map_uv(position), length_m);
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
    let upper = mix(transmittance(Tap(vec2i(a.x, a.y), uv), depth), transmittance(Tap(vec2i(b.x, a.y), uv), depth), w.x);
    let lower = mix(transmittance(Tap(vec2i(a.x, b.y), uv), depth), transmittance(Tap(vec2i(b.x, b.y), uv), depth), w.x);
    return mix(upper, lower, w.y);
}
#endif
