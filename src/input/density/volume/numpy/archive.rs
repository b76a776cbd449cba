//! NumPy `.npz` files: zip archives of `.npy` members, stored or deflated, as `numpy.savez` and `numpy.savez_compressed`
//! write them (<https://pkware.cachefly.net/webdocs/casestudies/APPNOTE.TXT>).

use super::place;
use crate::error::{Error, Result};
use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, ErrorKind, ZipArchive, ZipArchiveEntryWayfinder};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// First bytes of a zip archive: those of a member, or of the end of an archive without members.
pub(super) const MAGIC: [&[u8; 4]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];
/// Largest expansion of deflate, bytes from a byte (<https://zlib.net/zlib_tech.html>).
const MOST_EXPANSION: u64 = 1032;
const DAMAGED: &str = "The file is damaged or truncated: copy or save it again.";

/// The bytes of one `.npy` file.
pub(super) struct Member {
    pub reader: Box<dyn Read>,
    /// Bytes that `reader` yields; the reader fails if there are more or fewer.
    pub bytes: u64,
}

/// A member as the archive's directory lists it.
struct Listed {
    /// Without `.npy`, as `numpy.load` names it.
    name: String,
    method: CompressionMethod,
    encrypted: bool,
    at: ZipArchiveEntryWayfinder,
}

/// Opens the array called `name`, or the only one there is. Size and checksum are checked while it is read.
pub(super) fn open(path: &Path, mut file: File, name: Option<&str>) -> Result<Member> {
    let unusable = |e: rawzip::Error| unusable(path, e);
    let file_bytes = file.metadata().map_err(Error::reading(path))?.len();
    let mut buffer = vec![0; rawzip::MAX_CENTRAL_DIRECTORY_RECORD_SIZE];
    let own = file.try_clone().map_err(Error::reading(path))?;
    let archive = ZipArchive::from_file(own, &mut buffer).map_err(unusable)?;
    let mut arrays = Vec::new();
    let mut entries = archive.entries(&mut buffer);
    while let Some(entry) = entries.next_entry().map_err(unusable)? {
        let file_name = String::from_utf8_lossy(entry.file_path().as_bytes()).into_owned();
        if let Some(name) = file_name.strip_suffix(".npy") {
            arrays.push(Listed {
                name: name.to_owned(),
                method: entry.compression_method(),
                encrypted: entry.flags().is_encrypted(),
                at: entry.wayfinder(),
            });
        }
    }
    let array = choose(path, &arrays, name)?;
    let entry = archive.get_entry(array.at).map_err(unusable)?;
    let bytes = array.at.uncompressed_size_hint();
    let (start, end) = entry.compressed_data_range();
    if end > file_bytes {
        let problem = format!("the array ends at byte {end}, the file at byte {file_bytes}");
        return Err(Error::input(place(path, "archive"), problem, DAMAGED));
    }
    check_expansion(path, array, bytes, end - start)?;
    file.seek(SeekFrom::Start(start))
        .map_err(Error::reading(path))?;
    let data = file.take(end - start);
    let reader: Box<dyn Read> = match array.method {
        CompressionMethod::STORE => Box::new(entry.verifying_reader(data)),
        _ => Box::new(entry.verifying_reader(DeflateDecoder::new(data))),
    };
    Ok(Member { reader, bytes })
}

/// The array called `name`; without a name the only one.
fn choose<'a>(path: &Path, arrays: &'a [Listed], name: Option<&str>) -> Result<&'a Listed> {
    let wrong = |problem: String, remedy: String| {
        Err(Error::input(path.display().to_string(), problem, remedy))
    };
    let names = || {
        let quoted = arrays.iter().map(|a| format!("`{}`", a.name));
        quoted.collect::<Vec<_>>().join(", ")
    };
    let fits = |array: &&Listed| name.is_none_or(|n| n == array.name);
    let mut found = arrays.iter().filter(fits);
    match (found.next(), found.next(), name) {
        (Some(array), None, _) => Ok(array),
        (None, _, _) if arrays.is_empty() => wrong(
            "the archive holds no array".into(),
            "Save one with numpy.savez_compressed(path, density=a).".into(),
        ),
        (Some(first), Some(_), None) => wrong(
            format!("the archive holds {} arrays: {}", arrays.len(), names()),
            format!("Name one, for example {}:{}.", path.display(), first.name),
        ),
        (None, _, Some(name)) => wrong(
            format!("the archive has no array `{name}`"),
            format!("It holds {}.", names()),
        ),
        (_, _, name) => wrong(
            format!("the archive has two arrays `{}`", name.unwrap_or_default()),
            "Save it again with a name for each.".into(),
        ),
    }
}

/// Refuses an array that cannot be read, and a size that the compressed bytes cannot account for, before memory is
/// taken.
fn check_expansion(path: &Path, array: &Listed, bytes: u64, stored_bytes: u64) -> Result<()> {
    let wrong = |problem: String, remedy: &str| {
        let inside = format!("array `{}`", array.name);
        Err(Error::input(place(path, &inside), problem, remedy))
    };
    let save = "Save it with numpy.savez or numpy.savez_compressed.";
    if array.encrypted {
        return wrong("the array is encrypted".into(), save);
    }
    let most = match array.method {
        CompressionMethod::STORE => stored_bytes,
        CompressionMethod::DEFLATE => stored_bytes.saturating_mul(MOST_EXPANSION),
        other => return wrong(format!("it is compressed by method {other}"), save),
    };
    if bytes <= most {
        return Ok(());
    }
    let problem = format!(
        "the archive announces {bytes} bytes, {stored_bytes} stored bytes hold at most {most}"
    );
    wrong(problem, DAMAGED)
}

/// The library's error for an archive that cannot be read.
fn unusable(path: &Path, error: rawzip::Error) -> Error {
    let problem = match error.into_kind() {
        ErrorKind::IO(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => {
            return Error::reading(path)(e);
        }
        ErrorKind::IO(_) | ErrorKind::Eof | ErrorKind::MissingEndOfCentralDirectory => {
            "the archive's end, where its members are listed, is missing".to_owned()
        }
        other => format!("not a usable archive: {other}"),
    };
    Error::input(place(path, "archive"), problem, DAMAGED)
}
