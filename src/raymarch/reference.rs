//! The truth of a view: rendered once, kept on disk under a hash of everything that determines it, never stale.

use super::cost::Samples;
use super::{Progress, Renderer, View};
use crate::error::{Error, Result};
use crate::frame::atomic::write_atomic;
use crate::frame::{Frame, read_frame, write_frame};
use crate::gpu::sources_hash;
use crate::occlusion::MethodSetup;
use serde::{Deserialize, Serialize};
use std::io::Write;
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
}

/// What rendering a truth took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthCost {
    /// GPU time, ms; `None` without timestamps.
    pub march_ms: Option<f64>,
    /// Submission to completion, ms.
    pub wall_ms: f64,
    /// Density samples.
    pub samples: Samples,
}

/// The folder for truths: `OCCLAB_CACHE`, or the user's cache folder.
pub fn cache_folder() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("OCCLAB_CACHE") {
        return Some(folder.into());
    }
    directories::ProjectDirs::from("", "", "occlab").map(|dirs| dirs.cache_dir().join("truth"))
}

/// The truth of `view`, from `cache` when it is there.
pub fn truth(
    renderer: &Renderer,
    view: &View,
    cache: Option<&Path>,
    progress: Progress,
) -> Result<Truth> {
    let id = truth_id(renderer, view);
    if let Some(found) = cache.and_then(|folder| read(folder, &id, view)) {
        return Ok(found);
    }
    let setup =
        MethodSetup::defaults("truth")?.with("step_m", &view.scene.truth_step_m().to_string())?;
    let times = renderer
        .prepare(view, &setup)?
        .run(&renderer.gpu, progress)?;
    let frame = view.read(&renderer.gpu)?;
    let counting = renderer.prepare_counting(view, &setup)?;
    counting.run(&renderer.gpu, progress)?;
    let samples = counting.counts(&renderer.gpu)?.samples;
    let cost = TruthCost {
        march_ms: times.march,
        wall_ms: times.wall,
        samples,
    };
    if let Some(folder) = cache {
        write(folder, &id, &frame, &cost)?;
    }
    Ok(Truth {
        id,
        frame,
        cost,
        cached: false,
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
        "shaders": sources_hash().to_string(),
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

/// A complete entry of the right size; anything else is rendered again.
fn read(folder: &Path, id: &str, view: &View) -> Option<Truth> {
    let (picture, facts) = paths(folder, id);
    let cost = serde_json::from_slice(&std::fs::read(facts).ok()?).ok()?;
    let frame = read_frame(&picture).ok()?;
    let fits = frame.width == view.image.width && frame.height == view.image.height;
    fits.then(|| Truth {
        id: id.to_owned(),
        frame,
        cost,
        cached: true,
    })
}

/// The picture first: an entry counts only with its facts.
fn write(folder: &Path, id: &str, frame: &Frame, cost: &TruthCost) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(Error::writing(folder))?;
    let (picture, facts) = paths(folder, id);
    write_frame(&picture, frame)?;
    let text = serde_json::to_vec_pretty(cost).map_err(|e| Error::writing(&facts)(e.into()))?;
    write_atomic(&facts, |file| {
        file.write_all(&text).map_err(Error::writing(&facts))
    })
}
