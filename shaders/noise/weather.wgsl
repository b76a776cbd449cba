// Weather map, RGB: coverage, precipitation, cloud type (0 stratus, 0.5 stratocumulus, 1 cumulus); tileable.
//
//   coverage       low-frequency Perlin × Worley (clumps and gaps), stretched over [0, 0.9]
//   precipitation  where coverage is high and a second Perlin is positive
//   type           low-frequency Perlin, raised where coverage is high
//
// Sources: Schneider & Vos 2015; thesis M. Cost: 161 hashes a texel, once a scene.
#import lattice::{perlin_fbm, worley}

struct Noise {
    seed: u32,
}

@group(0) @binding(0) var<uniform> noise: Noise;
@group(3) @binding(0) var texels: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn weather(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(texels);
    if any(id.xy >= size) {
        return;
    }
    let p = vec3f((vec2f(id.xy) + 0.5) / vec2f(size), 0.5);
    let seed = noise.seed;
    let clumps = 0.65 * worley(p * 6.0, 6, seed + 300u) + 0.25 * worley(p * 13.0, 13, seed + 301u) + 0.1 * worley(p * 29.0, 29, seed + 302u);
    let drift = 0.5 + 0.8 * perlin_fbm(p * 3.0, 3, 4, seed + 310u);
    let coverage = 0.9 * smoothstep(0.2, 0.85, 0.7 * clumps + 0.3 * drift);
    let rain = saturate(perlin_fbm(p * 4.0, 4, 3, seed + 320u) * 2.0);
    let kind = saturate(0.5 * perlin_fbm(p * 5.0, 5, 3, seed + 330u) + smoothstep(0.2, 0.8, coverage));
    textureStore(texels, id.xy, vec4f(coverage, rain * smoothstep(0.5, 0.9, coverage), kind, 1.0));
}
