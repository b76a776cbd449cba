// The spans of a ray through the layer that may hold medium, found in the occupancy grid.
//
//   at s: the provably empty sphere around it has radius r;  r ≥ ¼ part: on to s + r;  else [s, s + part) is occupied
//   position of x in [0, c] metres of the spans alone: s = start_i + (x − before_i), i the last span with before_i ≤ x
//
// Sequential: positions asked for in growing order cost an addition each. A ray has at most MOST_SPANS spans: the last one
// holds the gaps of what would be more.
// Cost: one unfiltered 3-D fetch, about half a density sample, for each occupied part, and one for each empty sphere.
#import layer::{LayerRay, point_at}
#import density::empty_distance

const MOST_PARTS: f32 = 512.0;
const LEAST_GAP: f32 = 0.25;    // parts
const MOST_SPANS: u32 = 16u;

var<private> spans: u32;
var<private> start_m: array<f32, MOST_SPANS>;
var<private> before_m: array<f32, MOST_SPANS>;     // metres of the spans before each
var<private> entered: u32;      // span of the last position
var<private> low_m: f32;        // positions in [low_m, high_m) are in it
var<private> high_m: f32;
var<private> shift_m: f32;      // gaps before them

// How far around s the ray is provably empty; below 0 where it may hold medium. Never across a gap of the layer.
fn empty_reach(ray: LayerRay, s: f32) -> f32 {
    let reach = empty_distance(point_at(ray, s));
    return min(reach, abs(ray.length_m.x - s));
}

// Finds the spans of the first length_m of a ray; their length in metres.
fn mark_occupied(ray: LayerRay, length_m: f32, wanted_part_m: f32) -> f32 {
    let part_m = max(wanted_part_m, length_m / MOST_PARTS);
    var s = 0.0;
    var end = -1.0;
    var total = 0.0;
    spans = 0u;
    low_m = 0.0;
    high_m = 0.0;
    while s < length_m {
        let reach = empty_reach(ray, s);
        if reach >= LEAST_GAP * part_m {
            s += reach;
            continue;
        }
        let next = min(s + part_m, length_m);
        if s > end {
            if spans < MOST_SPANS {
                start_m[spans] = s;
                before_m[spans] = total;
                spans += 1u;
            } else {
                total += s - end;
            }
        }
        total += next - s;
        end = next;
        s = next;
    }
    return total;
}

// Where on the ray x metres of its spans end. There must be one.
fn occupied_position(x: f32) -> f32 {
    if x < low_m || x >= high_m {
        enter(x);
    }
    return x + shift_m;
}

fn enter(x: f32) {
    if x < low_m || high_m == 0.0 {
        entered = 0u;
    }
    while entered + 1u < spans && x >= before_m[entered + 1u] {
        entered += 1u;
    }
    low_m = before_m[entered];
    high_m = 1e30;
    if entered + 1u < spans {
        high_m = before_m[entered + 1u];
    }
    shift_m = start_m[entered] - low_m;
}

// The inverse: metres of the spans, `total` in all, before a position on the ray.
fn occupied_before(position: f32, total: f32) -> f32 {
    var before = 0.0;
    for (var i = 0u; i < spans && start_m[i] < position; i++) {
        var end = total;
        if i + 1u < spans {
            end = before_m[i + 1u];
        }
        before = min(before_m[i] + position - start_m[i], end);
    }
    return before;
}
