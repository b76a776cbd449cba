// Optical-depth volume (ODV): τ at S depths of the map, in a 3-D texture, read with one trilinear fetch.
//
//   slice k holds τ(k/(S − 1)·depth_m);  V = exp(−τ), τ interpolated by the sampler between columns and depths
//   STORAGE_UNORM8: slice k holds √(min(τ, 8)/8); what is interpolated is the root, and e^(−8) is the darkest shadow
//
// Source: a light-space volume of optical depth as engines ship it, in one or two cascades; deep shadow maps without
// their compression at equal depths (Lokovic & Veach 2000). Cost: look-up one filtered fetch, one exponential.
#import map::map
#import column::Column
#import cumulative::optical_depth_before
#import map_volume::{sample_volume, store_voxel}

const SLICES: u32 = #{SLICES}u;
const LAST: f32 = f32(SLICES - 1u);
// f16 holds 65504, and exp(−6e4) is 0.
const LARGEST_TAU: f32 = 6e4;
const LARGEST_FRACTION_TAU: f32 = 8.0;

fn encode(column: Column) {
    for (var k = 0u; k < SLICES; k++) {
        let tau = optical_depth_before(column, f32(k) / LAST * map.depth_m);
#ifdef STORAGE_UNORM8
        store_voxel(column, k, vec4f(sqrt(saturate(tau / LARGEST_FRACTION_TAU))));
#else
        store_voxel(column, k, vec4f(min(tau, LARGEST_TAU)));
#endif
    }
}

fn transmittance_at(uv: vec2f, depth: f32) -> f32 {
    // The first and the last slice lie at depths 0 and 1, half a voxel inside the texture.
    let stored = sample_volume(uv, (depth * LAST + 0.5) / f32(SLICES)).x;
#ifdef STORAGE_UNORM8
    return exp(-stored * stored * LARGEST_FRACTION_TAU);
#else
    return exp(-stored);
#endif
}
