// Shared code of a method's own passes before or after the column pass: thread index and sample counters.
//
//   @compute @workgroup_size(8, 8)
//   fn an_entry_point(@builtin(global_invocation_id) id: vec3u) {
//       if !in_tile(id) {
//           return;
//       }
//       let at = place(id);   // x and y below the pass's threads
//       …
//       count_samples(at, threads_along_x);   // where it takes density samples
//   }
//
// Cost: nothing.
#import frame::tile
#ifdef COUNT
#import medium
@group(3) @binding(2) var<storage, read_write> counts: array<vec4u>;
#endif

fn in_tile(id: vec3u) -> bool {
    return all(id.xy < tile.size);
}

fn place(id: vec3u) -> vec2u {
    return tile.origin + id.xy;
}

fn count_samples(at: vec2u, threads_along_x: u32) {
#ifdef COUNT
    counts[at.y * threads_along_x + at.x] = vec4u(medium::density_samples, 0u, 0u, 0u);
#endif
}
