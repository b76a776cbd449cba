//! Pure functions on f32 images: how far a picture is from its truth.
//!
//! Rules that hold for every number here:
//! - Linear numbers use [`Frame::sun`] and the **cloud pixels**: those whose opacity *in the reference* exceeds
//!   [`CLOUD_OPACITY`]. Perceptual numbers use the tone-mapped radiance of the whole picture. Sums are in f64.
//! - **A NaN or infinite channel of the test counts as error**: linear numbers read it as 0 (black, opaque), the tone
//!   map paints its pixel magenta, and `nonfinite` counts it. No result is ever NaN.
//! - **A reference that cannot serve is refused**: one with a NaN or infinite channel, without a cloud pixel, or
//!   without sunlight on them, since relative errors would have no scale.

mod difference;
mod flicker;
mod ghosting;
mod linear;
mod metric;
mod pair;
mod perceptual;
mod refusal;
mod ssim;
mod stats;
mod table;

pub use difference::{
    DIFF_SCALE, delta_luminance, delta_rgb, difference, difference_picture, relative_rmse,
};
pub use flicker::Flicker;
pub use ghosting::ghosting;
pub use linear::mean_sun;
pub use metric::{Better, Format, Group, Metric, Origin, Recorded};
pub use perceptual::PIXELS_PER_DEGREE;
pub use refusal::{Incomparable, Unlit};
pub use stats::{Stats, Thirds, summarise, thirds};
pub use table::{ErrorNumbers, METRICS, arranged, metric};

use crate::error::{Error, Result};
use crate::frame::{Frame, is_nonfinite};
use pair::Pair;

/// Opacity above which a pixel of the reference is a cloud pixel.
pub const CLOUD_OPACITY: f32 = 0.01;

/// Opacity up to which a cloud pixel of the reference is an edge pixel: translucent cloud.
pub const EDGE_OPACITY: f32 = 0.9;

/// Result of [`compare`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// The numbers; those that need further renders (every [`Origin`] but [`Origin::Pair`]) are `None`.
    pub error: ErrorNumbers,
    /// Cloud pixels / pixels, in `(0, 1]`.
    pub cloud_pixel_fraction: f64,
}

/// Compares a picture with its truth, at one exposure taken from the truth.
///
/// [`METRICS`] and the fields of [`ErrorNumbers`] define the numbers, with L the sun-lit radiance of the reference,
/// ΔL = test − reference and sums over the RGB channels of the cloud pixels. Edge pixels: see [`EDGE_OPACITY`].
pub fn compare(reference: &Frame, test: &Frame) -> Result<Comparison, Incomparable> {
    let pair = Pair::new(reference, test)?;
    Ok(Comparison {
        error: ErrorNumbers::of_pair(&pair),
        cloud_pixel_fraction: pair.linear.cloud_pixel_fraction,
    })
}

/// NaN or infinite channels of a frame, in radiance (with opacity) and sun (with V).
fn nonfinite(frame: &Frame) -> u64 {
    let channels = frame.radiance.iter().chain(&frame.sun).flatten();
    channels.filter(|v| is_nonfinite(**v)).count() as u64
}

/// Refuses pictures that cannot be compared: broken planes, different sizes, a broken truth.
fn check_pair(reference: &Frame, test: &Frame) -> Result<(), Incomparable> {
    reference.check("the reference")?;
    test.check("the test picture")?;
    if (reference.width, reference.height) != (test.width, test.height) {
        let problem = format!(
            "{}×{} pixels, the reference has {}×{}",
            test.width, test.height, reference.width, reference.height
        );
        return Err(Error::input(
            "the test picture",
            problem,
            "Compare pictures of the same size.",
        )
        .into());
    }
    match nonfinite(reference) {
        0 => Ok(()),
        channels => Err(Incomparable::NotFinite(channels)),
    }
}

/// Frames for the tests of this folder.
#[cfg(test)]
mod testing {
    use crate::frame::Frame;

    /// A smooth, textured cloud of opacity 1 over the left three quarters of the picture, sky (opacity 0) elsewhere.
    pub fn cloud(width: u32, height: u32) -> Frame {
        let pixel = |i: u32| {
            let (x, y) = ((i % width) as f32, (i / width) as f32);
            let v = 0.5 + 0.3 * (x * 0.37).sin() * (y * 0.23).cos();
            if 4 * (i % width) < 3 * width {
                [v, 0.9 * v, 0.8 * v, 1.0]
            } else {
                [0.1, 0.2, 0.4, 0.0]
            }
        };
        let radiance: Vec<[f32; 4]> = (0..width * height).map(pixel).collect();
        let sun = radiance
            .iter()
            .map(|&[r, g, b, a]| [r * a, g * a, b * a, 0.5 * a])
            .collect();
        Frame {
            width,
            height,
            radiance,
            sun,
        }
    }

    /// A uniform cloud of sun-lit radiance `level` and V = `level`.
    pub fn uniform(width: u32, height: u32, level: f32) -> Frame {
        let pixels = (width * height) as usize;
        Frame {
            width,
            height,
            radiance: vec![[level, level, level, 1.0]; pixels],
            sun: vec![[level; 4]; pixels],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{cloud, uniform};
    use super::*;

    #[test]
    fn identical_pictures_have_no_error() {
        let frame = cloud(48, 32);
        let got = compare(&frame, &frame).unwrap();
        for metric in METRICS {
            let perfect = match metric.better {
                Better::Lower | Better::Zero => 0.0,
                Better::Higher => metric.range[1],
            };
            let value = (metric.get)(&got.error);
            assert!(value.is_none_or(|value| value == perfect), "{metric:?}");
        }
        assert_eq!(got.cloud_pixel_fraction, 0.75);
    }

    #[test]
    fn constant_offset_is_seen_by_every_number() {
        let got = compare(&uniform(32, 32, 0.5), &uniform(32, 32, 0.6))
            .unwrap()
            .error;
        for value in [got.rel_rmse, got.bias, got.leak, got.p99_abs, got.max_abs] {
            assert!((value - 0.2).abs() < 1e-6, "{value}");
        }
        assert_eq!(got.darken, 0.0);
        assert!((got.transmittance_rmse - 0.1).abs() < 1e-6);
        assert!(got.flip_mean > 0.01 && (got.flip_p99 - got.flip_mean).abs() < 1e-3);
        assert!(got.psnr_db.unwrap() < 40.0 && got.ssim < 1.0);
        assert_eq!(got.nonfinite, 0);
    }

    #[test]
    fn more_error_is_worse_in_every_number() {
        let truth = cloud(48, 32);
        let dimmed = |factor: f32| {
            let mut frame = truth.clone();
            for pixel in frame
                .radiance
                .iter_mut()
                .chain(&mut frame.sun)
                .skip(3)
                .step_by(2)
            {
                pixel.iter_mut().take(3).for_each(|v| *v *= factor);
            }
            compare(&truth, &frame).unwrap().error
        };
        let (small, large) = (dimmed(0.95), dimmed(0.6));
        assert!(small.rel_rmse < large.rel_rmse && small.flip_mean < large.flip_mean);
        assert!(small.psnr_db > large.psnr_db && small.ssim > large.ssim);
        assert!(small.darken > large.darken && large.leak == 0.0);
        for metric in METRICS {
            let [small, large] = [small, large].map(|numbers| (metric.get)(&numbers));
            let badness = |value: f64| match metric.better {
                Better::Lower => value,
                Better::Higher => -value,
                Better::Zero => value.abs(),
            };
            assert!(small.map(badness) <= large.map(badness), "{metric:?}");
            let possible = |value: f64| (metric.range[0]..=metric.range[1]).contains(&value);
            assert!(
                small.is_none_or(possible) && large.is_none_or(possible),
                "{metric:?}"
            );
        }
    }

    #[test]
    fn broken_pixels_count_as_errors_and_never_as_nan() {
        let truth = cloud(48, 32);
        let mut broken = truth.clone();
        broken.sun[0] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        broken.radiance[0][0] = f32::NAN;
        let got = compare(&truth, &broken).unwrap().error;
        assert_eq!(got.nonfinite, 5);
        assert!(
            got.rel_rmse > 0.0
                && got.darken < 0.0
                && got.transmittance_rmse > 0.0
                && got.flip_mean > 0.0
        );
        let numbers = METRICS.iter().filter_map(|metric| (metric.get)(&got));
        assert!(numbers.into_iter().all(f64::is_finite));
        let mut all = truth.clone();
        all.sun.fill([f32::NAN; 4]);
        let all = compare(&truth, &all).unwrap().error;
        assert!((all.rel_rmse - 1.0).abs() < 1e-12 && (all.bias + 1.0).abs() < 1e-12);
    }

    #[test]
    fn unusable_pairs_are_errors() {
        let truth = cloud(16, 8);
        let refused =
            |reference: &Frame, test: &Frame| match compare(reference, test).map_err(Error::from) {
                Err(e @ Error::Input { .. }) => e.to_string(),
                other => panic!("{other:?}"),
            };
        assert!(refused(&truth, &cloud(8, 16)).contains("8×16 pixels, the reference has 16×8"));
        let mut short = truth.clone();
        short.sun.pop();
        assert!(refused(&truth, &short).contains("the test picture"));
        let mut broken = truth.clone();
        broken.radiance[3][1] = f32::NAN;
        assert!(refused(&broken, &truth).contains("1 channels are NaN"));
        let mut clear = truth.clone();
        clear.radiance.iter_mut().for_each(|p| p[3] = 0.01);
        assert!(refused(&clear, &truth).contains("no pixel"));
        assert!(refused(&uniform(4, 4, 0.0), &uniform(4, 4, 0.1)).contains("no sunlight"));
    }

    #[test]
    fn one_pixel_can_be_compared() {
        let got = compare(&uniform(1, 1, 0.5), &uniform(1, 1, 0.25))
            .unwrap()
            .error;
        assert!((got.bias + 0.5).abs() < 1e-9 && got.ssim < 1.0 && got.flip_mean > 0.0);
    }
}
