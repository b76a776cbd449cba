//! One truth in its folder: the picture, and a sheet with its cost and a checksum of both. An entry that does not agree
//! with its checksum is refused.

use crate::error::{Error, Result};
use crate::frame::atomic::{UNFINISHED, write_atomic};
use crate::frame::{Frame, read_frame, write_frame};
use crate::scene::ImageSize;
use crate::truth::TruthCost;
use serde::{Deserialize, Serialize};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Content of the sheet.
#[derive(Serialize, Deserialize)]
struct TruthSheet {
    cost: TruthCost,
    /// Checksum of the picture's file and `cost`, see [`checksum`].
    checksum: String,
}

/// Role of a file in a truth.
pub(super) enum TruthFile {
    /// The cost of the picture, and a checksum of both.
    Sheet,
    /// The pixels.
    Picture,
    /// A file that is still being written.
    Unfinished,
}

/// The truth that a file belongs to, and its part in it; `None` for a file of another name.
pub(super) fn part_of(name: &str) -> Option<(&str, TruthFile)> {
    if name.starts_with(UNFINISHED.0) && name.ends_with(UNFINISHED.1) {
        return Some((name, TruthFile::Unfinished));
    }
    let (id, extension) = name.split_once('.')?;
    let part = match extension {
        "json" => TruthFile::Sheet,
        "exr" => TruthFile::Picture,
        _ => return None,
    };
    let digit = |c: u8| c.is_ascii_digit() || (b'a'..=b'f').contains(&c);
    (id.len() == 16 && id.bytes().all(digit)).then_some((id, part))
}

/// The sheet of a truth.
pub(super) fn sheet(folder: &Path, id: &str) -> PathBuf {
    folder.join(format!("{id}.json"))
}

/// The picture of a truth.
pub(super) fn picture(folder: &Path, id: &str) -> PathBuf {
    folder.join(format!("{id}.exr"))
}

/// A whole truth; `None` when there is none (a picture without its sheet is one that is being written, or removed).
pub(super) fn read(
    folder: &Path,
    id: &str,
    image: ImageSize,
) -> Result<Option<(Frame, TruthCost)>> {
    let sheet = sheet(folder, id);
    let written = || std::fs::metadata(&sheet).and_then(|found| found.modified());
    let before = written().ok();
    let text = match std::fs::read(&sheet) {
        // `NotADirectory`: a file stands in place of the folder; writing a truth there reports it.
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(None);
        }
        other => other.map_err(Error::reading(&sheet))?,
    };
    match described(&sheet, &text, &picture(folder, id), image) {
        // Another process removed it meanwhile, and may have written it again since.
        Err(_) if before.is_none() || written().ok() != before => Ok(None),
        found => found.map(Some),
    }
}

/// The truth whose sheet holds `text`.
fn described(
    sheet: &Path,
    text: &[u8],
    picture: &Path,
    image: ImageSize,
) -> Result<(Frame, TruthCost)> {
    let unusable = |path: &Path, problem: &str| {
        Error::input(path.display().to_string(), problem, "Nothing to do.")
    };
    let TruthSheet {
        cost,
        checksum: kept,
    } = serde_json::from_slice(text).map_err(|e| unusable(sheet, &e.to_string()))?;
    let bytes = std::fs::read(picture).map_err(Error::reading(picture))?;
    if checksum(&bytes, &cost) != kept {
        return Err(unusable(
            picture,
            "its content does not agree with its checksum",
        ));
    }
    let frame = read_frame(picture)?;
    if (frame.width, frame.height) != (image.width, image.height) {
        return Err(unusable(picture, "it has another size"));
    }
    Ok((frame, cost))
}

/// Writes the picture first: a truth counts only with its sheet.
pub(super) fn write(folder: &Path, id: &str, frame: &Frame, cost: &TruthCost) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(Error::writing(folder))?;
    let (picture, sheet) = (picture(folder, id), sheet(folder, id));
    write_frame(&picture, frame)?;
    let bytes = std::fs::read(&picture).map_err(Error::reading(&picture))?;
    let content = TruthSheet {
        cost: *cost,
        checksum: checksum(&bytes, cost),
    };
    let text = serde_json::to_vec_pretty(&content).map_err(|e| Error::writing(&sheet)(e.into()))?;
    write_atomic(&sheet, |file| {
        file.write_all(&text).map_err(Error::writing(&sheet))
    })
}

/// Hash of a picture's file and its cost, 64 hexadecimal digits.
fn checksum(picture: &[u8], cost: &TruthCost) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(picture);
    hasher.update(format!("{cost:?}").as_bytes());
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::Samples;
    use crate::damage::{Edit, cases, changed, changes, damaged, edits};
    use proptest::prelude::*;
    use std::sync::LazyLock;

    const IMAGE: ImageSize = ImageSize {
        width: 3,
        height: 2,
    };

    fn entry(folder: &Path, image: ImageSize) -> (Frame, TruthCost) {
        let pixels = image.width * image.height;
        let plane = |k: f32| (0..pixels).map(|i| [k * i as f32; 4]).collect();
        let frame = Frame {
            width: image.width,
            height: image.height,
            radiance: plane(0.5),
            sun: plane(0.25),
        };
        let cost = TruthCost {
            march_ms: Some(1.5),
            wall_ms: 2.5,
            samples: Some(Samples::default()),
        };
        write(folder, "t", &frame, &cost).expect("entry");
        (frame, cost)
    }

    /// A truth, its picture's file and its sheet.
    type Whole = ((Frame, TruthCost), Vec<u8>, Vec<u8>);

    /// Made once, because each file is synchronised with the disk.
    static WHOLE: LazyLock<Whole> = LazyLock::new(|| {
        let folder = tempfile::tempdir().expect("folder");
        let written = entry(folder.path(), IMAGE);
        let bytes = |path| std::fs::read(path).expect("file");
        let (picture, sheet) = (picture(folder.path(), "t"), sheet(folder.path(), "t"));
        (written, bytes(picture), bytes(sheet))
    });

    /// An entry is the truth that was written, or nothing, or an error: never another truth.
    fn holds(picture_edits: &[Edit], sheet: impl Fn(&[u8]) -> Vec<u8>) {
        let (written, whole_picture, whole_sheet) = &*WHOLE;
        let folder = tempfile::tempdir().expect("folder");
        let damaged = damaged(whole_picture, picture_edits, usize::MAX);
        std::fs::write(picture(folder.path(), "t"), damaged).expect("written");
        std::fs::write(super::sheet(folder.path(), "t"), sheet(whole_sheet)).expect("written");
        match read(folder.path(), "t", IMAGE) {
            Ok(found) => assert_eq!(found.as_ref(), Some(written)),
            Err(error) => assert!(!error.to_string().chars().any(char::is_control), "{error}"),
        }
    }

    proptest! {
        #![proptest_config(cases())]

        #[test]
        fn a_damaged_entry_is_never_another_truth(
            picture in edits(), sheet in edits(), both in any::<bool>(), which in any::<bool>(),
        ) {
            let (picture, sheet) = match (both, which) {
                (true, _) => (picture, sheet),
                (false, true) => (picture, Vec::new()),
                (false, false) => (Vec::new(), sheet),
            };
            holds(&picture, |bytes| damaged(bytes, &sheet, usize::MAX));
        }

        #[test]
        fn a_changed_sheet_is_never_another_truth(changes in changes()) {
            holds(&[], |bytes| {
                let value = serde_json::from_slice(bytes).expect("sheet");
                changed(value, &changes).to_string().into_bytes()
            });
        }
    }

    #[test]
    fn an_entry_of_another_size_is_refused_and_an_absent_one_is_none() {
        let folder = tempfile::tempdir().expect("folder");
        assert_eq!(read(folder.path(), "t", IMAGE).expect("nothing"), None);
        let other = ImageSize {
            width: 2,
            height: 3,
        };
        let written = entry(folder.path(), other);
        let error = read(folder.path(), "t", IMAGE).expect_err("another size");
        assert!(error.to_string().contains("another size"));
        assert_eq!(
            read(folder.path(), "t", other).expect("whole"),
            Some(written)
        );
    }
}
