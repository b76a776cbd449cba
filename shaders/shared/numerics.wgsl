// Elementary functions WGSL lacks, and interleaved gradient noise.
//
//   one_minus_exp_neg(x) = 1 − e^(−x), x ≥ 0, relative error ≤ 2⁻²¹ for all x (a plain 1 − exp(−x) loses all digits near 0)
//   gradient_noise(pixel) in [0, 1): Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare"
//
// Cost: a few ALU operations each.

// T < 2⁻²⁴ cannot change an f32 sum of order 1: marches stop there.
const OPAQUE_TAU: f32 = 16.635532;
const OPAQUE_TRANSMITTANCE: f32 = 5.9604645e-8;

fn one_minus_exp_neg(x: f32) -> f32 {
    // Taylor: the first omitted term is x⁵/120, 2⁻²² of x at x = 0.1.
    let series = x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0))));
    return select(1.0 - exp(-x), series, x < 0.1);
}

fn gradient_noise(pixel: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
}
