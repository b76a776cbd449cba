// Occupancy grid, for exact skipping of empty space. Cubic cells (edge cell_m) over the density field, one byte a cell:
// 0 = may hold medium; d ≥ 1 = every cell within Chebyshev distance d − 1 is provably empty.
//
//   empty_distance = (d − 1)·cell + distance to the nearest face of the own cell;  −1 when the cell may hold medium
//
// A step of that length stays in empty cells: in field coordinates no axis advances faster than the ray.
// Cost: one unfiltered 3-D fetch, at a cell's centre so that rounding cannot pick a neighbour; the sampler wraps.

struct Occupancy {
    size: vec3f,        // cells along x, y, z
    wrap: u32,          // 1: periodic in x and z
    origin_m: vec3f,
    cell_m: f32,
}

@group(1) @binding(0) var<uniform> occupancy: Occupancy;
@group(1) @binding(1) var occupancy_cells: texture_3d<f32>;
@group(1) @binding(7) var occupancy_sampler: sampler;

fn grid_distance(field: vec3f) -> f32 {
    let cell = (field - occupancy.origin_m) / occupancy.cell_m;
    let base = floor(cell);
    let outside = (base < vec3f(0.0)) | (base >= occupancy.size);
    if outside.y || (occupancy.wrap == 0u && any(outside)) {
        return -1.0;
    }
    let stored = textureSampleLevel(occupancy_cells, occupancy_sampler, (base + 0.5) / occupancy.size, 0.0).x;
    let rings = round(255.0 * stored);
    if rings == 0.0 {
        return -1.0;
    }
    let inside = min(cell - base, 1.0 - (cell - base));
    let margin = min(inside.x, min(inside.y, inside.z));
    // 1e-3 of a cell covers the rounding of `cell`.
    return max(rings - 1.0 + margin - 1e-3, 0.0) * occupancy.cell_m;
}
