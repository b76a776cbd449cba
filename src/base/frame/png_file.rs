//! PNG files: written as 8-bit sRGB for viewing, read with 8 or 16 bits for comparisons.

use super::atomic::write_atomic;
use super::{Frame, MAX_PIXELS, check_backed, check_size, shown};
use crate::error::{Error, Result};
use image::codecs::png::{PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, Limits};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Colours of [`false_colour`]: position in `[−1, 1]` (difference / scale) and sRGB colour, linear between the stops.
///
/// Blue is too dark, white is equal, red is too bright (leaked light). The scheme is RdBu reversed, with a pure white
/// centre; its ends stay apart under the common colour-vision deficiencies (Harrower & Brewer, "ColorBrewer.org", The
/// Cartographic Journal 40(1), 2003).
pub const FALSE_COLOUR_STOPS: [(f32, [u8; 3]); 11] = [
    (-1.0, [5, 48, 97]),
    (-0.8, [33, 102, 172]),
    (-0.6, [67, 147, 195]),
    (-0.4, [146, 197, 222]),
    (-0.2, [209, 229, 240]),
    (0.0, [255, 255, 255]),
    (0.2, [253, 219, 199]),
    (0.4, [244, 165, 130]),
    (0.6, [214, 96, 77]),
    (0.8, [178, 24, 43]),
    (1.0, [103, 0, 31]),
];

/// Colour of a pixel that is NaN or infinite, in false colour and after tone mapping.
pub(super) const MAGENTA: [u8; 3] = [255, 0, 255];

/// Writes 8-bit sRGB, three bytes a pixel, rows from the top. Atomic: the file is whole or absent.
pub fn write_png(path: &Path, width: u32, height: u32, rgb8: &[u8]) -> Result<()> {
    let pixels = check_size(&shown(path), width.into(), height.into())?;
    if rgb8.len() != 3 * pixels {
        let message = format!(
            "{} bytes given, {width}×{height} RGB pixels need {}",
            rgb8.len(),
            3 * pixels
        );
        return Err(Error::Image {
            path: path.to_owned(),
            message,
        });
    }
    write_atomic(path, |file| {
        let encoder = PngEncoder::new(file);
        encoder
            .write_image(rgb8, width, height, ExtendedColorType::Rgb8)
            .map_err(|e| match e {
                ImageError::IoError(source) => Error::writing(path)(source),
                other => Error::Image {
                    path: path.to_owned(),
                    message: other.to_string(),
                },
            })
    })
}

/// Paints a signed difference with [`FALSE_COLOUR_STOPS`]; RGB bytes, three a pixel.
///
/// `diff` holds one value a pixel and `scale` > 0 is the difference that gets the end colours, in the same unit;
/// larger differences get them too. A value that is NaN (or lacking) becomes magenta.
pub fn false_colour(width: u32, height: u32, diff: &[f32], scale: f32) -> Vec<u8> {
    let pixels = width as usize * height as usize;
    let values = diff
        .iter()
        .copied()
        .chain(std::iter::repeat(f32::NAN))
        .take(pixels);
    values
        .flat_map(|value| {
            if value.is_nan() {
                MAGENTA
            } else {
                colour_at(position(value, scale))
            }
        })
        .collect()
}

/// `value / scale` clamped to `[−1, 1]`; a scale that is not positive leaves only the sign.
fn position(value: f32, scale: f32) -> f32 {
    if value == 0.0 {
        0.0
    } else if scale > 0.0 && scale.is_finite() {
        (value / scale).clamp(-1.0, 1.0)
    } else {
        value.signum()
    }
}

/// Colour of [`FALSE_COLOUR_STOPS`] at a position in `[−1, 1]`.
fn colour_at(position: f32) -> [u8; 3] {
    let above = FALSE_COLOUR_STOPS.partition_point(|(at, _)| *at < position);
    let upper = above.min(FALSE_COLOUR_STOPS.len() - 1);
    let ((from, low), (to, high)) = (
        FALSE_COLOUR_STOPS[upper.saturating_sub(1)],
        FALSE_COLOUR_STOPS[upper],
    );
    let share = if to > from {
        ((position - from) / (to - from)).clamp(0.0, 1.0)
    } else {
        1.0
    };
    let mix = |c: usize| {
        (f32::from(low[c]) + share * (f32::from(high[c]) - f32::from(low[c]))).round() as u8
    };
    [mix(0), mix(1), mix(2)]
}

/// Pixels that a byte of a PNG can hold: a bit each, and deflate, the only compression there is, expands 1032 times at
/// most (<https://zlib.net/zlib_tech.html>).
const PIXELS_A_BYTE: u64 = 8 * 1032;
/// Most bytes of a decoded pixel: four channels of 16 bits.
const PIXEL_BYTES: u64 = 8;

/// Decodes a PNG whose size is checked first.
pub(super) fn read_png(path: &Path) -> Result<Frame> {
    let undecodable = |e: ImageError| match e {
        ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            Error::reading(path)(source)
        }
        other => Error::Image {
            path: path.to_owned(),
            message: format!("not a usable PNG: {other}"),
        },
    };
    let file = File::open(path).map_err(Error::reading(path))?;
    let file_bytes = file.metadata().map_err(Error::reading(path))?.len();
    let most = file_bytes.saturating_mul(PIXELS_A_BYTE).min(MAX_PIXELS) * PIXEL_BYTES;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(most);
    let decoder = PngDecoder::with_limits(BufReader::new(file), limits).map_err(undecodable)?;
    let (width, height) = decoder.dimensions();
    let pixels = check_size(&shown(path), width.into(), height.into())? as u64;
    check_backed(&shown(path), pixels * PIXEL_BYTES, most, file_bytes)?;
    // 8-bit values widen by 257, so v/65535 is the same number as v/255.
    let pixels = DynamicImage::from_decoder(decoder)
        .map_err(undecodable)?
        .into_rgba16();
    let radiance: Vec<[f32; 4]> = pixels.pixels().map(|p| linear(p.0)).collect();
    let sun = radiance
        .iter()
        .map(|&[r, g, b, _]| [r, g, b, 0.0])
        .collect();
    Ok(Frame {
        width,
        height,
        radiance,
        sun,
    })
}

/// sRGB with straight alpha, 16 bits, to linear light multiplied by alpha.
fn linear([r, g, b, a]: [u16; 4]) -> [f32; 4] {
    let alpha = f64::from(a) / 65535.0;
    let decode = |v: u16| {
        let s = f64::from(v) / 65535.0;
        let light = if s <= 0.04045 {
            s / 12.92
        } else {
            ((s + 0.055) / 1.055).powf(2.4)
        };
        (light * alpha) as f32
    };
    [decode(r), decode(g), decode(b), alpha as f32]
}

#[cfg(test)]
mod tests {
    use super::super::read_picture;
    use super::*;

    #[test]
    fn png_comes_back_linear() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.PNG");
        write_png(&path, 2, 1, &[0, 255, 188, 10, 64, 128]).unwrap();
        let frame = read_picture(&path).unwrap().frame;
        // Values of the standard's formula: 188 → 0.502886, 10 → 0.003035, 64 → 0.051269, 128 → 0.215861.
        let expected = [
            [0.0, 1.0, 0.502_886, 1.0],
            [0.003_035, 0.051_269, 0.215_861, 1.0],
        ];
        for (got, want) in frame
            .radiance
            .iter()
            .flatten()
            .zip(expected.iter().flatten())
        {
            assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
        assert_eq!(frame.sun[0][..3], frame.radiance[0][..3]);
        assert_eq!(frame.sun[0][3], 0.0);
    }

    #[test]
    fn sixteen_bits_and_alpha_are_used() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let pixel = image::Rgba([65535_u16, 257 * 128, 1, 257 * 51]);
        image::ImageBuffer::from_pixel(1, 1, pixel)
            .save(&path)
            .unwrap();
        let [r, g, b, a] = read_picture(&path).unwrap().frame.radiance[0];
        assert!((a - 0.2).abs() < 1e-7 && (r - 0.2).abs() < 1e-7);
        assert!((g - 0.2 * 0.215_861).abs() < 1e-6);
        assert!((b - 0.2 / 65535.0 / 12.92).abs() < 1e-12 && b > 0.0);
    }

    #[test]
    fn wrong_inputs_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        assert!(write_png(&path, 2, 2, &[0; 11]).is_err());
        assert!(!path.exists());
        assert!(matches!(read_picture(&path), Err(Error::Io { .. })));
        std::fs::write(&path, b"\x89PNG\r\n\x1a\nnothing").unwrap();
        assert!(matches!(read_picture(&path), Err(Error::Image { .. })));
        assert!(matches!(
            read_picture(Path::new("picture.jpg")),
            Err(Error::Input { .. })
        ));
    }

    #[test]
    fn false_colour_has_sign_white_and_magenta() {
        let got = false_colour(6, 1, &[-2.0, -0.5, 0.0, 0.5, f32::INFINITY, f32::NAN], 1.0);
        assert_eq!(got[0..3], [5, 48, 97]);
        assert!(got[5] > got[3], "negative is blue");
        assert_eq!(got[6..9], [255, 255, 255]);
        assert!(got[9] > got[11], "positive is red");
        assert_eq!(got[12..15], [103, 0, 31]);
        assert_eq!(got[15..18], MAGENTA);
    }

    #[test]
    fn false_colour_meets_its_stops_and_bad_input() {
        for (at, colour) in FALSE_COLOUR_STOPS {
            assert_eq!(colour_at(at), colour);
        }
        assert_eq!(colour_at(0.1), [254, 237, 227]);
        assert_eq!(
            false_colour(2, 1, &[0.0], 1.0)[3..],
            MAGENTA,
            "a lacking value shows"
        );
        assert_eq!(
            false_colour(3, 1, &[0.0, 1e-9, -1.0], 0.0),
            [255, 255, 255, 103, 0, 31, 5, 48, 97]
        );
    }
}
