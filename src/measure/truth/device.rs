//! The truth of a view on a device.

use super::{RenderedTruth, Truth, TruthCache, TruthCost, cached, truth_id};
use crate::cost::Counting;
use crate::environment::Environment;
use crate::error::Result;
use crate::occlusion::MethodSetup;
use crate::progress::Progress;
use crate::raymarch::{DeviceView, Frames, Renderer};

/// The truth of `view`, from `cache` when a whole entry is there.
pub fn on_device(
    renderer: &Renderer,
    view: &DeviceView,
    cache: Option<&TruthCache>,
    counting: Counting,
    progress: Progress,
) -> Result<Truth> {
    cached(id(renderer, view), view.image, cache, counting, || {
        render(renderer, view, counting, progress)
    })
}

fn render(
    renderer: &Renderer,
    view: &DeviceView,
    counting: Counting,
    progress: Progress,
) -> Result<RenderedTruth> {
    let setup = MethodSetup::truth(&view.scene)?;
    let times = renderer
        .prepare_full(view, &setup)?
        .run(&renderer.gpu, progress)?;
    let frame = view.read(&renderer.gpu)?;
    let mut wall_ms = times.wall;
    let samples = match counting {
        Counting::Off => None,
        Counting::On => {
            let full = Frames::full();
            let counting = renderer.prepare(view, &setup, &full, Counting::On)?;
            wall_ms += counting.run(&renderer.gpu, progress)?.wall;
            Some(counting.counts(&renderer.gpu)?.samples)
        }
    };
    let cost = TruthCost {
        march_ms: times.march,
        wall_ms: times.wall,
        samples,
    };
    Ok(RenderedTruth {
        frame,
        cost,
        passes_s: wall_ms * 1e-3,
    })
}

fn id(renderer: &Renderer, view: &DeviceView) -> String {
    let environment = Environment::of_device(&renderer.gpu);
    truth_id(serde_json::json!({
        "scene": view.scene,
        "step_m": view.scene.truth_step_m(),
        "image": view.image,
        "skip": view.skips(),
        "volume": view.density.content_hash,
        "shaders": renderer.gpu.sources.hash().to_string(),
        "adapter": [environment.adapter, environment.driver, environment.backend],
    }))
}
