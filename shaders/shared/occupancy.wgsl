// Empty space that may be skipped exactly. A grid of cubic cells (edge cell_m) over the density field, one byte a cell:
// 0 = may hold medium; d ≥ 1 = every cell within Chebyshev distance d − 1 is provably empty.
//
//   empty_distance = (d − 1)·cell + distance to the nearest face of the own cell;  −1 when the cell may hold medium
//
// A step of that length stays in empty cells: in field coordinates no axis advances faster than the ray.
// Cost: one 4-byte load.

struct Occupancy {
    size: vec3i,        // cells along x, y, z
    wrap: u32,          // 1: periodic in x and z
    origin_m: vec3f,
    cell_m: f32,
}

@group(1) @binding(0) var<uniform> occupancy: Occupancy;
@group(1) @binding(1) var<storage, read> occupancy_cells: array<u32>;

fn grid_distance(field: vec3f) -> f32 {
    let cell = (field - occupancy.origin_m) / occupancy.cell_m;
    let base = floor(cell);
    var index = vec3i(base);
    if occupancy.wrap == 1u {
        // In floats: vector units have no integer division. At a seam rounding may name the neighbour of the cell whose
        // face the point lies on, within the slack of the bounds (density/bounds.rs).
        let period = vec2f(occupancy.size.xz);
        let across = base.xz - period * floor(base.xz / period);
        let inner = clamp(vec2i(across), vec2i(0), occupancy.size.xz - 1);
        index = vec3i(inner.x, index.y, inner.y);
    }
    if any(index < vec3i(0)) || any(index >= occupancy.size) {
        return -1.0;
    }
    let linear = u32((index.z * occupancy.size.y + index.y) * occupancy.size.x + index.x);
    let word = occupancy_cells[linear / 4u];
    let rings = (word >> (8u * (linear % 4u))) & 255u;
    if rings == 0u {
        return -1.0;
    }
    let inside = min(cell - base, 1.0 - (cell - base));
    let margin = min(inside.x, min(inside.y, inside.z));
    // 1e-3 of a cell pays for the rounding of `cell`.
    return max(f32(rings - 1u) + margin - 1e-3, 0.0) * occupancy.cell_m;
}
