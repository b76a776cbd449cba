// A light map in a 3-D texture: columns along x and y, depth along z, read with one trilinear fetch.
//
//   slice k of S holds the column's value at depth (k + ½)/S; the method defines the depth range that 0…1 covers
//
// `encode` stores voxels; `transmittance_at(uv, depth)` of the method samples them.
// Cost: one filtered read.
#import map::{map_sampler, texture_uv}
#import column::Column

@group(2) @binding(7) var map_volume_texture: texture_3d<f32>;
@group(2) @binding(8) var map_volume_store: texture_storage_3d<
#ifdef TEXEL_R16
    r16float,
#else ifdef TEXEL_RG16
    rg16float,
#else ifdef TEXEL_R32
    r32float,
#else ifdef TEXEL_RG32
    rg32float,
#else ifdef TEXEL_RGBA32
    rgba32float,
#else ifdef TEXEL_R8UNORM
    r8unorm,
#else ifdef TEXEL_RG8UNORM
    rg8unorm,
#else ifdef TEXEL_RGBA8UNORM
    rgba8unorm,
#else ifdef TEXEL_R16UNORM
    r16unorm,
#else ifdef TEXEL_RG16UNORM
    rg16unorm,
#else ifdef TEXEL_RGBA16UNORM
    rgba16unorm,
#else
    rgba16float,
#endif
    write>;

fn store_voxel(column: Column, slice: u32, values: vec4f) {
    textureStore(map_volume_store, vec3u(column.texel, slice), values);
}

// Linear between the centres of voxels; level beyond the first and the last.
fn sample_volume(uv: vec2f, depth: f32) -> vec4f {
    return textureSampleLevel(map_volume_texture, map_sampler, vec3f(texture_uv(uv), depth), 0.0);
}
