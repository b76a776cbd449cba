//! Frames as OpenEXR files: lossless, readable by other tools.

use super::atomic::write_atomic;
use super::exr_read::failed;
use super::{Frame, shown};
use crate::error::{Error, Result};
use exr::prelude::{
    Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels,
    Text, Vec2, WritableImage,
};
use std::path::Path;

/// One pixel of our files: R, G, B, A, sun.R, sun.G, sun.B, sun.V.
type ExrPixel = (f32, f32, f32, f32, f32, f32, f32, f32);

/// Writes a frame as a scan-line OpenEXR file of 32-bit floats with lossless ZIP compression.
///
/// One layer: `R`, `G`, `B` (linear radiance, sRGB primaries), `A` (opacity), `sun.R`, `sun.G`, `sun.B` (sun-lit
/// radiance) and `sun.V` (light transmittance). Atomic: the file is whole or absent.
/// Format: <https://openexr.com/en/latest/TechnicalIntroduction.html>.
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
        .with_pixel_fn(|at: Vec2<usize>| -> ExrPixel {
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

#[cfg(test)]
mod tests {
    use super::super::read_frame;
    use super::*;
    use exr::prelude::{MetaData, f16, write_rgb_file, write_rgba_file};

    /// A frame of pseudo-random bit patterns, with NaN, infinities, −0, a denormal and the largest float.
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
            .with_channel("Z")
            .with_pixel_fn(|_: Vec2<usize>| (1.0_f32,));
        Image::from_channels((2, 2), one)
            .write()
            .to_file(&path)
            .unwrap();
        assert!(
            read_frame(&path)
                .unwrap_err()
                .to_string()
                .contains("it has Z")
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
        let message = read_frame(&path).unwrap_err().to_string();
        assert!(message.contains("65537×65537"), "{message}");
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
