//! Files of a report folder: written in one step, read only inside the folder.

use crate::error::{Error, Result};
use std::io::Write as _;
use std::path::{Component, Path, PathBuf};

/// Replaces `path` in one step; creates its folder when there is none.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::writing(folder))?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".occlab-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // lowered by the user's umask
    }
    let mut file = builder.tempfile_in(folder).map_err(Error::writing(path))?;
    file.write_all(bytes).map_err(Error::writing(path))?;
    file.persist(path)
        .map_err(|e| Error::writing(path)(e.error))?;
    Ok(())
}

/// A record's file path as a path inside `folder`, or why it is refused. The file need not exist.
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

/// A relative link for an `href` or `src`, percent-encoded so that no character has a meaning of its own.
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
