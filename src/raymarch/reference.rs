//! The truth of a view: rendered once, kept on disk under a hash of everything that determines it, never stale.
//!
//! An entry is two files: the picture, and a sheet with what it took and a checksum of both. Whatever does not agree with
//! its checksum is rendered again, and a cache that cannot be written costs time but no result.

use super::cost::Samples;
use super::{Progress, Renderer, View};
use crate::error::{Error, Result};
use crate::frame::atomic::write_atomic;
use crate::frame::{Frame, read_frame, write_frame};
use crate::occlusion::MethodSetup;
use crate::scene::ImageSize;
use serde::{Deserialize, Serialize};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// A truth and what it took.
pub struct Truth {
    /// Hash that names it, 16 hexadecimal digits.
    pub id: String,
    /// The picture.
    pub frame: Frame,
    /// Measurements of the run that rendered it.
    pub cost: TruthCost,
    /// Read from the disk.
    pub cached: bool,
    /// Seconds that this call spent in passes, counting included; 0 from the cache.
    pub passes_s: f64,
    /// What went wrong with the cache, for the person who runs the batch; the truth itself is good.
    pub note: Option<String>,
}

/// What rendering a truth took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthCost {
    /// GPU time, ms; `None` without timestamps.
    pub march_ms: Option<f64>,
    /// Submission to completion, ms.
    pub wall_ms: f64,
    /// Density samples; `None` when nobody asked for them.
    pub samples: Option<Samples>,
}

/// A truth that was just rendered.
pub struct Made {
    /// The picture.
    pub frame: Frame,
    /// What rendering took.
    pub cost: TruthCost,
    /// Seconds spent in passes, counting included.
    pub passes_s: f64,
}

/// Whether the density samples of a truth are wanted: counting them takes a second render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counting {
    /// Render and count.
    On,
    /// Only render.
    Off,
}

/// Second file of an entry.
#[derive(Serialize, Deserialize)]
struct Sheet {
    cost: TruthCost,
    /// Of the picture's file and `cost`, see [`checksum`].
    checksum: String,
}

/// The folder for truths: `OCCLAB_CACHE` unless it is empty, or the user's cache folder.
pub fn cache_folder() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("OCCLAB_CACHE").filter(|folder| !folder.is_empty()) {
        return Some(folder.into());
    }
    directories::ProjectDirs::from("", "", "occlab").map(|dirs| dirs.cache_dir().join("truth"))
}

/// The truth of `view`, from `cache` when a whole entry is there.
pub fn truth(
    renderer: &Renderer,
    view: &View,
    cache: Option<&Path>,
    counting: Counting,
    progress: Progress,
) -> Result<Truth> {
    let id = truth_id(renderer, view);
    cached(id, view.image, cache, counting, || {
        render(renderer, view, counting, progress)
    })
}

/// The truth named `id`, a hash of everything that determines it: from `cache` when a whole entry is there, else what
/// `render` makes, which is then kept.
pub fn cached(
    id: String,
    image: ImageSize,
    cache: Option<&Path>,
    counting: Counting,
    render: impl FnOnce() -> Result<Made>,
) -> Result<Truth> {
    let mut note = None;
    if let Some(folder) = cache {
        match read(folder, &id, image) {
            Ok(Some((frame, cost))) if cost.samples.is_some() || counting == Counting::Off => {
                return Ok(Truth {
                    id,
                    frame,
                    cost,
                    cached: true,
                    passes_s: 0.0,
                    note,
                });
            }
            Ok(_) => {}
            Err(problem) => {
                note = Some(format!(
                    "a cached truth was no longer good and is rendered again: {problem}"
                ));
            }
        }
    }
    let made = render()?;
    let (frame, cost) = (made.frame, made.cost);
    if let Some(folder) = cache
        && let Err(problem) = write(folder, &id, &frame, &cost)
    {
        note = Some(format!("a truth is not kept for the next run: {problem}"));
    }
    Ok(Truth {
        id,
        frame,
        cost,
        cached: false,
        passes_s: made.passes_s,
        note,
    })
}

fn render(
    renderer: &Renderer,
    view: &View,
    counting: Counting,
    progress: Progress,
) -> Result<Made> {
    let setup = MethodSetup::truth(&view.scene)?;
    let times = renderer
        .prepare(view, &setup)?
        .run(&renderer.gpu, progress)?;
    let frame = view.read(&renderer.gpu)?;
    let mut wall_ms = times.wall;
    let samples = match counting {
        Counting::Off => None,
        Counting::On => {
            let counting = renderer.prepare_counting(view, &setup)?;
            wall_ms += counting.run(&renderer.gpu, progress)?.wall;
            Some(counting.counts(&renderer.gpu)?.samples)
        }
    };
    let cost = TruthCost {
        march_ms: times.march,
        wall_ms: times.wall,
        samples,
    };
    Ok(Made {
        frame,
        cost,
        passes_s: wall_ms * 1e-3,
    })
}

fn truth_id(renderer: &Renderer, view: &View) -> String {
    let environment = renderer.gpu.environment();
    let all = serde_json::json!({
        "scene": view.scene,
        "step_m": view.scene.truth_step_m(),
        "image": view.image,
        "skip": view.skip,
        "volume": view.density.content_hash,
        "shaders": renderer.gpu.sources.hash().to_string(),
        "adapter": [environment.adapter, environment.driver, environment.backend],
        "version": environment.commit,
    });
    blake3::hash(all.to_string().as_bytes()).to_hex()[..16].to_owned()
}

fn paths(folder: &Path, id: &str) -> (PathBuf, PathBuf) {
    (
        folder.join(format!("{id}.exr")),
        folder.join(format!("{id}.json")),
    )
}

/// A whole entry; `None` when there is none (a picture without its sheet is one that was being written).
fn read(folder: &Path, id: &str, image: ImageSize) -> Result<Option<(Frame, TruthCost)>> {
    let (picture, sheet) = paths(folder, id);
    let text = match std::fs::read(&sheet) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        other => other.map_err(Error::reading(&sheet))?,
    };
    let unusable = |path: &Path, problem: &str| {
        Error::input(path.display().to_string(), problem, "Nothing to do.")
    };
    let Sheet {
        cost,
        checksum: kept,
    } = serde_json::from_slice(&text).map_err(|e| unusable(&sheet, &e.to_string()))?;
    let bytes = std::fs::read(&picture).map_err(Error::reading(&picture))?;
    if checksum(&bytes, &cost) != kept {
        return Err(unusable(
            &picture,
            "its content does not agree with its checksum",
        ));
    }
    let frame = read_frame(&picture)?;
    if (frame.width, frame.height) != (image.width, image.height) {
        return Err(unusable(&picture, "it has another size"));
    }
    Ok(Some((frame, cost)))
}

/// The picture first: an entry counts only with its sheet.
fn write(folder: &Path, id: &str, frame: &Frame, cost: &TruthCost) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(Error::writing(folder))?;
    let (picture, sheet) = paths(folder, id);
    write_frame(&picture, frame)?;
    let bytes = std::fs::read(&picture).map_err(Error::reading(&picture))?;
    let content = Sheet {
        cost: *cost,
        checksum: checksum(&bytes, cost),
    };
    let text = serde_json::to_vec_pretty(&content).map_err(|e| Error::writing(&sheet)(e.into()))?;
    write_atomic(&sheet, |file| {
        file.write_all(&text).map_err(Error::writing(&sheet))
    })
}

/// Hash of a picture's file and of what it took, 64 hexadecimal digits.
fn checksum(picture: &[u8], cost: &TruthCost) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(picture);
    hasher.update(format!("{cost:?}").as_bytes());
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let (picture, sheet) = paths(folder.path(), "t");
        let bytes = |path| std::fs::read(path).expect("file");
        (written, bytes(picture), bytes(sheet))
    });

    /// An entry is the truth that was written, or nothing, or an error: never another truth.
    fn holds(picture_edits: &[Edit], sheet: impl Fn(&[u8]) -> Vec<u8>) {
        let (written, whole_picture, whole_sheet) = &*WHOLE;
        let folder = tempfile::tempdir().expect("folder");
        let (picture_path, sheet_path) = paths(folder.path(), "t");
        let picture = damaged(whole_picture, picture_edits, usize::MAX);
        std::fs::write(&picture_path, picture).expect("written");
        std::fs::write(&sheet_path, sheet(whole_sheet)).expect("written");
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
