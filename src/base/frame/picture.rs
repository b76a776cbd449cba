//! Reads a picture to compare, EXR or PNG, into a [`Frame`].

use super::exr_read::read_exr;
use super::png_file::read_png;
use super::{Frame, shown};
use crate::error::{Error, Result};
use crate::file_part::FilePart;
use std::path::Path;

/// A picture read from a file, with notes on how it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureFile {
    /// The pixels.
    pub frame: Frame,
    /// Column and row at which the picture begins in the coordinates of its file; (0, 0) for a PNG.
    pub corner: [i32; 2],
    /// Lines for the user, each with the file's name: which layer was taken, what was cut or left empty.
    pub notes: Vec<String>,
}

/// Reads a picture to compare: `.exr`, a layer of it (`frame.exr:beauty`), or `.png` of 8 or 16 bits.
///
/// An EXR's layer is the one named behind the colon; else the first whose channels are plain `R`, `G` and `B`, else plain
/// `Y`, else the only one with such channels behind a prefix (`beauty.R`, `ViewLayer.Combined.R`). `Y` stands for all
/// three colours where a layer lacks them. Channels may be half, float or unsigned int. Without `A` the opacity is 1;
/// without `sun.R`, `sun.G`, `sun.B` the sun-lit radiance is the radiance and V is 0. Of several resolutions the largest
/// is taken. The picture is the display window: outside the data window radiance and opacity are 0, and what the data
/// window has beyond the display window is cut.
///
/// A PNG is taken as sRGB whatever profile it carries, is made linear (IEC 61966-2-1:1999), and its colour is
/// multiplied by its alpha, as in an EXR. Its sun-lit radiance is its radiance and V is 0.
pub fn read_picture(path: &Path) -> Result<PictureFile> {
    let file = FilePart::of(path, "exr").file;
    let extension = file.extension().and_then(|e| e.to_str());
    match extension.unwrap_or_default().to_ascii_lowercase().as_str() {
        "exr" => read_exr(path),
        "png" => Ok(PictureFile {
            frame: read_png(path)?,
            corner: [0, 0],
            notes: Vec::new(),
        }),
        _ => Err(Error::input(
            shown(path),
            "not a picture this program reads",
            "Give a .exr or a .png file.",
        )),
    }
}

/// Reads the frame of an OpenEXR file, such as [`super::write_frame`] writes: [`read_picture`] without its notes.
pub fn read_frame(path: &Path) -> Result<Frame> {
    read_exr(path).map(|picture| picture.frame)
}
