//! Pictures read from OpenEXR files.

use super::exr_layers::{Layer, choose};
use super::{Frame, PictureFile, check_backed, check_size, shown};
use crate::error::{Error, Result};
use crate::file_part::FilePart;
use exr::block::UncompressedBlock;
use exr::block::lines::LineRef;
use exr::block::reader::{ChunksReader, Reader};
use exr::io::Data;
use exr::meta::header::Header;
use exr::prelude::{IntegerBounds, MetaData, SampleType, f16};
use std::fs::File;
use std::io::{BufReader, Seek};
use std::ops::Range;
use std::path::Path;

/// Bytes of memory that a pixel of a [`Frame`] takes.
const FRAME_BYTES: u64 = 32;
/// Bytes of pixels that a header may announce, whatever the size of its file.
const FREE_BYTES: u64 = 64 << 20;
/// Bytes of pixels that a header may announce for each byte of its file. ZIP reaches 1032, wavelets more on pictures of
/// one colour.
const BYTES_A_BYTE: u64 = 1 << 16;

/// Reads an OpenEXR file as [`super::read_picture`] says.
///
/// A panic of the decoder is an error about the file: damaged pixels can overflow its arithmetic in a build with overflow
/// checks. That is why it decodes on the calling thread; on a thread of its own a panic would end the process.
pub(super) fn read_exr(path: &Path) -> Result<PictureFile> {
    let part = FilePart::of(path, "exr");
    std::panic::catch_unwind(|| read(&part)).unwrap_or_else(|_| {
        Err(Error::Image {
            path: part.file.clone(),
            message: "not a usable OpenEXR file: its decoder failed".to_owned(),
        })
    })
}

fn read(part: &FilePart) -> Result<PictureFile> {
    let path = &part.file;
    let mut file = BufReader::new(File::open(path).map_err(Error::reading(path))?);
    let file_bytes = file
        .get_ref()
        .metadata()
        .map_err(Error::reading(path))?
        .len();
    let unusable = |e| failed(path, e, Error::reading);
    let meta = MetaData::read_from_buffered(&mut file, false).map_err(unusable)?;
    for header in &meta.headers {
        let bytes = FRAME_BYTES.max(header.channels.bytes_per_pixel as u64);
        check_window(path, header.data_window(), bytes, file_bytes)?;
    }
    file.rewind().map_err(Error::reading(path))?;
    let reader = exr::block::read(file, false).map_err(unusable)?;
    let (layer, layer_note) = choose(part, reader.headers())?;
    let header = &reader.headers()[layer.part];
    let display = header.shared_attributes.display_window;
    check_window(path, display, FRAME_BYTES, file_bytes)?;
    let windows = Windows::new(header);
    let window_note = windows.note(path);
    let frame = decode(reader, &layer, &windows).map_err(unusable)?;
    Ok(PictureFile {
        frame,
        corner: [display.position.x(), display.position.y()],
        notes: layer_note.into_iter().chain(window_note).collect(),
    })
}

/// Refuses a window by its size, before any memory is taken for its pixels.
fn check_window(
    path: &Path,
    window: IntegerBounds,
    pixel_bytes: u64,
    file_bytes: u64,
) -> Result<()> {
    let (width, height) = (window.size.x() as u64, window.size.y() as u64);
    let pixels = check_size(&shown(path), width, height)? as u64;
    check_backed(
        &shown(path),
        pixels.saturating_mul(pixel_bytes),
        FREE_BYTES.max(file_bytes.saturating_mul(BYTES_A_BYTE)),
        file_bytes,
    )
}

/// The pixels that a file stores (data window) and the picture they belong to (display window).
struct Windows {
    data: IntegerBounds,
    display: IntegerBounds,
    /// Column and row of the display window where the data window begins.
    offset: [i64; 2],
}

impl Windows {
    fn new(header: &Header) -> Self {
        let (data, display) = (
            header.data_window(),
            header.shared_attributes.display_window,
        );
        let offset = |from: i32, to: i32| i64::from(to) - i64::from(from);
        Self {
            data,
            display,
            offset: [
                offset(display.position.x(), data.position.x()),
                offset(display.position.y(), data.position.y()),
            ],
        }
    }

    /// Columns (axis 0) or rows (axis 1) of the display window that the data window covers.
    fn covered(&self, axis: usize) -> Range<usize> {
        let size = |window: IntegerBounds| [window.size.x(), window.size.y()][axis] as i64;
        let (shown, start) = (size(self.display), self.offset[axis]);
        let end = start + size(self.data);
        start.clamp(0, shown) as usize..end.clamp(0, shown) as usize
    }

    /// A line for the user where the two windows differ.
    fn note(&self, path: &Path) -> Option<String> {
        if self.data == self.display {
            return None;
        }
        let window = |window: IntegerBounds| {
            let (size, at) = (window.size, window.position);
            format!("{}×{} from ({}, {})", size.x(), size.y(), at.x(), at.y())
        };
        let covered = [0, 1].map(|axis| self.covered(axis));
        let seen: usize = covered.iter().map(Range::len).product();
        let cut = if seen < self.data.size.area() {
            "; overscan was cut"
        } else {
            ""
        };
        let empty = match seen {
            0 => "; no stored pixel lies in it: radiance and opacity are 0 everywhere",
            _ if seen < self.display.size.area() => "; outside its data radiance and opacity are 0",
            _ => "",
        };
        Some(format!(
            "{}: the picture is its display window, {}, its data window is {}{cut}{empty}",
            shown(path),
            window(self.display),
            window(self.data)
        ))
    }
}

/// The pixels of a layer over the display window.
fn decode(
    reader: Reader<BufReader<File>>,
    layer: &Layer,
    windows: &Windows,
) -> exr::error::Result<Frame> {
    let size = windows.display.size;
    // Two fresh planes, not a clone: zeroed pages cost nothing until written, even if the header announces too many
    // pixels.
    let plane = || vec![[0.0; 4]; size.area()];
    let frame = Frame {
        width: size.x() as u32,
        height: size.y() as u32,
        radiance: plane(),
        sun: plane(),
    };
    let mut target = Target::new(frame, layer, windows);
    let wanted = layer.part;
    let blocks = reader.filter_chunks(false, |_, tile, block| {
        block.layer == wanted && tile.is_largest_resolution_level()
    })?;
    blocks.decompress_sequential(false, |meta, block| {
        target.store(&meta.headers[wanted], &block)
    })?;
    Ok(target.finish(layer))
}

/// A frame that is being filled.
struct Target<'a> {
    frame: Frame,
    windows: &'a Windows,
    /// Where each channel of the part goes, by its index: components 0 to 3 of the radiance, 4 to 7 of the sunlight.
    components: Vec<Vec<usize>>,
}

impl<'a> Target<'a> {
    fn new(frame: Frame, layer: &Layer, windows: &'a Windows) -> Self {
        let colour = layer.colour().into_iter().chain([layer.alpha()]);
        let sun = layer.sun().unwrap_or_default();
        let mut components: Vec<Vec<usize>> = Vec::new();
        for (component, channel) in colour.chain(sun).enumerate() {
            if let Some(channel) = channel {
                let length = components.len().max(channel + 1);
                components.resize(length, Vec::new());
                components[channel].push(component);
            }
        }
        Self {
            frame,
            windows,
            components,
        }
    }

    fn store(&mut self, header: &Header, block: &UncompressedBlock) -> exr::error::UnitResult {
        for line in block.lines(&header.channels) {
            match header.channels.list[line.location.channel].sample_type {
                SampleType::F16 => self.store_line(&line, f16::to_f32)?,
                SampleType::F32 => self.store_line(&line, |v: f32| v)?,
                SampleType::U32 => self.store_line(&line, |v: u32| v as f32)?,
            }
        }
        Ok(())
    }

    /// Stores the part of a line that lies in the display window.
    fn store_line<T: Data>(
        &mut self,
        line: &LineRef<'_>,
        value: impl Fn(T) -> f32,
    ) -> exr::error::UnitResult {
        let Some(components) = self.components.get(line.location.channel) else {
            return Ok(());
        };
        let [column, row] = self.windows.offset;
        let first = line.location.position.x() as i64 + column;
        let row = line.location.position.y() as i64 + row;
        let (width, height) = (i64::from(self.frame.width), i64::from(self.frame.height));
        if components.is_empty() || !(0..height).contains(&row) {
            return Ok(());
        }
        for (x, sample) in (first..width).zip(line.read_samples::<T>()) {
            let value = value(sample?);
            if x >= 0 {
                let pixel = (row * width + x) as usize;
                for component in components {
                    let plane = match component / 4 {
                        0 => &mut self.frame.radiance,
                        _ => &mut self.frame.sun,
                    };
                    plane[pixel][component % 4] = value;
                }
            }
        }
        Ok(())
    }

    /// Fills in what the layer does not have: an opacity of 1 where there are pixels, and sunlight equal to the radiance.
    fn finish(mut self, layer: &Layer) -> Frame {
        if layer.alpha().is_none() {
            let width = self.frame.width as usize;
            for row in self.windows.covered(1) {
                for column in self.windows.covered(0) {
                    self.frame.radiance[row * width + column][3] = 1.0;
                }
            }
        }
        if layer.sun().is_none() {
            let pixels = self.frame.sun.iter_mut().zip(&self.frame.radiance);
            for (sun, [r, g, b, _]) in pixels {
                *sun = [*r, *g, *b, 0.0];
            }
        }
        self.frame
    }
}

/// The library's error for a failure of the decoder or encoder.
pub(super) fn failed<F: FnOnce(std::io::Error) -> Error>(
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
mod tests;
