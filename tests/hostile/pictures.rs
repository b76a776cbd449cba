//! Damaged EXR and PNG files.

use super::damage::{WORDS, cases, damaged, edits};
use super::is_one_paragraph;
use occlab::frame::{Frame, read_frame, read_picture, write_frame};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Header of an EXR file with the attributes of [`write_frame`]; the rest are pixels and their table.
const EXR_HEADER: usize = 600;

/// Small pictures of every kind that the reader takes.
static EXRS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut files = Vec::new();
    let plane = |k: f32| {
        (0..12)
            .map(|i| [0.0, 1.0, 2.0, 3.0].map(|c| c + k * i as f32))
            .collect()
    };
    let frame = Frame {
        width: 4,
        height: 3,
        radiance: plane(0.5),
        sun: plane(0.25),
    };
    write_frame(&path, &frame).unwrap();
    files.push(std::fs::read(&path).unwrap());
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ];
    for compression in compressions {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 8))] {
            let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
                (
                    f16::from_f32(at.x() as f32),
                    at.y() as f32 * 0.1,
                    (at.x() * at.y()) as u32,
                )
            });
            let encoding = Encoding {
                compression,
                blocks,
                line_order: LineOrder::Increasing,
            };
            let layer = Layer::new((19, 13), LayerAttributes::named("main"), encoding, channels);
            Image::from_layer(layer).write().to_file(&path).unwrap();
            files.push(std::fs::read(&path).unwrap());
        }
    }
    files.extend(layered(&path));
    files
});

/// A channel of a constant picture of 6 × 5 pixels.
fn channel(name: &str) -> exr::prelude::AnyChannel<exr::prelude::FlatSamples> {
    let samples = exr::prelude::FlatSamples::F32(vec![0.5; 30]);
    exr::prelude::AnyChannel::new(name, samples)
}

/// Pictures of one named layer, of brightness alone, of two parts, and of other windows.
fn layered(path: &Path) -> Vec<Vec<u8>> {
    use exr::prelude::*;
    let part = |name: &str, position: Vec2<i32>, channels: &[&str]| {
        let list = AnyChannels::sort(channels.iter().copied().map(channel).collect());
        let attributes = LayerAttributes {
            layer_position: position,
            ..LayerAttributes::named(name)
        };
        Layer::new((6, 5), attributes, Encoding::SMALL_LOSSLESS, list)
    };
    let display = |width, height| ImageAttributes::with_size((width, height));
    let rgb = ["R", "G", "B"];
    let images = [
        (
            display(6, 5),
            vec![part("a", Vec2(0, 0), &["a.b.R", "a.b.G", "a.b.B", "Z"])],
        ),
        (display(6, 5), vec![part("a", Vec2(0, 0), &["Y", "A"])]),
        (
            display(6, 5),
            vec![part("a", Vec2(0, 0), &["Z"]), part("b", Vec2(0, 0), &rgb)],
        ),
        (display(9, 9), vec![part("a", Vec2(2, 3), &rgb)]),
        (display(3, 2), vec![part("a", Vec2(-2, -1), &rgb)]),
    ];
    let bytes = images.map(|(attributes, parts)| {
        Image::from_layers(attributes, parts)
            .write()
            .to_file(path)
            .unwrap();
        std::fs::read(path).unwrap()
    });
    bytes.to_vec()
}

/// Small pictures of every colour type.
static PNGS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    use image::DynamicImage;
    let rgba = image::RgbaImage::from_fn(9, 7, |x, y| {
        image::Rgba([x as u8 * 20, y as u8 * 30, 7, 200 + y as u8])
    });
    let first = DynamicImage::ImageRgba8(rgba);
    let kinds = [
        DynamicImage::ImageLuma8(first.to_luma8()),
        DynamicImage::ImageLuma16(first.to_luma16()),
        DynamicImage::ImageLumaA8(first.to_luma_alpha8()),
        DynamicImage::ImageRgb8(first.to_rgb8()),
        DynamicImage::ImageRgb16(first.to_rgb16()),
        DynamicImage::ImageRgba16(first.to_rgba16()),
        first,
    ];
    let png = |picture: &DynamicImage| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture
            .write_to(&mut bytes, image::ImageFormat::Png)
            .unwrap();
        bytes.into_inner()
    };
    kinds.iter().map(png).collect()
});

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

/// Either a whole frame or a paragraph.
fn holds(name: &str, bytes: &[u8]) {
    let folder = Folder::new();
    let path = folder.write(name, bytes);
    match read_picture(&path) {
        Ok(picture) => picture.frame.check("read").unwrap(),
        Err(error) => assert!(is_one_paragraph(&error.to_string(), &path), "{error}"),
    }
}

/// CRC-32 of a PNG chunk (ISO 3309), so that damage is found by what it says and not by its checksum.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| {
            if c & 1 == 1 {
                0xedb8_8320 ^ (c >> 1)
            } else {
                c >> 1
            }
        })
    })
}

/// A chunk: length, kind, data, checksum.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [&kind[..], data].concat();
    [
        &(data.len() as u32).to_be_bytes()[..],
        &body,
        &crc(&body).to_be_bytes(),
    ]
    .concat()
}

/// A PNG with an arbitrary header.
fn png(width: u32, height: u32, rest: [u8; 5], data: &[u8]) -> Vec<u8> {
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &rest].concat();
    let parts = [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        chunk(b"IHDR", &header),
        chunk(b"IDAT", data),
        chunk(b"IEND", &[]),
    ];
    parts.concat()
}

const DATA_WINDOW: &[u8] = b"dataWindow\0box2i\0";
const DISPLAY_WINDOW: &[u8] = b"displayWindow\0box2i\0";

/// Replaces the data window and the display window of an EXR file by one from (0, 0) to `corner`.
fn with_window(file: &[u8], corner: [i32; 2]) -> Vec<u8> {
    let window = [0, 0, corner[0], corner[1]];
    with_bounds(
        &with_bounds(file, DATA_WINDOW, window),
        DISPLAY_WINDOW,
        window,
    )
}

/// Replaces one window of an EXR file's first part: its first and its last column and row.
fn with_bounds(file: &[u8], name: &[u8], window: [i32; 4]) -> Vec<u8> {
    let mut out = file.to_vec();
    let at = file.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    for (i, value) in window.into_iter().enumerate() {
        out[at + 4 * i..at + 4 * i + 4].copy_from_slice(&value.to_le_bytes());
    }
    out
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn any_bytes(bytes in vec(any::<u8>(), 0..200), start in 0_usize..3) {
        let start: &[u8] = [&b""[..], b"\x76\x2f\x31\x01\x02\x00\x00\x00", b"\x89PNG\r\n\x1a\n"][start];
        let bytes = [start, &bytes].concat();
        holds("a.exr", &bytes);
        holds("a.png", &bytes);
    }

    #[test]
    fn damaged_exr_headers(which in any::<prop::sample::Index>(), edits in edits()) {
        holds("a.exr", &damaged(&EXRS[which.index(EXRS.len())], &edits, EXR_HEADER));
    }

    #[test]
    fn damaged_exr_files(which in any::<prop::sample::Index>(), edits in edits()) {
        holds("a.exr", &damaged(&EXRS[which.index(EXRS.len())], &edits, usize::MAX));
    }

    #[test]
    fn exr_windows_of_any_size(which in any::<prop::sample::Index>(), corner in prop::array::uniform2(select(&WORDS[..]))) {
        holds("a.exr", &with_window(&EXRS[which.index(EXRS.len())], corner.map(|v| v as i32)));
    }

    /// Windows that lie anywhere: of any corners, or of the stored size at any place.
    #[test]
    fn exr_windows_that_differ(
        which in any::<prop::sample::Index>(), display in any::<bool>(), corners in prop::array::uniform4(select(&WORDS[..])),
        size in (1_i32..40, 1_i32..40), at in (-50_i32..50, -50_i32..50),
    ) {
        let file = &EXRS[which.index(EXRS.len())];
        let name = if display { DISPLAY_WINDOW } else { DATA_WINDOW };
        holds("a.exr", &with_bounds(file, name, corners.map(|v| v as i32)));
        let window = [at.0, at.1, at.0 + size.0 - 1, at.1 + size.1 - 1];
        holds("a.exr", &with_bounds(file, name, window));
    }

    #[test]
    fn damaged_png_files(which in any::<prop::sample::Index>(), edits in edits()) {
        holds("a.png", &damaged(&PNGS[which.index(PNGS.len())], &edits, usize::MAX));
    }

    #[test]
    fn png_headers_that_lie(
        width in prop_oneof![select(&WORDS[..]), 0_u32..40], height in prop_oneof![select(&WORDS[..]), 0_u32..40],
        depth in select(vec![1_u8, 2, 4, 8, 16, 3]), colour in select(vec![0_u8, 2, 3, 4, 6, 1]),
        interlaced in 0_u8..2, data in vec(any::<u8>(), 0..80),
    ) {
        holds("a.png", &png(width, height, [depth, colour, 0, 0, interlaced], &data));
    }

    /// Every bit comes back, whatever the values are.
    #[test]
    fn frames_come_back(width in 1_u32..20, height in 1_u32..20, values in vec(any::<u32>(), 8)) {
        let value = |i: u32| f32::from_bits(values[i as usize % 8].wrapping_mul(i | 1));
        let plane = |k: u32| (0..width * height).map(|i| [0, 1, 2, 3].map(|c| value(8 * i + k + c))).collect::<Vec<_>>();
        let frame = Frame { width, height, radiance: plane(0), sun: plane(4) };
        let folder = Folder::new();
        let path = folder.0.path().join("a.exr");
        write_frame(&path, &frame).unwrap();
        let back = read_frame(&path).unwrap();
        let bits = |plane: &[[f32; 4]]| plane.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
        prop_assert_eq!(bits(&back.radiance), bits(&frame.radiance));
        prop_assert_eq!(bits(&back.sun), bits(&frame.sun));
    }
}

fn refusal(path: &Path) -> String {
    let message = read_picture(path).unwrap_err().to_string();
    assert!(is_one_paragraph(&message, path), "{message}");
    message
}

#[test]
fn small_files_that_announce_large_pictures_are_refused_before_memory_is_taken() {
    let folder = Folder::new();
    for (width, height) in [
        (0x7fff_ffff, 0x7fff_ffff),
        (16384, 16384),
        (1 << 28, 1),
        (1, 1 << 28),
    ] {
        let path = folder.write("a.png", &png(width, height, [8, 6, 0, 0, 0], &[0; 30]));
        refusal(&path);
        for file in &EXRS[..] {
            let corner = [width as i32 - 1, height as i32 - 1];
            refusal(&folder.write("a.exr", &with_window(file, corner)));
        }
    }
    let path = folder.write("a.exr", &with_window(&EXRS[0], [16383, 16383]));
    let message = refusal(&path);
    assert!(message.contains("announces 8589934592 bytes"), "{message}");
}

#[test]
fn a_decoder_that_overflows_is_an_error_about_the_file() {
    // B44 subtracts a bias from what damaged blocks say: with overflow checks this ended the process.
    for file in &EXRS[..] {
        for zeros in 1..60 {
            let mut bytes = file.clone();
            let keep = bytes.len() - zeros;
            bytes[keep..].fill(0);
            holds("a.exr", &bytes);
        }
    }
}

#[test]
fn pictures_of_one_colour_are_read_however_well_they_compress() {
    use exr::prelude::*;
    let folder = Folder::new();
    let path = folder.0.path().join("a.exr");
    for compression in [Compression::PIZ, Compression::ZIP16] {
        let channels = SpecificChannels::rgb(|_: Vec2<usize>| (f16::ZERO, f16::ZERO, f16::ZERO));
        let encoding = Encoding {
            compression,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let layer = Layer::new((2048, 2048), LayerAttributes::default(), encoding, channels);
        Image::from_layer(layer).write().to_file(&path).unwrap();
        let bytes = std::fs::metadata(&path).unwrap().len();
        let frame = read_frame(&path).unwrap_or_else(|e| panic!("{bytes} bytes: {e}"));
        assert_eq!((frame.width, frame.height), (2048, 2048));
    }
    let path = folder.0.path().join("a.png");
    image::GrayImage::new(4096, 4096).save(&path).unwrap();
    assert_eq!(read_picture(&path).unwrap().frame.width, 4096);
}
