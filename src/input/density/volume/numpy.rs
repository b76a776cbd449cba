//! Imported volumes: NumPy `.npy` files (format 1–3, <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>)
//! and the arrays of `.npz` archives.
//!
//! Values are dimensionless densities as stored: `u8` 255 is density 255, to be scaled by `medium.extinction_per_m`; a bool
//! is 0 or 1. Arrays in C and in Fortran order are read, of either byte order: an index of the array is the same voxel in
//! each. Sizes are checked against the file before anything is allocated.

mod archive;
mod header;

use super::Volume;
use crate::error::{Error, Result};
use crate::file_part::FilePart;
use archive::Member;
use header::{VolumeHeader, bad_header};
use npyz::{DType, NpyFile, NpyHeader, Order, TypeChar, WriteOptions, WriterBuilder};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Most voxels along an axis: what every adapter allows for a 3D texture (`Limits::default`).
pub const MAX_AXIS: u32 = 2048;
/// Most voxels of a volume (8 GiB as f32).
pub const MAX_VOXELS: u64 = 1 << 31;

const SAVE_REMEDY: &str = "Save it with numpy.save(path, numpy.ascontiguousarray(a, dtype=numpy.float32)), three axes, values finite and 0 or more.";

/// A density grid in world order.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Voxels along world x, y (up), z; each 1…[`MAX_AXIS`].
    pub size: [u32; 3],
    /// Densities, finite and ≥ 0: x fastest, then y, then z.
    pub values: Vec<f32>,
    /// BLAKE3 of the `.npy` bytes (of an archive: of the array that was read), for cache keys and reports.
    pub hash: blake3::Hash,
}

/// The file that `volume.path` names, and the array in it: `clouds.npz:density`.
pub fn file_of(path: &Path) -> FilePart {
    FilePart::of(path, "npz")
}

/// Reads `volume.path` (already resolved) and turns its axes into world axes.
///
/// From a `.npz` archive the only array is read, or the one named behind a colon: `clouds.npz:density`.
pub fn load(volume: &Volume) -> Result<Grid> {
    let axes = Axes::new(volume)?;
    let member = open(&volume.path)?;
    let mut reader = BufReader::with_capacity(
        1 << 20,
        Hashing {
            inner: member.reader,
            hasher: blake3::Hasher::new(),
        },
    );
    let header = header::read(&volume.path, &mut reader)?;
    let read = reader_for(&volume.path, &header.npy)?;
    let data_bytes = member.bytes.saturating_sub(header.bytes);
    header::check_length(&volume.path, &header.npy, data_bytes)?;
    let size = axes.world(header.shape);
    let values = read(header, &mut reader, &axes, &volume.path)?;
    Ok(Grid {
        size,
        values,
        hash: reader.into_inner().hasher.finalize(),
    })
}

/// Writes densities as a `.npy` file of axes z, y, x: x fastest, then y, then z, as [`Grid::values`].
pub fn save(
    file: impl Write,
    size: [u32; 3],
    values: impl IntoIterator<Item = f32>,
) -> std::io::Result<()> {
    let [nx, ny, nz] = size.map(u64::from);
    let array = WriteOptions::new()
        .default_dtype()
        .shape(&[nz, ny, nx])
        .writer(file);
    let mut writer = array.begin_nd()?;
    writer.extend(values)?;
    writer.finish()
}

/// Opens the file, or the array inside an archive; the first bytes tell which of the two it is.
fn open(path: &Path) -> Result<Member> {
    let part = file_of(path);
    let io = Error::reading(&part.file);
    let start = |file: &mut File| -> std::io::Result<(Vec<u8>, u64)> {
        let mut start = Vec::new();
        file.take(4).read_to_end(&mut start)?;
        file.seek(SeekFrom::Start(0))?;
        Ok((start, file.metadata()?.len()))
    };
    let opened = File::open(&part.file).and_then(|mut file| Ok((start(&mut file)?, file)));
    let ((start, bytes), file) = opened.map_err(io)?;
    if archive::MAGIC.iter().any(|magic| start == *magic) {
        return archive::open(&part.file, file, part.name.as_deref());
    }
    if part.name.is_some() {
        let place = path.display().to_string();
        let problem = "the file is no .npz archive, so no array can be named in it";
        return Err(Error::input(place, problem, "Give the file alone."));
    }
    let reader = Box::new(file);
    Ok(Member { reader, bytes })
}

/// Assignment of array axes to world axes.
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

/// Reader that hashes the bytes it passes on.
struct Hashing {
    inner: Box<dyn Read>,
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

/// A number as NumPy stores it.
trait Stored: npyz::Deserialize {
    fn value(self) -> f64;
}

macro_rules! stored {
    ($($kind:ty: $value:expr),+ $(,)?) => {
        $(impl Stored for $kind {
            fn value(self) -> f64 {
                let value: fn($kind) -> f64 = $value;
                value(self)
            }
        })+
    };
}

stored! {
    bool: |v| f64::from(u8::from(v)),
    u8: f64::from, u16: f64::from, u32: f64::from, u64: |v| v as f64,
    i8: f64::from, i16: f64::from, i32: f64::from, i64: |v| v as f64,
    npyz::half::f16: f64::from, f32: f64::from, f64: |v| v,
}

type ReadFn<'a> = fn(VolumeHeader, Source<'a>, &Axes, &Path) -> Result<Vec<f32>>;

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
        (TypeChar::Uint, 2) => Ok(read_values::<u16>),
        (TypeChar::Uint, 4) => Ok(read_values::<u32>),
        (TypeChar::Uint, 8) => Ok(read_values::<u64>),
        (TypeChar::Int, 1) => Ok(read_values::<i8>),
        (TypeChar::Int, 2) => Ok(read_values::<i16>),
        (TypeChar::Int, 4) => Ok(read_values::<i32>),
        (TypeChar::Int, 8) => Ok(read_values::<i64>),
        (TypeChar::Bool, 1) => Ok(read_values::<bool>),
        _ => {
            let problem = format!(
                "values are of type {}, allowed are f16, f32, f64, integers of 8 to 64 bits and bool",
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
fn read_values<T: Stored>(
    header: VolumeHeader,
    source: Source<'_>,
    axes: &Axes,
    path: &Path,
) -> Result<Vec<f32>> {
    let shape = header.shape;
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
    // Array axes from the one that changes slowest in the file to the one that changes fastest.
    let [slow, middle, fast] = match header.npy.order() {
        Order::C => [0, 1, 2],
        Order::Fortran => [2, 1, 0],
    };
    let mut data = NpyFile::with_header(header.npy, source)
        .data::<T>()
        .map_err(|e| bad_header(path, e.to_string()))?;
    let mut index = [0; 3];
    for i in 0..shape[slow] {
        index[slow] = i;
        for j in 0..shape[middle] {
            index[middle] = j;
            for k in 0..shape[fast] {
                index[fast] = k;
                let value = data
                    .next()
                    .unwrap_or_else(|| Err(std::io::ErrorKind::UnexpectedEof.into()))
                    .map_err(|e| cannot_read(path, e))?;
                let [x, y, z] = axes.world(index).map(|i| i as usize);
                values[x + nx * (y + ny * z)] = density(value.value(), || {
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

/// The error for a failed read: damage that a decoder or a checksum found, or the operating system's reason.
fn cannot_read(path: &Path, error: std::io::Error) -> Error {
    use std::io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    if !matches!(error.kind(), InvalidData | InvalidInput | UnexpectedEof) {
        return Error::reading(path)(error);
    }
    let problem = format!("the data cannot be read: {error}");
    let remedy = "The file is damaged or truncated: copy or save it again.";
    Error::input(place(path, "data"), problem, remedy)
}

#[cfg(test)]
mod tests;
