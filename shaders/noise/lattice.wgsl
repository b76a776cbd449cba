// Periodic lattice noise from integer hashes: the same bits on every adapter.
//
//   pcg: Jarzynski & Olano 2020, "Hash Functions for GPU Rendering" (pcg3d)
//   perlin(p, period) in [−1, 1]: gradient noise, 12 edge gradients, quintic fade (Perlin 2002)
//   worley(p, period) in [0, 1]: 1 − distance to the nearest feature point, one point a cell, 27 cells searched (Worley 1996)
//   *_fbm: octaves of doubled frequency with weights that sum to 1, so the range is kept
//
// p is in cells of the base frequency; period = cells a tile.

fn pcg(v: vec3u) -> vec3u {
    var r = v * 1664525u + 1013904223u;
    r.x += r.y * r.z;
    r.y += r.z * r.x;
    r.z += r.x * r.y;
    r ^= r >> vec3u(16u);
    r.x += r.y * r.z;
    r.y += r.z * r.x;
    r.z += r.x * r.y;
    return r;
}

fn lattice_hash(cell: vec3i, period: i32, seed: u32) -> vec3u {
    // −period ≤ cell < 2·period: no division, which costs more than the hash.
    let from_below = select(cell, cell + period, cell < vec3i(0));
    let wrapped = select(from_below, from_below - period, from_below >= vec3i(period));
    return pcg(vec3u(wrapped) + vec3u(seed, seed * 3u + 7u, seed * 5u + 11u));
}

fn edge_gradient(hash: u32, d: vec3f) -> f32 {
    let h = hash >> 28u;
    let u = select(d.y, d.x, h < 8u);
    let v = select(select(d.z, d.x, h == 12u || h == 14u), d.y, h < 4u);
    return select(-u, u, (h & 1u) == 0u) + select(-v, v, (h & 2u) == 0u);
}

fn perlin(p: vec3f, period: i32, seed: u32) -> f32 {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    var planes: array<f32, 2>;
    for (var z = 0; z < 2; z++) {
        var rows: array<f32, 2>;
        for (var y = 0; y < 2; y++) {
            let a = vec3i(0, y, z);
            let b = vec3i(1, y, z);
            rows[y] = mix(
                edge_gradient(lattice_hash(cell + a, period, seed).x, f - vec3f(a)),
                edge_gradient(lattice_hash(cell + b, period, seed).x, f - vec3f(b)), w.x);
        }
        planes[z] = mix(rows[0], rows[1], w.y);
    }
    return mix(planes[0], planes[1], w.z);
}

fn perlin_fbm(p: vec3f, period: i32, octaves: i32, seed: u32) -> f32 {
    var sum = 0.0;
    var weight = 1.0;
    var total = 0.0;
    var scale = 1;
    for (var i = 0; i < octaves; i++) {
        sum += weight * perlin(p * f32(scale), period * scale, seed + u32(i));
        total += weight;
        weight *= 0.5;
        scale *= 2;
    }
    return sum / total;
}

fn worley(p: vec3f, period: i32, seed: u32) -> f32 {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    var nearest = 4.0;
    for (var z = -1; z <= 1; z++) {
        for (var y = -1; y <= 1; y++) {
            for (var x = -1; x <= 1; x++) {
                let offset = vec3i(x, y, z);
                let hash = lattice_hash(cell + offset, period, seed);
                let d = vec3f(offset) + vec3f(hash >> vec3u(8u)) * (1.0 / 16777216.0) - f;
                nearest = min(nearest, dot(d, d));
            }
        }
    }
    return saturate(1.0 - sqrt(nearest));
}
