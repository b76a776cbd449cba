// Density: an imported volume that fills the box. Samples at cell centres, clamped:
//
//   u = (p − low)/(high − low),  texel coordinate = u·N − ½,  trilinear
//
// Interpolated by hand in f32: hardware weights have 8 bits, and r32float filtering is an optional feature.
// Cost: eight texel loads.
#import occupancy::grid_distance

struct Field {
    low_m: vec3f,
    high_m: vec3f,
}

@group(1) @binding(2) var<uniform> field: Field;
@group(1) @binding(3) var volume: texture_3d<f32>;

fn density(p: vec3f) -> f32 {
    let size = vec3f(textureDimensions(volume));
    let top = vec3i(textureDimensions(volume)) - 1;
    let texel = (p - field.low_m) / (field.high_m - field.low_m) * size - 0.5;
    let low = floor(texel);
    let w = texel - low;
    let a = clamp(vec3i(low), vec3i(0), top);
    let b = clamp(vec3i(low) + 1, vec3i(0), top);
    let front = mix(
        mix(value(vec3i(a.x, a.y, a.z)), value(vec3i(b.x, a.y, a.z)), w.x),
        mix(value(vec3i(a.x, b.y, a.z)), value(vec3i(b.x, b.y, a.z)), w.x), w.y);
    let back = mix(
        mix(value(vec3i(a.x, a.y, b.z)), value(vec3i(b.x, a.y, b.z)), w.x),
        mix(value(vec3i(a.x, b.y, b.z)), value(vec3i(b.x, b.y, b.z)), w.x), w.y);
    return mix(front, back, w.z);
}

fn value(texel: vec3i) -> f32 {
    return textureLoad(volume, texel, 0).x;
}

fn empty_distance(p: vec3f) -> f32 {
    return grid_distance(p);
}
