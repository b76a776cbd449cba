//! Imported volumes: NumPy `.npy` files (format 1–3, <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>).
//!
//! Values are dimensionless densities as stored: `u8` 255 is density 255, to be scaled by `medium.extinction_per_m`.
//! Sizes are checked against the file before anything is allocated.

use crate::error::{Error, Result};
use crate::scene::Volume;
use npyz::{DType, NpyFile, NpyHeader, Order, TypeChar};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Most voxels along an axis: what every adapter allows for a 3D texture (`Limits::default`).
pub const MAX_AXIS: u32 = 2048;
/// Most voxels of a volume (8 GiB as f32).
pub const MAX_VOXELS: u64 = 1 << 31;

/// Longest header accepted, bytes; NumPy writes 118 for three axes.
const MAX_HEADER_BYTES: usize = 1 << 16;
/// Most brackets in a header: three axes need two pairs, and deep nesting would exhaust the parser's stack.
const MAX_BRACKETS: usize = 64;
const SAVE_REMEDY: &str = "Save it with numpy.save(path, numpy.ascontiguousarray(a, dtype=numpy.float32)), three axes, values finite and 0 or more.";

/// A density grid in world order.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Voxels along world x, y (up), z; each 1…[`MAX_AXIS`].
    pub size: [u32; 3],
    /// Densities, finite and ≥ 0: x fastest, then y, then z.
    pub values: Vec<f32>,
    /// BLAKE3 of the file, for cache keys and reports.
    pub hash: blake3::Hash,
}

/// Reads `volume.path` (already resolved) and turns its axes into world axes.
pub fn load(volume: &Volume) -> Result<Grid> {
    let axes = Axes::new(volume)?;
    let file = File::open(&volume.path).map_err(Error::reading(&volume.path))?;
    let file_bytes = file.metadata().map_err(Error::reading(&volume.path))?.len();
    let mut reader = BufReader::with_capacity(
        1 << 20,
        Hashing {
            inner: file,
            hasher: blake3::Hasher::new(),
        },
    );
    let (shape, header_bytes) = preflight(&volume.path, &mut reader)?;
    let header =
        NpyHeader::from_reader(&mut reader).map_err(|e| bad_header(&volume.path, e.to_string()))?;
    if header.shape() != shape.map(u64::from) {
        return Err(bad_header(
            &volume.path,
            "the shape is written in an unusual way",
        ));
    }
    if header.order() == Order::Fortran {
        let remedy = "Save numpy.ascontiguousarray(a) instead, in C order.";
        return Err(Error::input(
            place(&volume.path, "header"),
            "the array is in Fortran order",
            remedy,
        ));
    }
    let read = reader_for(&volume.path, &header)?;
    check_length(
        &volume.path,
        &header,
        file_bytes - header_bytes.min(file_bytes),
    )?;
    let npy = NpyFile::with_header(header, &mut reader);
    let values = read(npy, &axes, shape, &volume.path)?;
    Ok(Grid {
        size: axes.world(shape),
        values,
        hash: reader.into_inner().hasher.finalize(),
    })
}

/// Which array axis is which world axis.
struct Axes {
    /// Array axis of world x, y, z.
    array: [usize; 3],
}

impl Axes {
    fn new(volume: &Volume) -> Result<Self> {
        let array = match volume.up_axis {
            0 => [2, 0, 1],
            1 => [2, 1, 0],
            2 => [1, 2, 0],
            other => {
                return Err(Error::input(
                    place(&volume.path, "up_axis"),
                    format!("up_axis is {other}"),
                    "Give 0, 1 or 2.",
                ));
            }
        };
        Ok(Self { array })
    }

    fn world(&self, shape: [u32; 3]) -> [u32; 3] {
        self.array.map(|axis| shape[axis])
    }

    /// `[z=3][y=0][x=7]` for array indices.
    fn element(&self, index: [u32; 3]) -> String {
        let name =
            |axis: usize| ["x", "y", "z"][self.array.iter().position(|a| *a == axis).unwrap_or(0)];
        (0..3)
            .map(|axis| format!("[{}={}]", name(axis), index[axis]))
            .collect()
    }
}

/// Hashes what passes through.
struct Hashing {
    inner: File,
    hasher: blake3::Hasher,
}

impl Read for Hashing {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.hasher.update(&buffer[..n]);
        Ok(n)
    }
}

type Source<'a> = &'a mut BufReader<Hashing>;

/// Reads the header's text, returns shape and header length, and goes back to the start of the file.
///
/// The `.npy` reader multiplies the axes without a check and allocates what the length field says;
/// both are therefore checked here, on the text.
fn preflight(path: &Path, reader: Source<'_>) -> Result<([u32; 3], u64)> {
    let io = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => bad_header(path, "the file ends inside the header"),
        _ => Error::reading(path)(e),
    };
    let mut start = [0; 8];
    reader.read_exact(&mut start).map_err(io)?;
    if &start[..6] != b"\x93NUMPY" {
        return Err(bad_header(path, "this is not a .npy file"));
    }
    let length_bytes = if start[6] == 1 { 2 } else { 4 };
    let mut length = [0; 4];
    reader.read_exact(&mut length[..length_bytes]).map_err(io)?;
    let length = u32::from_le_bytes(length) as usize;
    if length > MAX_HEADER_BYTES {
        return Err(bad_header(
            path,
            format!("the header claims {length} bytes"),
        ));
    }
    let mut text = vec![0; length];
    reader.read_exact(&mut text).map_err(io)?;
    let text = String::from_utf8(text).map_err(|_| bad_header(path, "the header is not text"))?;
    if text.matches(['(', '[', '{']).count() > MAX_BRACKETS {
        return Err(bad_header(path, "the header is nested too deeply"));
    }
    if text.matches(':').count() > 3 {
        return Err(bad_header(
            path,
            "the header has more than descr, fortran_order and shape",
        ));
    }
    // `shape_in` finds the shape by its name: a name that can be hidden in another string, or spelt with escapes, would
    // give the parser a second one.
    if text.contains(['"', '\\']) || text.matches("'shape'").count() > 1 {
        return Err(bad_header(path, "the shape is written in an unusual way"));
    }
    rewind(reader).map_err(Error::reading(path))?;
    Ok((shape_in(path, &text)?, (8 + length_bytes + length) as u64))
}

/// Back to byte 0, with a fresh hash.
fn rewind(reader: Source<'_>) -> std::io::Result<()> {
    let capacity = reader.capacity();
    let mut file = reader.get_ref().inner.try_clone()?;
    file.seek(SeekFrom::Start(0))?;
    *reader = BufReader::with_capacity(
        capacity,
        Hashing {
            inner: file,
            hasher: blake3::Hasher::new(),
        },
    );
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
fn check_length(path: &Path, header: &NpyHeader, data_bytes: u64) -> Result<()> {
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

type ReadFn<'a> = fn(NpyFile<Source<'a>>, &Axes, [u32; 3], &Path) -> Result<Vec<f32>>;

/// The reader for the stored type, in either byte order.
fn reader_for<'a>(path: &Path, header: &NpyHeader) -> Result<ReadFn<'a>> {
    let dtype = header.dtype();
    let kind = match &dtype {
        DType::Plain(kind) => (kind.type_char(), kind.size_field()),
        _ => (TypeChar::Object, 0),
    };
    match kind {
        (TypeChar::Float, 2) => Ok(read_values::<npyz::half::f16>),
        (TypeChar::Float, 4) => Ok(read_values::<f32>),
        (TypeChar::Float, 8) => Ok(read_values::<f64>),
        (TypeChar::Uint, 1) => Ok(read_values::<u8>),
        _ => {
            let problem = format!(
                "values are of type {}, allowed are f16, f32, f64 and u8",
                dtype.descr()
            );
            Err(Error::input(
                place(path, "header, descr"),
                problem,
                SAVE_REMEDY,
            ))
        }
    }
}

/// Streams the array in its own order and writes each value at its world place.
fn read_values<'a, T: npyz::Deserialize + Into<f64>>(
    npy: NpyFile<Source<'a>>,
    axes: &Axes,
    shape: [u32; 3],
    path: &Path,
) -> Result<Vec<f32>> {
    let voxels = shape.iter().map(|n| *n as usize).product();
    let mut values: Vec<f32> = Vec::new();
    values.try_reserve_exact(voxels).map_err(|e| {
        Error::input(
            path.display().to_string(),
            format!("no memory for {voxels} voxels ({e})"),
            "Crop or coarsen the volume.",
        )
    })?;
    values.resize(voxels, 0.0);
    let [nx, ny, _] = axes.world(shape).map(|n| n as usize);
    let mut data = npy
        .data::<T>()
        .map_err(|e| bad_header(path, e.to_string()))?;
    for a in 0..shape[0] {
        for b in 0..shape[1] {
            for c in 0..shape[2] {
                let index = [a, b, c];
                let value = data
                    .next()
                    .unwrap_or_else(|| Err(std::io::ErrorKind::UnexpectedEof.into()))
                    .map_err(Error::reading(path))?;
                let [x, y, z] = axes.world(index).map(|i| i as usize);
                values[x + nx * (y + ny * z)] = density(value.into(), || {
                    place(path, &format!("element {}", axes.element(index)))
                })?;
            }
        }
    }
    Ok(values)
}

/// A finite density ≥ 0 as f32, denormals kept.
fn density(value: f64, place: impl Fn() -> String) -> Result<f32> {
    let narrow = value as f32;
    if value >= 0.0 && narrow.is_finite() {
        return Ok(narrow);
    }
    let (problem, remedy) = if value.is_nan() {
        (
            format!("the value is {value}"),
            "Replace it: numpy.nan_to_num(a).",
        )
    } else if value < 0.0 {
        (
            format!("the density {value} is negative"),
            "Clip it: numpy.maximum(a, 0).",
        )
    } else {
        (
            format!("the density {value} is too large for f32"),
            "Replace infinities and scale the array.",
        )
    };
    Err(Error::input(place(), problem, remedy))
}

fn place(path: &Path, inside: &str) -> String {
    format!("{}, {inside}", path.display())
}

fn bad_header(path: &Path, problem: impl Into<String>) -> Error {
    Error::input(place(path, "header"), problem, SAVE_REMEDY)
}

#[cfg(test)]
mod tests;
