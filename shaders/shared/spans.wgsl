// The part of a ray through the layer that may hold medium, found in the occupancy grid, as a row of P bits.
//
//   P = ⌈L/part_m⌉, at most MOST_PARTS;  part i = [i, i + 1]·L/P
//   empty: covered whole by a provably empty sphere around its own middle or that of a part before it
//   position of x in [0, c] occupied parts: x travels through the occupied parts alone, c of them
//
// Sequential: positions asked for in growing order cost a few bit operations each.
// Cost: one unfiltered 3-D fetch for each occupied part, and one for each empty sphere.
#import layer::{LayerRay, layer_length, point_at}
#import density::empty_distance

const MOST_PARTS: u32 = 512u;
const WORDS: u32 = 16u;

var<private> parts: u32;                    // P
var<private> occupied: array<u32, WORDS>;   // bit i % 32 of word i / 32: part i
var<private> word: u32;                     // where the last position was found
var<private> passed: u32;                   // occupied parts before it
var<private> rest: u32;                     // bits of the word that are not passed

// How far around s the ray is provably empty; below 0 where it may hold medium. Never across a gap of the layer.
fn empty_reach(ray: LayerRay, s: f32) -> f32 {
    let reach = empty_distance(point_at(ray, s));
    return min(reach, abs(ray.length_m.x - s));
}

// Marks the occupied parts of a ray of length_m; their number.
fn mark_occupied(ray: LayerRay, length_m: f32, longest_part_m: f32) -> u32 {
    parts = u32(clamp(ceil(length_m / max(longest_part_m, 1e-20)), 1.0, f32(MOST_PARTS)));
    let part_m = length_m / f32(parts);
    for (var w = 0u; w < WORDS; w++) {
        occupied[w] = 0u;
    }
    var count = 0u;
    var i = 0u;
    while i < parts && length_m > 0.0 {
        let reach = empty_reach(ray, (f32(i) + 0.5) * part_m) / part_m - 0.5;
        if reach < 0.0 {
            occupied[i / 32u] |= 1u << (i % 32u);
            count += 1u;
            i += 1u;
        } else {
            i += 1u + u32(min(reach, 65536.0));
        }
    }
    restart();
    return count;
}

fn restart() {
    word = 0u;
    passed = 0u;
    rest = occupied[0];
}

// Where x of `count` > 0 occupied parts lies, in parts of the whole ray.
fn occupied_position(x: f32, count: u32) -> f32 {
    let wanted = min(u32(max(x, 0.0)), count - 1u);
    if wanted < passed {
        restart();
    }
    while passed + countOneBits(rest) <= wanted {
        passed += countOneBits(rest);
        word += 1u;
        rest = occupied[word];
    }
    while passed < wanted {
        rest &= rest - 1u;
        passed += 1u;
    }
    return f32(word * 32u + firstTrailingBit(rest)) + (x - f32(wanted));
}

// The inverse: occupied parts before a position in parts of the whole ray.
fn occupied_before(position: f32) -> f32 {
    let i = min(u32(max(position, 0.0)), parts - 1u);
    var count = 0u;
    for (var w = 0u; w < i / 32u; w++) {
        count += countOneBits(occupied[w]);
    }
    let own = occupied[i / 32u];
    let bit = 1u << (i % 32u);
    count += countOneBits(own & (bit - 1u));
    return f32(count) + select(0.0, saturate(position - f32(i)), (own & bit) != 0u);
}
