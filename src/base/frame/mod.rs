//! A rendered picture in linear radiance, and its files.

pub mod atomic;
mod exr_file;
mod exr_layers;
mod exr_read;
mod picture;
mod png_file;
mod tonemap;

pub use exr_file::write_frame;
pub use picture::{PictureFile, read_frame, read_picture};
pub use png_file::{FALSE_COLOUR_STOPS, false_colour, write_png};
pub use tonemap::{Exposure, tone_map};

use crate::error::{Error, Result};
use std::path::Path;

/// Largest picture that is read or compared, in pixels (16 384 × 16 384); checked before memory is taken.
pub const MAX_PIXELS: u64 = 1 << 28;

/// One render: `width × height` pixels, row 0 at the top, linear sRGB primaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGB = full radiance (sun, ambient, background); A = opacity of the medium in `[0, 1]`.
    pub radiance: Vec<[f32; 4]>,
    /// RGB = radiance of sunlight scattered once by the medium, nothing else;
    /// A = V, the light transmittance averaged over the view ray with weight σT (0 where there is no medium).
    pub sun: Vec<[f32; 4]>,
}

impl Frame {
    /// Refuses a frame that is empty, larger than [`MAX_PIXELS`], or whose planes do not hold `width × height` pixels.
    ///
    /// `place` names the frame in the message: a file, or "the reference".
    pub fn check(&self, place: &str) -> Result<()> {
        let pixels = check_size(place, self.width.into(), self.height.into())?;
        if self.radiance.len() == pixels && self.sun.len() == pixels {
            return Ok(());
        }
        let problem = format!(
            "{}×{} pixels announced, {} of radiance and {} of sunlight present",
            self.width,
            self.height,
            self.radiance.len(),
            self.sun.len()
        );
        Err(Error::input(place, problem, "Render the picture again."))
    }
}

/// Relative luminance of linear sRGB, same unit as the input (ITU-R BT.709-6, 2015, item 3.2).
pub fn luminance(rgb: [f32; 4]) -> f64 {
    0.2126 * f64::from(rgb[0]) + 0.7152 * f64::from(rgb[1]) + 0.0722 * f64::from(rgb[2])
}

/// Whether a value is NaN or infinite, read from its exponent bits (IEEE 754-2019 § 3.4) so that no
/// optimisation of float comparisons can hide it.
pub fn is_nonfinite(value: f32) -> bool {
    value.to_bits() & 0x7f80_0000 == 0x7f80_0000
}

/// Nearest-rank quantile: the ⌈q·n⌉-th smallest of `n` values, `q` in `(0, 1]`; `None` when there are none.
///
/// The result is always one of the values (Hyndman & Fan 1996, definition 1). Reorders `values`.
pub fn nearest_rank(values: &mut [f64], q: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let rank = (q * values.len() as f64).ceil() as usize;
    let index = rank.saturating_sub(1).min(last);
    Some(*values.select_nth_unstable_by(index, f64::total_cmp).1)
}

/// Number of pixels of a picture, refused when 0 or above [`MAX_PIXELS`].
fn check_size(place: &str, width: u64, height: u64) -> Result<usize> {
    let pixels = width
        .checked_mul(height)
        .filter(|n| (1..=MAX_PIXELS).contains(n));
    pixels.and_then(|n| usize::try_from(n).ok()).ok_or_else(|| {
        let problem =
            format!("{width}×{height} pixels, at least 1 and at most {MAX_PIXELS} can be used");
        Error::input(place, problem, "Give a picture of another size.")
    })
}

/// Refuses a picture that needs more bytes than its file can account for: `most` is what `file_bytes` bytes can hold.
fn check_backed(place: &str, needed: u64, most: u64, file_bytes: u64) -> Result<()> {
    if needed <= most {
        return Ok(());
    }
    let problem = format!(
        "the header announces {needed} bytes of pixels, a file of {file_bytes} bytes holds at most {most}"
    );
    Err(Error::input(
        place,
        problem,
        "The file is damaged or cut: copy or save it again.",
    ))
}

/// A path as messages show it.
fn shown(path: &Path) -> String {
    path.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_rank_follows_its_definition() {
        let mut hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(nearest_rank(&mut hundred, 0.99), Some(99.0));
        assert_eq!(nearest_rank(&mut hundred, 0.5), Some(50.0));
        assert_eq!(nearest_rank(&mut hundred, 1.0), Some(100.0));
        assert_eq!(nearest_rank(&mut [3.0, 1.0, 2.0], 0.95), Some(3.0));
        assert_eq!(nearest_rank(&mut [3.0, 1.0, 2.0], 0.01), Some(1.0));
        assert_eq!(nearest_rank(&mut [], 0.5), None);
    }

    #[test]
    fn nonfinite_by_bits() {
        for bad in [
            f32::NAN,
            -f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::from_bits(0x7f80_0001),
        ] {
            assert!(is_nonfinite(bad));
        }
        for good in [
            0.0,
            -0.0,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            f32::from_bits(1),
        ] {
            assert!(!is_nonfinite(good));
        }
    }

    #[test]
    fn white_has_luminance_one() {
        assert!((luminance([1.0, 1.0, 1.0, 0.0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn sizes_are_bounded() {
        assert_eq!(check_size("x", 16384, 16384).ok(), Some(1 << 28));
        for (width, height) in [(0, 5), (5, 0), (16384, 16385), (u64::MAX, 2)] {
            assert!(check_size("x", width, height).is_err());
        }
        let short = Frame {
            width: 2,
            height: 1,
            radiance: vec![[0.0; 4]; 2],
            sun: vec![[0.0; 4]],
        };
        assert!(
            short
                .check("the test")
                .unwrap_err()
                .to_string()
                .contains("2×1")
        );
    }
}
