//! The oracle's truth of a view, kept on disk beside those of devices under a name of its own.

use super::{RenderedTruth, Truth, TruthCache, TruthCost, cached, truth_id};
use crate::cost::Counting;
use crate::error::Result;
use crate::oracle::{Options, Oracle};
use crate::progress::Progress;
use std::time::Instant;

/// The truth of `oracle`'s scene at its image size, from `cache` when a whole entry is there. Samples are counted while
/// it is rendered.
pub fn by_oracle(oracle: &Oracle, cache: Option<&TruthCache>, progress: Progress) -> Result<Truth> {
    cached(id(oracle), oracle.image(), cache, Counting::On, || {
        let start = Instant::now();
        let setup = oracle.truth()?;
        let method = oracle.prepare(&setup, Options::default())?;
        let (frame, counts) = method.render(progress)?;
        let cost = TruthCost {
            march_ms: None,
            wall_ms: start.elapsed().as_secs_f64() * 1e3,
            samples: Some(counts.samples),
        };
        Ok(RenderedTruth {
            frame,
            cost,
            passes_s: cost.wall_ms * 1e-3,
        })
    })
}

fn id(oracle: &Oracle) -> String {
    truth_id(serde_json::json!({
        "scene": oracle.scene(),
        "step_m": oracle.scene().truth_step_m(),
        "image": oracle.image(),
        "volume": oracle.content_hash(),
        "filter": oracle.filter().name(),
        "adapter": "oracle (f64, CPU)",
    }))
}
