// Map pass: each invocation marches the light column of one texel and encodes it. A dispatch covers a tile of texels.
// FILL_FRAMES: a frame fills one part in n, every n-th row of workgroups, so that all parts cost about the same.
// Cost: resolution² × cascades × steps density samples at most.
#import frame::tile
#import map::{map, CASCADES}
#import column::column_of
#import occlusion::encode
#ifdef COUNT
#import medium
@group(3) @binding(2) var<storage, read_write> counts: array<vec4u>;
#endif

#ifdef FILL_FRAMES
const FRAMES: u32 = #{FILL_FRAMES}u;

// Row of the map from that of the dispatch, where the rows of one frame lie together. A multiple of 8·FRAMES rows.
fn spread_row(row: u32) -> u32 {
    let groups_a_frame = map.resolution * CASCADES / (8u * FRAMES);
    let group = row / 8u;
    return ((group % groups_a_frame) * FRAMES + group / groups_a_frame) * 8u + row % 8u;
}
#endif

@compute @workgroup_size(8, 8)
fn generate(@builtin(global_invocation_id) id: vec3u) {
    var texel = tile.origin + id.xy;
#ifdef FILL_FRAMES
    texel.y = spread_row(texel.y);
#endif
    if any(id.xy >= tile.size) || any(texel >= vec2u(map.resolution, map.resolution * CASCADES)) {
        return;
    }
    encode(column_of(texel));
#ifdef COUNT
    counts[texel.y * map.resolution + texel.x] = vec4u(medium::density_samples, 0u, 0u, 0u);
#endif
}
