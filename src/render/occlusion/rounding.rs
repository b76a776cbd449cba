//! Rounding to a device's number formats, emulated in f64.
//!
//! IEEE 754-2019 formats binary32 and binary16, round to nearest even; WGSL lets a device truncate stored f16 values and
//! flush denormals (WGSL § 15.7.2, § 15.7.6), so both are options.

use half::f16;

/// A number format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloatFormat {
    /// No rounding beyond the oracle's own.
    F64,
    /// binary32: largest 3.4e38, smallest normal 1.2e−38.
    F32,
    /// binary16: largest 65504, smallest normal 6.1e−5.
    F16,
    /// k/255 in 0…1 (WebGPU's `unorm8`).
    Unorm8,
    /// k/65535 in 0…1.
    Unorm16,
    /// Words that a method packs; its twin does the rounding, see [`super::twin::Encoding::stored`].
    Packed,
}

/// Rounding at the places where a device rounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounding {
    /// Format of a map's stored values.
    pub storage: FloatFormat,
    /// Format of a method's arithmetic before it stores and after it loads; each operation is rounded.
    pub arithmetic: FloatFormat,
    /// Denormals of both become 0 with their sign.
    pub flush_denormals: bool,
    /// Stored f16 values are cut off instead of rounded to nearest: what llvmpipe does. Finite values then stay finite.
    pub truncate_f16: bool,
}

impl Rounding {
    /// f64 throughout.
    pub const EXACT: Self = Self {
        storage: FloatFormat::F64,
        arithmetic: FloatFormat::F64,
        flush_denormals: false,
        truncate_f16: false,
    };

    /// f32 arithmetic, storage as named by a method's `storage` parameter (`f16`, otherwise f32).
    pub fn device(storage: &str, flush_denormals: bool) -> Self {
        Self {
            storage: if storage == "f16" {
                FloatFormat::F16
            } else {
                FloatFormat::F32
            },
            arithmetic: FloatFormat::F32,
            flush_denormals,
            truncate_f16: false,
        }
    }

    /// The result of one operation.
    pub fn computed(&self, value: f64) -> f64 {
        self.round(value, self.arithmetic)
    }

    /// A value written to a map and read back.
    pub fn stored(&self, value: f64) -> f64 {
        self.round(value, self.storage)
    }

    fn round(&self, value: f64, format: FloatFormat) -> f64 {
        let (rounded, smallest_normal) = match format {
            FloatFormat::F64 => (value, f64::MIN_POSITIVE),
            FloatFormat::F32 => (f64::from(value as f32), f64::from(f32::MIN_POSITIVE)),
            FloatFormat::F16 => (self.half(value), f16::MIN_POSITIVE.to_f64()),
            FloatFormat::Unorm8 => return fraction(value, 255.0),
            FloatFormat::Unorm16 => return fraction(value, 65_535.0),
            FloatFormat::Packed => return value,
        };
        if self.flush_denormals && rounded.abs() < smallest_normal {
            return 0.0_f64.copysign(rounded);
        }
        rounded
    }

    fn half(&self, value: f64) -> f64 {
        let nearest = f16::from_f64(value);
        let away = nearest.to_f64().abs() > value.abs();
        if self.truncate_f16 && away && value.is_finite() {
            // The neighbour toward zero has the next smaller bit pattern.
            return f16::from_bits(nearest.to_bits() - 1).to_f64();
        }
        nearest.to_f64()
    }
}

/// The nearest k/`most` in 0…1, `most` = 2ⁿ − 1: a value after storage in a `unorm` texture.
pub fn fraction(value: f64, most: f64) -> f64 {
    (value.clamp(0.0, 1.0) * most).round() / most
}

#[cfg(test)]
mod tests {
    use super::*;

    const F16: Rounding = Rounding {
        storage: FloatFormat::F16,
        ..Rounding::EXACT
    };

    #[test]
    fn halves_round_to_nearest_even_and_overflow() {
        for (value, expected) in [
            (1.0 + 2f64.powi(-11), 1.0),
            (1.0 + 3.0 * 2f64.powi(-11), 1.0 + 2f64.powi(-9)),
            (65_519.0, 65_504.0),
            (65_520.0, f64::INFINITY),
            (-70_000.0, f64::NEG_INFINITY),
            (2f64.powi(-24), 2f64.powi(-24)),
            (0.0, 0.0),
        ] {
            assert_eq!(F16.stored(value), expected, "{value}");
        }
        assert!(F16.stored(f64::NAN).is_nan());
    }

    #[test]
    fn fractions_end_at_0_and_1_and_packed_words_are_left_to_their_method() {
        let stored = |storage, value| {
            let rounding = Rounding {
                storage,
                ..Rounding::EXACT
            };
            rounding.stored(value)
        };
        for (value, expected) in [
            (-1.0, 0.0),
            (0.3, 77.0 / 255.0),
            (0.499_99, 127.0 / 255.0),
            (7.0, 1.0),
        ] {
            assert_eq!(stored(FloatFormat::Unorm8, value), expected, "{value}");
        }
        assert_eq!(stored(FloatFormat::Unorm16, 0.3), 19_661.0 / 65_535.0);
        assert_eq!(stored(FloatFormat::Packed, 0.3), 0.3);
    }

    #[test]
    fn truncation_never_grows_a_value() {
        let cut = Rounding {
            truncate_f16: true,
            ..F16
        };
        for value in [1.0 + 2f64.powi(-11) * 1.9, 65_530.0, 1e9, 1e-7, 0.3] {
            assert!(cut.stored(value) <= value, "{value}");
            assert_eq!(cut.stored(-value), -cut.stored(value));
            assert!(cut.stored(value) >= value.min(65_504.0) * (1.0 - 2f64.powi(-10)) - 6e-8);
        }
        assert_eq!(cut.stored(1e9), 65_504.0);
        assert_eq!(cut.stored(f64::INFINITY), f64::INFINITY);
    }

    #[test]
    fn denormals_flush_with_their_sign() {
        let flush = Rounding {
            flush_denormals: true,
            ..Rounding::device("f16", true)
        };
        assert_eq!(flush.stored(6.0e-5), 0.0);
        assert!(flush.stored(-6.0e-5).is_sign_negative());
        assert!(flush.stored(6.2e-5) > 6.1e-5);
        assert_eq!(flush.computed(1e-38), 0.0);
        assert!(Rounding::device("f16", false).computed(1e-38) > 0.0);
        assert_eq!(Rounding::EXACT.computed(1e-300), 1e-300);
    }
}
