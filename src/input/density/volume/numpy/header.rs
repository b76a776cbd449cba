//! The header of a `.npy` file, checked before anything is allocated for its data.

use super::{MAX_AXIS, MAX_VOXELS, SAVE_REMEDY, place};
use crate::error::{Error, Result};
use npyz::NpyHeader;
use std::io::Read;
use std::path::Path;

/// Longest header accepted, bytes; NumPy writes 118 for three axes.
const MAX_HEADER_BYTES: usize = 1 << 16;
/// Most brackets in a header: three axes need two pairs, and deep nesting would exhaust the parser's stack.
const MAX_BRACKETS: usize = 64;

/// A header that a volume can have.
pub(super) struct VolumeHeader {
    pub npy: NpyHeader,
    pub shape: [u32; 3],
    /// Bytes before the data.
    pub bytes: u64,
}

/// Reads the header; the next byte of `reader` is then the first of the data.
///
/// The `.npy` reader multiplies the axes without a check and allocates what the length field says; both are therefore
/// checked here, on the text.
pub(super) fn read(path: &Path, reader: &mut impl Read) -> Result<VolumeHeader> {
    let io = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => bad_header(path, "the file ends inside the header"),
        _ => super::cannot_read(path, e),
    };
    let mut raw = vec![0; 8];
    reader.read_exact(&mut raw).map_err(io)?;
    if &raw[..6] != b"\x93NUMPY" {
        return Err(bad_header(path, "this is not a .npy file, nor a .npz"));
    }
    let length_bytes = if raw[6] == 1 { 2 } else { 4 };
    let mut length = [0; 4];
    reader.read_exact(&mut length[..length_bytes]).map_err(io)?;
    raw.extend(&length[..length_bytes]);
    let length = u32::from_le_bytes(length) as usize;
    if length > MAX_HEADER_BYTES {
        let problem = format!("the header claims {length} bytes");
        return Err(bad_header(path, problem));
    }
    let text_start = raw.len();
    raw.resize(text_start + length, 0);
    reader.read_exact(&mut raw[text_start..]).map_err(io)?;
    let text = std::str::from_utf8(&raw[text_start..])
        .map_err(|_| bad_header(path, "the header is not text"))?;
    check_text(path, text)?;
    let shape = shape_in(path, text)?;
    let npy = NpyHeader::from_reader(&raw[..]).map_err(|e| bad_header(path, e.to_string()))?;
    if npy.shape() != shape.map(u64::from) {
        let problem = "the shape is written in an unusual way";
        return Err(bad_header(path, problem));
    }
    Ok(VolumeHeader {
        npy,
        shape,
        bytes: raw.len() as u64,
    })
}

/// Refuses text that the parser must not see.
fn check_text(path: &Path, text: &str) -> Result<()> {
    if text.matches(['(', '[', '{']).count() > MAX_BRACKETS {
        return Err(bad_header(path, "the header is nested too deeply"));
    }
    if text.matches(':').count() > 3 {
        let problem = "the header has more than descr, fortran_order and shape";
        return Err(bad_header(path, problem));
    }
    // `shape_in` finds the shape by its name: a name that can be hidden in another string, or spelt with escapes, would
    // give the parser a second one.
    if text.contains(['"', '\\']) || text.matches("'shape'").count() > 1 {
        let problem = "the shape is written in an unusual way";
        return Err(bad_header(path, problem));
    }
    Ok(())
}

/// The three axes of `'shape': (a, b, c)`, each 1…[`MAX_AXIS`], at most [`MAX_VOXELS`] together.
fn shape_in(path: &Path, header: &str) -> Result<[u32; 3]> {
    let axes = header
        .split_once("'shape'")
        .and_then(|(_, rest)| rest.split_once('('))
        .and_then(|(_, rest)| rest.split_once(')'));
    let (axes, _) = axes.ok_or_else(|| bad_header(path, "there is no shape"))?;
    let axes: Vec<&str> = axes
        .split(',')
        .map(str::trim)
        .filter(|axis| !axis.is_empty())
        .collect();
    let wrong = |problem: String| Error::input(place(path, "header, shape"), problem, SAVE_REMEDY);
    if axes.len() != 3 {
        return Err(wrong(format!(
            "the array has {} axes, a volume has 3",
            axes.len()
        )));
    }
    let mut shape = [0; 3];
    for (i, text) in axes.iter().enumerate() {
        shape[i] = text
            .parse()
            .ok()
            .filter(|n| (1..=MAX_AXIS).contains(n))
            .ok_or_else(|| {
                wrong(format!(
                    "axis {i} has {text} voxels, allowed is 1…{MAX_AXIS}"
                ))
            })?;
    }
    let voxels = shape.iter().map(|n| u64::from(*n)).product::<u64>();
    if voxels > MAX_VOXELS {
        return Err(wrong(format!(
            "{voxels} voxels, at most {MAX_VOXELS} are read"
        )));
    }
    Ok(shape)
}

/// The data must be exactly as long as the header says.
pub(super) fn check_length(path: &Path, header: &NpyHeader, data_bytes: u64) -> Result<()> {
    let voxel_bytes = header.dtype().num_bytes().unwrap_or(0) as u64;
    let expected = header.len() * voxel_bytes;
    let (word, remedy) = match data_bytes.cmp(&expected) {
        std::cmp::Ordering::Equal => return Ok(()),
        std::cmp::Ordering::Less => ("only ", "The file is truncated: copy or save it again."),
        std::cmp::Ordering::Greater => (
            "",
            "Save one array to a file; numpy.load would ignore the rest.",
        ),
    };
    let problem = format!(
        "the header announces {expected} bytes of data ({} voxels of {voxel_bytes}), the file has {word}{data_bytes}",
        header.len()
    );
    Err(Error::input(place(path, "data"), problem, remedy))
}

pub(super) fn bad_header(path: &Path, problem: impl Into<String>) -> Error {
    Error::input(place(path, "header"), problem, SAVE_REMEDY)
}
