// Density: clouds from a weather map, Perlin–Worley shape noise and Worley erosion.
//
//   remap(v, a, b, c, d) = c + (v − a)(d − c)/(b − a)
//   shape = remap(R, fbm − 1, 1, 0, 1),  fbm = 0.625 G + 0.25 B + 0.125 A
//   base  = saturate(remap(shape·gradient(h, type), 1 − c, 1, 0, 1))·c,   c = saturate(weather.r + 2·coverage − 1)
//   density = saturate(remap(base, strength·m, 1, 0, 1)),  m = mix(e, 1 − e, saturate(10h)),  e = 0.625 R + 0.25 G + 0.125 B
//
// Sources: Schneider & Vos 2015 (SIGGRAPH Advances), Schneider 2017, Hillaire 2016, Häggström 2018.
// Erosion only removes, so occupancy computed without it is conservative (src/input/density/procedural/bounds.rs).
// Precipitation multiplies density by 1 + gain·weather.g where a scene names it.
// Cost: per deck one 2-D and one or two 3-D filtered fetches.
#import container::field_point
#import occupancy::grid_distance

// Vectors instead of arrays: the elements of an array in a uniform have a stride of 16 bytes.
struct Deck {
    profile: vec4f,  // base_m, top_m, cloud type where the map's type is 0, where it is 1
    cover: vec2f,    // calibrated threshold (not the covered share itself), offset into the weather map in periods
}

struct Field {
    weather_frequency_per_m: f32,
    shape_frequency_per_m: f32,
#ifdef DETAIL
    detail_frequency_per_m: f32,
    detail_strength: f32,
#endif
#ifdef PRECIPITATION
    precipitation_gain: f32,
#endif
    decks: array<Deck, #{DECKS}>,
}

@group(1) @binding(2) var<uniform> field: Field;
@group(1) @binding(3) var repeat: sampler;
@group(1) @binding(4) var weather: texture_2d<f32>;
@group(1) @binding(5) var shape: texture_3d<f32>;
#ifdef DETAIL
@group(1) @binding(6) var detail: texture_3d<f32>;
#endif

// Trapezoid of density against height fraction: ramps up over x…y, down over z…w (Häggström 2018; cumulus thins out
// from 0.45 instead of 0.78, which rounds its tops). procedural/bounds.rs holds the same numbers.
const STRATUS: vec4f = vec4f(0.02, 0.05, 0.09, 0.11);
const STRATOCUMULUS: vec4f = vec4f(0.02, 0.20, 0.48, 0.625);
const CUMULUS: vec4f = vec4f(0.0, 0.0625, 0.45, 1.0);

fn height_gradient(h: f32, cloud_type: f32) -> f32 {
    let low = mix(STRATUS, STRATOCUMULUS, saturate(2.0 * cloud_type));
    let ramp = mix(low, CUMULUS, saturate(2.0 * cloud_type - 1.0));
    return smoothstep(ramp.x, ramp.y, h) * (1.0 - smoothstep(ramp.z, ramp.w, h));
}

fn deck_density(q: vec3f, deck: Deck) -> f32 {
    let h = (q.y - deck.profile.x) / (deck.profile.y - deck.profile.x);
    if h <= 0.0 || h >= 1.0 {
        return 0.0;
    }
    let map = textureSampleLevel(weather, repeat, q.xz * field.weather_frequency_per_m + deck.cover.y, 0.0);
    let c = saturate(map.x + 2.0 * deck.cover.x - 1.0);
    let gradient = height_gradient(h, mix(deck.profile.z, deck.profile.w, map.z));
    if gradient <= 1.0 - c {
        return 0.0;
    }
    let noise = textureSampleLevel(shape, repeat, q * field.shape_frequency_per_m, 0.0);
    let fbm = dot(noise.yzw, vec3f(0.625, 0.25, 0.125));
    let billow = (noise.x - fbm + 1.0) / (2.0 - fbm);
    let base = saturate((billow * gradient - (1.0 - c)) / c) * c;
    if base <= 0.0 {
        return 0.0;
    }
    var result = base;
#ifdef DETAIL
    let fine = textureSampleLevel(detail, repeat, q * field.detail_frequency_per_m, 0.0);
    let e = dot(fine.xyz, vec3f(0.625, 0.25, 0.125));
    let erosion = field.detail_strength * mix(e, 1.0 - e, saturate(10.0 * h));
    result = saturate((base - erosion) / (1.0 - erosion));
#endif
#ifdef PRECIPITATION
    result *= 1.0 + field.precipitation_gain * map.y;
#endif
    return result;
}

// Density in field coordinates: horizontal x and z, height above ground as y.
fn field_density(q: vec3f) -> f32 {
    var result = 0.0;
    for (var i = 0; i < #{DECKS}; i++) {
        result = max(result, deck_density(q, field.decks[i]));
    }
    return result;
}

fn density(p: vec3f) -> f32 {
    return field_density(field_point(p));
}

fn empty_distance(p: vec3f) -> f32 {
    return grid_distance(field_point(p));
}
