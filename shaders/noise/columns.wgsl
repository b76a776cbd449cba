// Optical depth of vertical columns over one weather tile, for the calibration of coverage.
//
//   τ(x, z) = Σ σ Δh over height, midpoints;  one invocation a column, spread evenly over the tile
//
// Columns run along y in field coordinates: on a shell, a straight column would leave the curved deck within one tile.
//
// Cost: `steps` density samples a column.
#import frame::frame
#import density::field_density

struct Columns {
    tile_m: f32,
    base_m: f32,
    top_m: f32,
    count: u32,      // columns along x and z
    steps: u32,
}

@group(0) @binding(5) var<uniform> columns: Columns;
@group(3) @binding(0) var<storage, read_write> optical_depth: array<f32>;

@compute @workgroup_size(8, 8)
fn measure(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= vec2u(columns.count)) {
        return;
    }
    let xz = (vec2f(id.xy) + 0.5) / f32(columns.count) * columns.tile_m;
    let step_m = (columns.top_m - columns.base_m) / f32(columns.steps);
    var tau = 0.0;
    for (var k = 0u; k < columns.steps; k++) {
        let height_m = columns.base_m + (f32(k) + 0.5) * step_m;
        tau += field_density(vec3f(xz.x, height_m, xz.y)) * frame.extinction_per_m * step_m;
    }
    optical_depth[id.y * columns.count + id.x] = tau;
}
