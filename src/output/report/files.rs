//! Files of a report folder: replaced atomically, and read only from inside the folder.

use crate::error::{Error, Result};
use crate::frame::atomic::write_atomic;
use image::RgbImage;
use std::io::{Cursor, Write as _};
use std::path::{Component, Path, PathBuf};

/// Replaces `path` atomically; creates its folder when there is none.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::writing(folder))?;
    write_atomic(path, |file| {
        file.write_all(bytes).map_err(Error::writing(path))
    })
}

/// Writes a set of files into `folder` and removes those of an earlier set, recognised by the prefix of their names.
pub fn replace_all<'a>(
    folder: &Path,
    beginnings: &[&str],
    files: impl Iterator<Item = (&'a str, &'a [u8])>,
) -> Result<()> {
    let mut kept = Vec::new();
    for (name, bytes) in files {
        write(&folder.join(name), bytes)?;
        kept.push(name);
    }
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let figure = name.ends_with(".svg") || name.ends_with(".png");
        let ours = figure && beginnings.iter().any(|b| name.starts_with(b));
        if ours && !kept.contains(&name.as_str()) {
            std::fs::remove_file(entry.path()).map_err(Error::writing(&entry.path()))?;
        }
    }
    Ok(())
}

/// Bytes of the PNG that a record names and the decoded picture, or the reason why there is none.
pub fn picture(folder: &Path, name: &str) -> Result<(Vec<u8>, RgbImage), String> {
    let bytes = std::fs::read(inside(folder, name)?).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => format!("`{name}` is not in the report folder"),
        _ => format!("`{name}` cannot be read: {e}"),
    })?;
    let picture = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png)
        .map_err(|e| format!("`{name}` is not a PNG that can be shown: {e}"))?;
    Ok((bytes, picture.into_rgb8()))
}

/// A picture as the bytes of a PNG file.
pub fn png(picture: &RgbImage) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// A record's file path as a path inside `folder`, or the reason why it is refused. The file need not exist.
pub fn inside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    let refused = || Err(format!("refused: `{name}` leads outside the report folder"));
    let plain = Path::new(name)
        .components()
        .all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if name.is_empty() || !plain || name.contains(['\\', ':', '\0']) {
        return refused();
    }
    let path = folder.join(name);
    match (path.canonicalize(), folder.canonicalize()) {
        (Ok(real), Ok(root)) if !real.starts_with(&root) => refused(),
        _ => Ok(path),
    }
}

/// Relative link for `href` or `src`, with every reserved character percent-encoded.
pub fn link(name: &str) -> String {
    let mut out = String::from("./");
    for byte in name.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'/' => {
                out.push(char::from(byte))
            }
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}
