// Map pass: each invocation marches the light column of one texel and encodes it. A dispatch covers a tile of texels.
// WHOLE_TILES: a method's `encode` has barriers, between which the 8 × 8 texels of a workgroup share what they know.
// Cost: resolution² × steps density samples at most.
#import frame::tile
#import map::map
#import column::column_of
#import occlusion::encode
#ifdef COUNT
#import medium
@group(3) @binding(2) var<storage, read_write> counts: array<vec4u>;
#endif

@compute @workgroup_size(8, 8)
fn generate(@builtin(global_invocation_id) id: vec3u) {
    let texel = tile.origin + id.xy;
#ifdef WHOLE_TILES
    // All invocations meet at a barrier; beyond the map's edge they repeat the edge's texel.
    encode(column_of(min(texel, vec2u(map.resolution - 1u))));
#endif
    if any(id.xy >= tile.size) || any(texel >= vec2u(map.resolution)) {
        return;
    }
#ifndef WHOLE_TILES
    encode(column_of(texel));
#endif
#ifdef COUNT
    counts[texel.y * map.resolution + texel.x] = vec4u(medium::density_samples, 0u, 0u, 0u);
#endif
}
