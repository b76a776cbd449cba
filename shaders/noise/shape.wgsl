// Shape texture, RGBA: R = Perlin–Worley, G, B, A = Worley fBm of rising frequency; tileable.
//
//   W_j = worley at 4·2^j cells a tile, j = 0…3;  fBm_j = 0.625 W_j + 0.25 W_{j+1} + 0.125 W_{j+2}, W_{j>3} := W_3
//   R = remap(Perlin fBm in [0, 1], 0, 1, fBm_0, 1): Worley dilates Perlin, connected and billowy; stretched over [0, 1]
//   G, B, A = fBm_1, fBm_2, fBm_3
//
// Source: Schneider & Vos 2015. Finer octaves would have fewer than 4 texels a cell. Cost: at most 108 hashes for Worley
// and 32 for Perlin a texel, once a scene.
#import lattice::{perlin_fbm, worley}

struct Noise {
    seed: u32,
}

@group(0) @binding(0) var<uniform> noise: Noise;
@group(3) @binding(0) var texels: texture_storage_3d<rgba8unorm, write>;

@compute @workgroup_size(4, 4, 4)
fn shape(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(texels);
    if any(id >= size) {
        return;
    }
    let p = (vec3f(id) + 0.5) / vec3f(size);
    var octaves: array<f32, 6>;
    for (var j = 0; j < 4; j++) {
        let cells = 4 << u32(j);
        octaves[j] = worley(p * f32(cells), cells, noise.seed + 100u + u32(j));
    }
    octaves[4] = octaves[3];
    octaves[5] = octaves[3];
    var fbm: array<f32, 4>;
    for (var j = 0; j < 4; j++) {
        fbm[j] = 0.625 * octaves[j] + 0.25 * octaves[j + 1] + 0.125 * octaves[j + 2];
    }
    // Perlin fBm stays inside about ±0.6: stretch it over the unit range.
    let base = saturate(0.5 + 0.8 * perlin_fbm(p * 4.0, 4, 4, noise.seed));
    // Perlin–Worley stays above about 0.45: stretch it, or every cloud fills its whole column.
    let billow = saturate((mix(fbm[0], 1.0, base) - 0.45) / 0.55);
    textureStore(texels, id, vec4f(billow, fbm[1], fbm[2], fbm[3]));
}
