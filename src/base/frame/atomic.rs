//! Atomic file writes: a file appears complete or not at all.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// Prefix and suffix of the name of a file that is still being written.
pub const UNFINISHED: (&str, &str) = (".occlab-", ".part");

/// Writes a file through a temporary one in the same folder, then renames it over `path`.
///
/// A reader sees the old content or the new, never a partial file; when `fill` fails nothing is left behind. The data
/// reaches the disk before the name does, so that a resumed batch may trust a file that exists.
pub fn write_atomic(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
) -> Result<()> {
    temporary(path, fill)?
        .persist(path)
        .map_err(|e| Error::writing(path)(e.error))?;
    Ok(())
}

/// Like [`write_atomic`], but only where `path` does not exist yet; `Ok(false)`, and nothing changed, where it does. Of
/// several processes that try at once exactly one succeeds, on network file systems too.
pub fn create_atomic(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
) -> Result<bool> {
    match temporary(path, fill)?.persist_noclobber(path) {
        Ok(_) => Ok(true),
        Err(e) if e.error.kind() == ErrorKind::AlreadyExists => Ok(false),
        // The file system has neither hard links nor a rename that refuses to replace: some USB sticks and network
        // shares.
        Err(e)
            if matches!(
                e.error.kind(),
                ErrorKind::Unsupported | ErrorKind::PermissionDenied
            ) =>
        {
            copy_new(e.file.path(), path)
        }
        Err(e) => Err(Error::writing(path)(e.error)),
    }
}

/// Copies to a path that does not exist yet; a concurrent reader may see a partial file.
fn copy_new(from: &Path, to: &Path) -> Result<bool> {
    let content = std::fs::read(from).map_err(Error::writing(to))?;
    let mut file = match File::create_new(to) {
        Ok(file) => file,
        Err(e) if e.kind() == ErrorKind::AlreadyExists => return Ok(false),
        Err(e) => return Err(Error::writing(to)(e)),
    };
    let written = file.write_all(&content).and_then(|()| file.sync_all());
    written.map_err(|e| {
        // The error to report is that of the write, not of this clean-up.
        let _ = std::fs::remove_file(to);
        Error::writing(to)(e)
    })?;
    Ok(true)
}

/// Writes a complete temporary file in the folder of `path` and syncs it to the disk.
fn temporary(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
) -> Result<NamedTempFile> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED.0).suffix(UNFINISHED.1);
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
    Ok(temporary)
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
    fn creating_keeps_the_file_that_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let create = |content: &'static [u8]| {
            create_atomic(&path, |file| {
                file.write_all(content).map_err(Error::writing(&path))
            })
            .unwrap()
        };
        assert!(create(b"first") && !create(b"second"));
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
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

    #[test]
    fn a_copy_is_made_where_there_is_no_file_and_nowhere_else() {
        let folder = tempfile::tempdir().expect("folder");
        let [from, to] = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&from, "whole").expect("written");
        assert!(copy_new(&from, &to).expect("copied"));
        std::fs::write(&from, "other").expect("written");
        assert!(!copy_new(&from, &to).expect("kept"));
        assert_eq!(std::fs::read_to_string(&to).expect("read"), "whole");
    }
}
