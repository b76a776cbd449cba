//! The oracle's truth of a view, kept on disk beside those of devices under a name of its own.

use super::{Options, Oracle};
use crate::error::Result;
use crate::gpu::program;
use crate::raymarch::Progress;
use crate::raymarch::reference::{Counting, Made, Truth, TruthCost, cached};
use std::path::Path;
use std::time::Instant;

/// Text of everything that determines the oracle's picture of a scene: a changed formula makes kept truths stale.
const SOURCES: [&str; 11] = [
    include_str!("mod.rs"),
    include_str!("field.rs"),
    include_str!("layer.rs"),
    include_str!("light.rs"),
    include_str!("march.rs"),
    include_str!("noise.rs"),
    include_str!("procedural.rs"),
    include_str!("texture.rs"),
    include_str!("way.rs"),
    include_str!("../occlusion/truth.rs"),
    include_str!("../occlusion/twin.rs"),
];

/// The truth of `oracle`'s scene at its image size, from `cache` when a whole entry is there. It is counted as it is
/// rendered.
pub fn truth(oracle: &Oracle, cache: Option<&Path>, progress: Progress) -> Result<Truth> {
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
    let mut sources = blake3::Hasher::new();
    for text in SOURCES {
        sources.update(text.as_bytes());
    }
    let all = serde_json::json!({
        "scene": oracle.scene,
        "step_m": oracle.scene.truth_step_m(),
        "image": oracle.image,
        "volume": oracle.field.content_hash(),
        "filter": oracle.field.filter().name(),
        "sources": sources.finalize().to_string(),
        "adapter": "oracle (f64, CPU)",
        "version": program(),
    });
    blake3::hash(all.to_string().as_bytes()).to_hex()[..16].to_owned()
}
