// Adaptive volumetric shadow map (AVSM), n nodes (depth/depth_m, T) of a column's transmittance, 2n values a texel.
//
//   nodes   (near edge, T) where medium begins, first with T = 1;  (far edge, T) of each step that holds medium
//   full    the interior node i goes whose removal changes the area below the curve least, that of the triangle
//               A_i = ½|(T_i − T_{i−1})(d_{i+1} − d_{i−1}) − (T_{i+1} − T_{i−1})(d_i − d_{i−1})|
//           the first and the last node stay, no node is moved
//   look-up T_0 before the first node, T of the last behind it; between two, x = (d − d_{i−1})/(d_i − d_{i−1}):
//               linear       T = T_{i−1} + (T_i − T_{i−1}) x
//               exponential  T = T_{i−1} (T_i/T_{i−1})^x: uniform medium between nodes
//
// Source: Salvi et al. 2010, Adaptive Volumetric Shadow Maps; linear as in their demo's look-up. Unused places repeat the
// last node; an empty column has T = 1 at depth 1. A step's edges are taken on its own side of a gap between spans.
// Cost: n − 1 areas for each step that holds medium; look-up ⌈n/2⌉ fetches and n − 1 interpolations.
#import map::{map, Tap, fetch}
#import column::{Column, sample_extinction, step_depth, store}
#import numerics::one_minus_exp_neg

const NODES: u32 = #{NODES}u;
const LAYERS: u32 = #{LAYERS}u;
const PADDED: u32 = #{PADDED}u;
// T below which a segment is black, the smallest number of f16.
const LEAST_T: f32 = 5.9604645e-8;
// Optical thickness from which a step holds medium.
const LEAST_THICKNESS: f32 = 1e-7;
#ifdef PLACEMENT_OCCUPIED
const INSIDE: f32 = 0.015625;   // steps
#endif

var<private> nodes: array<vec2f, #{PLACES}>;    // (depth, 1 − T), for T near 1 has no digits; one more than are kept
var<private> count: u32;

// Depth of a step's near edge, over depth_m.
fn near_edge(column: Column, k: u32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    // Read a little inside: a position on the edge of two spans could be on either side of the gap.
    let depth_m = step_depth(column, f32(k) + INSIDE) - INSIDE * column.step_m;
#else
    let depth_m = step_depth(column, f32(k));
#endif
    return depth_m / max(map.depth_m, 1e-20);
}

fn far_edge(column: Column, k: u32) -> f32 {
#ifdef PLACEMENT_OCCUPIED
    let depth_m = step_depth(column, f32(k + 1u) - INSIDE) + INSIDE * column.step_m;
#else
    let depth_m = step_depth(column, f32(k + 1u));
#endif
    return depth_m / max(map.depth_m, 1e-20);
}

// Twice the area that the curve loses or gains without node i.
fn area(i: u32) -> f32 {
    let own = nodes[i] - nodes[i - 1u];
    let across = nodes[i + 1u] - nodes[i - 1u];
    return abs(own.y * across.x - across.y * own.x);
}

fn insert(depth: f32, opacity: f32) {
    nodes[count] = vec2f(min(depth, 1.0), opacity);
    if count < NODES {
        count += 1u;
        return;
    }
    var least = 1u;
    var least_area = area(1u);
    for (var i = 2u; i < NODES; i++) {
        let own = area(i);
        if own < least_area {
            least = i;
            least_area = own;
        }
    }
    for (var i = least; i < NODES; i++) {
        nodes[i] = nodes[i + 1u];
    }
}

fn encode(column: Column) {
    let gap = 0.125 * column.step_m / max(map.depth_m, 1e-20);
    var tau = 0.0;
    var end = -1.0;     // of the medium so far
    for (var k = 0u; k < map.steps; k++) {
        let near = near_edge(column, k);
        let thickness = sample_extinction(column, k) * column.step_m;
        if thickness < LEAST_THICKNESS {
            continue;
        }
        if near > end + gap {
            insert(near, one_minus_exp_neg(tau));
        }
        tau += thickness;
        end = far_edge(column, k);
        insert(end, one_minus_exp_neg(tau));
    }
    for (var layer = 0u; layer < LAYERS; layer++) {
        store(column, layer, vec4f(kept(2u * layer), kept(2u * layer + 1u)));
    }
}

fn kept(i: u32) -> vec2f {
    if i >= NODES {
        return vec2f(0.0);
    }
    if count == 0u {
        return vec2f(1.0);
    }
    let node = nodes[min(i, count - 1u)];
    return vec2f(node.x, 1.0 - node.y);
}

fn between(a: vec2f, b: vec2f, depth: f32) -> f32 {
    let x = saturate((depth - a.x) / max(b.x - a.x, 1e-20));
#ifdef BETWEEN_EXPONENTIAL
    return a.y * exp(x * log(max(b.y, LEAST_T) / max(a.y, LEAST_T)));
#else
    return a.y + (b.y - a.y) * x;
#endif
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    var stored: array<vec2f, PADDED>;
    for (var layer = 0u; layer < LAYERS; layer++) {
        let two = fetch(tap, layer);
        stored[2u * layer] = two.xy;
        stored[2u * layer + 1u] = two.zw;
    }
    var t = stored[0].y;
    for (var i = 1u; i < NODES; i++) {
        if depth > stored[i - 1u].x {
            t = between(stored[i - 1u], stored[i], depth);
        }
    }
    return t;
}
