//! Files that appear whole or not at all.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes a file through a temporary one in the same folder, then renames it over `path`.
///
/// A reader sees the old content or the new, never a half; when `fill` fails nothing is left behind. The data is
/// on the disk before the name is, so that a resumed batch may trust a file that exists.
pub(crate) fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
) -> Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".occlab-").suffix(".part");
    #[cfg(unix)]
    let ordinary = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    // A temporary file is private by default; a result is as readable as the umask lets any new file be.
    #[cfg(unix)]
    builder.permissions(ordinary);
    let temporary = builder.tempfile_in(folder).map_err(Error::writing(path))?;
    let mut buffer = BufWriter::with_capacity(1 << 16, temporary.as_file());
    fill(&mut buffer)?;
    buffer.flush().map_err(Error::writing(path))?;
    drop(buffer);
    temporary
        .as_file()
        .sync_all()
        .map_err(Error::writing(path))?;
    temporary
        .persist(path)
        .map_err(|e| Error::writing(path)(e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failure_keeps_the_old_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        std::fs::write(&path, b"old").unwrap();
        let failed = write_atomic(&path, |file| {
            file.write_all(b"half").map_err(Error::writing(&path))?;
            Err(Error::Stopped)
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn replaces_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        for content in [&b"first"[..], b"second, longer"] {
            write_atomic(&path, |file| {
                file.write_all(content).map_err(Error::writing(&path))
            })
            .unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), content);
        }
    }

    #[cfg(unix)]
    #[test]
    fn is_as_readable_as_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_atomic(&ours, |_| Ok(())).unwrap();
        std::fs::write(&plain, b"").unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none").join("a.bin");
        assert!(
            write_atomic(&path, |_| Ok(()))
                .unwrap_err()
                .to_string()
                .contains("a.bin")
        );
    }
}
