// Absorbed-light quantiles (ALQ), K + 1 values a texel: A, z₁ … z_K, K = 2, 3 or 6.
//
//   A = 1 − T_end;  z_i = depth over depth_m at which the absorbed share (1 − T)/A of the column reaches q_i
//   V = 1 − A·Q(d),  Q piecewise linear through (z_i, q_i), first and last piece extended, clamped to [0, 1]
//
// A view ray reads a depth with weight σT, which is uniform in T: equal errors of Q cost equal light, so the values are
// spent on quantiles of absorbed light and not on depths. A crossing inside a step of constant σ is at
// (τ_i − τ)/(σΔ) of it, τ_i = −ln(1 − q_i A).
//
// Storage, beside floats and fractions of 16 bits, which keep the values as they are; bytes for K = 2, 3, 6:
//   packed   √A in 8 bits; z₁ in 16, K = 3: 10; √s_i in 8, K = 3: 7,  s_i = (z_i − z_{i−1})/(1 − z_{i−1}), z_{i−1} as stored;
//            roots, because most columns are long and most clouds are not. 4, 4 and 8 bytes
//            (Depths in 8 bits between the ends of 8 × 8 texels take 1/16 byte more, have the same error and need a barrier.)
//
// Source: this project; quantile functions: Parzen 1979. The shares q are constants, found numerically. RMS error of Q over
// homogeneous columns of τ = 0.3 … 30, and over columns of clouds, against the best shares there: K = 2 and 6 at most 12 %
// more; K = 3 30 and 15 %, of which pictures show 1 to 3 %.
// Cost: one column march of up to 128 steps, which are kept, or two of more; look-up ⌈(K + 1)/4⌉ fetches, no exponential;
// packed one fetch.
#import map::{map, Tap, fetch}
#import column::{Column, sample_extinction, step_depth, store}
#import numerics::one_minus_exp_neg
#ifdef STORAGE_PACKED
#import map_words::{store_words, fetch_words}
#endif

#ifdef QUANTILES_TWO
const K: u32 = 2u;
const SHARES: array<f32, K> = array<f32, K>(0.25, 0.75);
#else ifdef QUANTILES_SIX
const K: u32 = 6u;
const SHARES: array<f32, K> = array<f32, K>(0.10, 0.27, 0.45, 0.63, 0.80, 0.93);
#else
const K: u32 = 3u;
const SHARES: array<f32, K> = array<f32, K>(0.27, 0.66, 0.87);
#endif
const LAYERS: u32 = (K + 4u) / 4u;
// Narrowest piece, over depth_m: a front that falls into one step of storage is a step of Q.
const NARROWEST: f32 = 1e-6;

#ifdef KEPT_STEPS
var<private> kept: array<f32, #{KEPT_STEPS}>;
#endif

// τ at which a share of the absorbed light is absorbed: −ln(1 − x), by series where x is small.
fn depth_of_absorption(x: f32) -> f32 {
    let series = x * (1.0 + x * (0.5 + x * (1.0 / 3.0)));
    return select(-log(1.0 - x), series, x < 0.01);
}

fn encode(column: Column) {
    var whole = 0.0;
    for (var k = 0u; k < map.steps; k++) {
        let sigma = sample_extinction(column, k);
#ifdef KEPT_STEPS
        kept[k] = sigma;
#endif
        whole += sigma * column.step_m;
    }
    let absorbed = one_minus_exp_neg(whole);
    var values: array<f32, LAYERS * 4u>;
    values[0] = absorbed;
    for (var i = 1u; i <= K; i++) {
        values[i] = 1.0;
    }
    var shares = SHARES;
    var i = 0u;
    var tau = 0.0;
    for (var k = 0u; k < map.steps && i < K && whole > 0.0; k++) {
#ifdef KEPT_STEPS
        let sigma = kept[k];
#else
        let sigma = sample_extinction(column, k);
#endif
        let thickness = sigma * column.step_m;
        while i < K && thickness > 0.0 {
            let beyond = depth_of_absorption(shares[i] * absorbed) - tau;
            if beyond > thickness {
                break;
            }
            let depth_m = step_depth(column, f32(k) + max(beyond, 0.0) / thickness);
            values[i + 1u] = min(depth_m / max(map.depth_m, 1e-20), 1.0);
            i += 1u;
        }
        tau += thickness;
    }
    store_values(column, values);
}

#ifdef STORAGE_PACKED
#ifdef QUANTILES_THREE
const FRONT_BITS: u32 = 10u;
const SHARE_BITS: u32 = 7u;
#else
const FRONT_BITS: u32 = 16u;
const SHARE_BITS: u32 = 8u;
#endif

fn most(bits: u32) -> f32 {
    return f32((1u << bits) - 1u);
}

fn to_bits(value: f32, bits: u32) -> u32 {
    return u32(saturate(value) * most(bits) + 0.5);
}

fn from_bits(word: u32, first: u32, bits: u32) -> f32 {
    return f32(extractBits(word, first, bits)) / most(bits);
}

// The depth behind another, by the root of its share of what is left.
fn behind(depth: f32, root: f32) -> f32 {
    return depth + root * root * (1.0 - depth);
}

fn store_values(column: Column, values: array<f32, LAYERS * 4u>) {
    var z = values;
    let front = to_bits(z[1], FRONT_BITS);
    var words = vec4u(to_bits(sqrt(z[0]), 8u) | (front << 8u), 0u, 0u, 0u);
    var depth = f32(front) / most(FRONT_BITS);
    for (var i = 2u; i <= K; i++) {
        let root = to_bits(sqrt(max(z[i] - depth, 0.0) / max(1.0 - depth, 1e-20)), SHARE_BITS);
        depth = behind(depth, f32(root) / most(SHARE_BITS));
        let bit = 8u + FRONT_BITS + (i - 2u) * SHARE_BITS;
        words[bit / 32u] |= root << (bit % 32u);
    }
    store_words(column, 0u, words);
}
#else
fn store_values(column: Column, values: array<f32, LAYERS * 4u>) {
    var z = values;
    for (var layer = 0u; layer < LAYERS; layer++) {
        let j = 4u * layer;
        store(column, layer, vec4f(z[j], z[j + 1u], z[j + 2u], z[j + 3u]));
    }
}
#endif

// A, z₁, z₂, z₃ of a texel, and z₄, z₅, z₆.
struct Values {
    first: vec4f,
    second: vec4f,
}

fn values_of(tap: Tap) -> Values {
    var values: Values;
#ifdef STORAGE_PACKED
    let words = fetch_words(tap, 0u);
    let root = from_bits(words.x, 0u, 8u);
    let front = from_bits(words.x, 8u, FRONT_BITS);
    let next = behind(front, from_bits(words.x, 8u + FRONT_BITS, SHARE_BITS));
    values.first = vec4f(root * root, front, next, 1.0);
#ifdef QUANTILES_THREE
    values.first.w = behind(next, from_bits(words.x, 8u + FRONT_BITS + SHARE_BITS, SHARE_BITS));
#else ifdef QUANTILES_SIX
    let roots = unpack4x8unorm(words.y);
    values.first.w = behind(next, roots.x);
    values.second.x = behind(values.first.w, roots.y);
    values.second.y = behind(values.second.x, roots.z);
    values.second.z = behind(values.second.y, roots.w);
#endif
#else
    values.first = fetch(tap, 0u);
#ifdef QUANTILES_SIX
    values.second = fetch(tap, 1u);
#endif
#endif
    return values;
}

fn transmittance(tap: Tap, depth: f32) -> f32 {
    var shares = SHARES;
    let values = values_of(tap);
    let z = values.first.yzw;
    // The piece (z, q) … (z_next, q_next) that holds the depth, or the first or last one.
    var piece = vec4f(z.x, shares[0], z.y, shares[1]);
#ifndef QUANTILES_TWO
    piece = select(piece, vec4f(z.y, shares[1], z.z, shares[2]), depth > z.y);
#endif
#ifdef QUANTILES_SIX
    let more = values.second;
    piece = select(piece, vec4f(z.z, shares[2], more.x, shares[3]), depth > z.z);
    piece = select(piece, vec4f(more.x, shares[3], more.y, shares[4]), depth > more.x);
    piece = select(piece, vec4f(more.y, shares[4], more.z, shares[5]), depth > more.y);
#endif
    let slope = (piece.w - piece.y) / max(piece.z - piece.x, NARROWEST);
    return 1.0 - values.first.x * saturate(piece.y + (depth - piece.x) * slope);
}
