// Ambient radiance at a sample, linear in height: a stand-in for multiple scattering. The same for every method.
// Cost: one height.
#import container::height_fraction

struct Ambient {
    base: vec3f,   // RGB radiance at the layer's base
    top: vec3f,    // and at its top
}

@group(0) @binding(4) var<uniform> ambient: Ambient;

fn ambient_radiance(p: vec3f) -> vec3f {
    return mix(ambient.base, ambient.top, height_fraction(p));
}
