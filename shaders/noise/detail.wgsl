// Detail texture, RGB: Worley noise of rising frequency (2, 4, 8 cells a tile, each with one more octave); tileable.
// Source: Schneider & Vos 2015. Cost: 108 hashes a texel, once a scene.
#import lattice::worley

struct Noise {
    seed: u32,
}

@group(0) @binding(0) var<uniform> noise: Noise;
@group(3) @binding(0) var texels: texture_storage_3d<rgba8unorm, write>;

@compute @workgroup_size(4, 4, 4)
fn detail(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(texels);
    if any(id >= size) {
        return;
    }
    let p = (vec3f(id) + 0.5) / vec3f(size);
    var octaves: array<f32, 4>;
    for (var j = 0; j < 4; j++) {
        let cells = 2 << u32(j);
        octaves[j] = worley(p * f32(cells), cells, noise.seed + 200u + u32(j));
    }
    textureStore(texels, id, vec4f(
        mix(octaves[0], octaves[1], 0.33), mix(octaves[1], octaves[2], 0.33), mix(octaves[2], octaves[3], 0.33), 1.0));
}
