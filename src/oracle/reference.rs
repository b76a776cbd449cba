//! The oracle's truth of a view, kept on disk beside those of devices under a name of its own.

use super::{Options, Oracle};
use crate::error::Result;
use crate::raymarch::Progress;
use crate::raymarch::reference::{Counting, Made, Truth, TruthCost, cached};
use crate::raymarch::truth_cache::{TruthCache, truth_id};
use std::time::Instant;

/// The truth of `oracle`'s scene at its image size, from `cache` when a whole entry is there. It is counted as it is
/// rendered.
pub fn truth(oracle: &Oracle, cache: Option<&TruthCache>, progress: Progress) -> Result<Truth> {
    cached(id(oracle), oracle.image, cache, Counting::On, || {
        let start = Instant::now();
        let setup = oracle.truth()?;
        let method = oracle.prepare(&setup, Options::default())?;
        let (frame, counts) = method.render(progress)?;
        let cost = TruthCost {
            march_ms: None,
            wall_ms: start.elapsed().as_secs_f64() * 1e3,
            samples: Some(counts.samples),
        };
        Ok(Made {
            frame,
            cost,
            passes_s: cost.wall_ms * 1e-3,
        })
    })
}

fn id(oracle: &Oracle) -> String {
    truth_id(serde_json::json!({
        "scene": oracle.scene,
        "step_m": oracle.scene.truth_step_m(),
        "image": oracle.image,
        "volume": oracle.field.content_hash(),
        "filter": oracle.field.filter().name(),
        "adapter": "oracle (f64, CPU)",
    }))
}
