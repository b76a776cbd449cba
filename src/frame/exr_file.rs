//! Frames as OpenEXR files: lossless, and open to any other tool.

use super::atomic::write_atomic;
use super::{Frame, check_backed, check_size, shown};
use crate::error::{Error, Result};
use exr::prelude::{
    Blocks, ChannelDescription, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder,
    MetaData, ReadChannels, ReadLayers, ReadSpecificChannel, SpecificChannels, Text, Vec2,
    WritableImage,
};
use std::path::Path;

/// Bytes of memory that a pixel of a [`Frame`] takes.
const FRAME_BYTES: u64 = 32;
/// Bytes of pixels that any file may announce, however well it is compressed.
const FREE_BYTES: u64 = 64 << 20;
/// Bytes of pixels that a byte of a file may announce. ZIP reaches 1032, wavelets more on pictures of one colour.
const BYTES_A_BYTE: u64 = 1 << 16;

/// One pixel of our files: R, G, B, A, sun.R, sun.G, sun.B, sun.V.
type Pixel = (f32, f32, f32, f32, f32, f32, f32, f32);

/// A channel that a file may lack.
type Maybe = Option<ChannelDescription>;

/// Writes a frame as a scan-line OpenEXR file of 32-bit floats, ZIP-compressed: every bit comes back.
///
/// One layer: `R`, `G`, `B` (linear radiance, sRGB primaries), `A` (opacity), `sun.R`, `sun.G`, `sun.B` (sun-lit
/// radiance) and `sun.V` (light transmittance). Atomic: the file is whole or absent.
/// Format: Kainz & Bogart, "Technical Introduction to OpenEXR", Industrial Light & Magic, 2013.
pub fn write_frame(path: &Path, frame: &Frame) -> Result<()> {
    frame.check(&shown(path))?;
    let width = frame.width as usize;
    let channels = SpecificChannels::build()
        .with_channel("R")
        .with_channel("G")
        .with_channel("B")
        .with_channel("A")
        .with_channel("sun.R")
        .with_channel("sun.G")
        .with_channel("sun.B")
        .with_channel("sun.V")
        .with_pixel_fn(|at: Vec2<usize>| -> Pixel {
            let index = at.y() * width + at.x();
            let ([r, g, b, a], [sr, sg, sb, v]) = (frame.radiance[index], frame.sun[index]);
            (r, g, b, a, sr, sg, sb, v)
        });
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let attributes = LayerAttributes {
        software_name: Some(Text::from("occlab")),
        ..LayerAttributes::default()
    };
    let image = Image::from_layer(Layer::new(
        (width, frame.height as usize),
        attributes,
        encoding,
        channels,
    ));
    write_atomic(path, |file| {
        image
            .write()
            .to_buffered(file)
            .map_err(|e| failed(path, e, Error::writing))
    })
}

/// Reads an OpenEXR file: ours, or any with channels `R`, `G`, `B` and optionally `A` (half, float or unsigned int).
///
/// Takes the first layer that has these channels, its data window, and its largest resolution level. Without `A` the
/// opacity is 1 everywhere; without `sun.R`, `sun.G`, `sun.B` the sun-lit radiance is the radiance and V is 0.
///
/// A panic of the decoder is an error about the file: damaged pixels can overflow its arithmetic in a build with overflow
/// checks. That is why it decodes on the calling thread; on a thread of its own a panic would end the process.
pub fn read_frame(path: &Path) -> Result<Frame> {
    let read = || {
        check_headers(path)?;
        decode(path)
    };
    std::panic::catch_unwind(read).unwrap_or_else(|_| {
        Err(Error::Image {
            path: path.to_owned(),
            message: "not a usable OpenEXR file: its decoder failed".to_owned(),
        })
    })
}

/// The pixels of a file whose headers are good.
fn decode(path: &Path) -> Result<Frame> {
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .optional("A", 1.0_f32)
        .optional("sun.R", 0.0_f32)
        .optional("sun.G", 0.0_f32)
        .optional("sun.B", 0.0_f32)
        .optional("sun.V", 0.0_f32)
        .collect_pixels(create, set)
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_file(path)
        .map(|image| image.layer_data.channel_data.pixels.frame)
        .map_err(|e| failed(path, e, Error::reading))
}

/// A frame being read, and whether its file holds sunlight of its own.
struct Loading {
    frame: Frame,
    has_sun: bool,
}

/// What the reader tells about the channels it found.
type Found = (
    ChannelDescription,
    ChannelDescription,
    ChannelDescription,
    Maybe,
    Maybe,
    Maybe,
    Maybe,
    Maybe,
);

/// Memory for a file whose size passed [`check_headers`].
fn create(size: Vec2<usize>, found: &Found) -> Loading {
    // Two fresh planes, not a clone: zeroed pages cost nothing until a pixel arrives, even if the header lied.
    let plane = || vec![[0.0; 4]; size.area()];
    let frame = Frame {
        width: size.x() as u32,
        height: size.y() as u32,
        radiance: plane(),
        sun: plane(),
    };
    Loading {
        frame,
        has_sun: found.4.is_some() && found.5.is_some() && found.6.is_some(),
    }
}

/// Stores one pixel.
fn set(loading: &mut Loading, at: Vec2<usize>, (r, g, b, a, sr, sg, sb, v): Pixel) {
    let index = at.y() * loading.frame.width as usize + at.x();
    loading.frame.radiance[index] = [r, g, b, a];
    loading.frame.sun[index] = if loading.has_sun {
        [sr, sg, sb, v]
    } else {
        [r, g, b, 0.0]
    };
}

/// Refuses a file by its headers, before any memory is taken for its pixels.
fn check_headers(path: &Path) -> Result<()> {
    let meta =
        MetaData::read_from_file(path, false).map_err(|e| failed(path, e, Error::reading))?;
    let file_bytes = std::fs::metadata(path).map_err(Error::reading(path))?.len();
    let refuse = |message: String| Error::Image {
        path: path.to_owned(),
        message,
    };
    let mut usable = false;
    for header in &meta.headers {
        let pixels = check_size(
            &shown(path),
            header.layer_size.x() as u64,
            header.layer_size.y() as u64,
        )? as u64;
        let pixel_bytes = FRAME_BYTES.max(header.channels.bytes_per_pixel as u64);
        check_backed(
            &shown(path),
            pixels.saturating_mul(pixel_bytes),
            FREE_BYTES.max(file_bytes.saturating_mul(BYTES_A_BYTE)),
            file_bytes,
        )?;
        let channels = &header.channels.list;
        usable |= ["R", "G", "B"]
            .iter()
            .all(|name| channels.iter().any(|c| c.name.eq(name)));
        if channels.iter().any(|c| c.sampling != Vec2(1, 1)) {
            return Err(refuse(
                "has subsampled channels; save it with channels of full resolution".into(),
            ));
        }
    }
    if usable {
        return Ok(());
    }
    let names: Vec<String> = meta
        .headers
        .iter()
        .flat_map(|h| &h.channels.list)
        .map(|c| c.name.to_string())
        .collect();
    Err(refuse(format!(
        "has no layer with channels R, G and B; it has {}",
        names.join(", ")
    )))
}

/// The library's error for a failure of the decoder or encoder.
fn failed<F: FnOnce(std::io::Error) -> Error>(
    path: &Path,
    error: exr::error::Error,
    io: impl Fn(&Path) -> F,
) -> Error {
    match error {
        exr::error::Error::Io(source) => io(path)(source),
        other => Error::Image {
            path: path.to_owned(),
            message: format!("not a usable OpenEXR file: {other}"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{f16, write_rgb_file, write_rgba_file};

    /// A frame whose values use many bits, with the floats that careless code loses.
    fn difficult() -> Frame {
        let (width, height) = (37, 21);
        let value =
            |i: u32| f32::from_bits(i.wrapping_mul(0x9e37_79b9) & 0x7f7f_ffff | (i & 1) << 31);
        let plane = |k: u32| {
            (0..width * height)
                .map(|i| [0, 1, 2, 3].map(|c| value(i * 8 + k + c)))
                .collect()
        };
        let mut frame = Frame {
            width,
            height,
            radiance: plane(0),
            sun: plane(4),
        };
        frame.radiance[5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0];
        frame.sun[6] = [
            f32::from_bits(0x7fc1_2345),
            f32::from_bits(1),
            f32::MAX,
            f32::MIN_POSITIVE,
        ];
        frame
    }

    fn bits(plane: &[[f32; 4]]) -> Vec<[u32; 4]> {
        plane.iter().map(|p| p.map(f32::to_bits)).collect()
    }

    #[test]
    fn round_trip_keeps_every_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        let frame = difficult();
        write_frame(&path, &frame).unwrap();
        let back = read_frame(&path).unwrap();
        assert_eq!((back.width, back.height), (37, 21));
        assert_eq!(bits(&back.radiance), bits(&frame.radiance));
        assert_eq!(bits(&back.sun), bits(&frame.sun));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn file_has_the_documented_channels() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        write_frame(&path, &difficult()).unwrap();
        let meta = MetaData::read_from_file(&path, true).unwrap();
        let names: Vec<String> = meta.headers[0]
            .channels
            .list
            .iter()
            .map(|c| c.name.to_string())
            .collect();
        assert_eq!(meta.headers.len(), 1);
        assert_eq!(
            names,
            ["A", "B", "G", "R", "sun.B", "sun.G", "sun.R", "sun.V"]
        );
        assert_eq!(
            meta.headers[0].blocks,
            exr::meta::BlockDescription::ScanLines
        );
    }

    #[test]
    fn reads_third_party_half_and_uint() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("half.exr");
        write_rgba_file(&path, 3, 2, |x, y| {
            (f16::from_f32(x as f32), y as f32, 7_u32, f16::from_f32(0.5))
        })
        .unwrap();
        let frame = read_frame(&path).unwrap();
        assert_eq!(frame.radiance[5], [2.0, 1.0, 7.0, 0.5]);
        assert_eq!(frame.sun[5], [2.0, 1.0, 7.0, 0.0]);
    }

    #[test]
    fn missing_alpha_is_opaque() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rgb.exr");
        write_rgb_file(&path, 2, 2, |_, _| (1.0_f32, 2.0_f32, 3.0_f32)).unwrap();
        assert_eq!(read_frame(&path).unwrap().radiance[3], [1.0, 2.0, 3.0, 1.0]);
    }

    #[test]
    fn wrong_files_are_refused_with_a_reason() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.exr");
        assert!(matches!(read_frame(&path), Err(Error::Io { .. })));
        std::fs::write(&path, b"this is no picture").unwrap();
        assert!(read_frame(&path).is_err());
        let one = SpecificChannels::build()
            .with_channel("Y")
            .with_pixel_fn(|_: Vec2<usize>| (1.0_f32,));
        Image::from_channels((2, 2), one)
            .write()
            .to_file(&path)
            .unwrap();
        assert!(
            read_frame(&path)
                .unwrap_err()
                .to_string()
                .contains("it has Y")
        );
    }

    #[test]
    fn truncated_and_oversized_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        write_frame(&path, &difficult()).unwrap();
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        assert!(read_frame(&path).is_err());
        // The data window ends at (36, 20): announce 65 537 × 65 537 pixels instead.
        let corner: Vec<u8> = [36_i32, 20].iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut huge = whole;
        for at in 0..1000 {
            if huge[at..at + 8] == corner {
                huge[at..at + 8].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
            }
        }
        std::fs::write(&path, &huge).unwrap();
        assert!(
            read_frame(&path)
                .err()
                .unwrap()
                .to_string()
                .contains("65537×65537")
        );
    }

    #[test]
    fn mis_sized_frame_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        let frame = Frame {
            width: 9,
            ..difficult()
        };
        assert!(write_frame(&path, &frame).is_err());
        assert!(!path.exists());
    }
}
