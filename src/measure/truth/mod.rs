//! The truth of a view: rendered once, kept on disk under a hash of everything that determines it, never stale.
//!
//! A damaged entry of the [cache] is rendered again, and a cache that cannot be written costs time but no result.

pub mod cache;
mod device;
mod oracle;

pub use cache::TruthCache;
pub use device::on_device;
pub use oracle::by_oracle;

use crate::cost::{Counting, Samples};
use crate::error::Result;
use crate::frame::Frame;
use crate::scene::ImageSize;
use cache::truth_id;
use serde::{Deserialize, Serialize};

/// A truth and what it took.
pub struct Truth {
    /// Hash that names it, 16 hexadecimal digits.
    pub id: String,
    /// The picture.
    pub frame: Frame,
    /// Measurements of the run that rendered it.
    pub cost: TruthCost,
    /// Whether it was read from the cache.
    pub cached: bool,
    /// Seconds that this call spent in passes, counting included; 0 from the cache.
    pub passes_s: f64,
    /// What went wrong with the cache, for the user; the truth itself is valid.
    pub note: Option<String>,
}

/// Cost of rendering a truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthCost {
    /// GPU time, ms; `None` without timestamps.
    pub march_ms: Option<f64>,
    /// Submission to completion, ms.
    pub wall_ms: f64,
    /// Density samples; `None` when they were not asked for.
    pub samples: Option<Samples>,
}

/// A truth that was just rendered.
pub struct RenderedTruth {
    /// The picture.
    pub frame: Frame,
    /// Cost of rendering it.
    pub cost: TruthCost,
    /// Seconds spent in passes, counting included.
    pub passes_s: f64,
}

/// The truth named `id`, a hash of everything that determines it: from `cache` when a whole entry is there, else what
/// `render` makes, which is then kept.
pub fn cached(
    id: String,
    image: ImageSize,
    cache: Option<&TruthCache>,
    counting: Counting,
    render: impl FnOnce() -> Result<RenderedTruth>,
) -> Result<Truth> {
    let mut notes = Vec::new();
    if let Some(cache) = cache {
        match cache.get(&id, image) {
            Ok(Some((frame, cost))) if cost.samples.is_some() || counting == Counting::Off => {
                return Ok(Truth {
                    id,
                    frame,
                    cost,
                    cached: true,
                    passes_s: 0.0,
                    note: None,
                });
            }
            Ok(_) => {}
            Err(problem) => notes.push(format!(
                "a cached truth was no longer good and is rendered again: {problem}"
            )),
        }
    }
    let made = render()?;
    let (frame, cost) = (made.frame, made.cost);
    if let Some(cache) = cache {
        if let Err(problem) = cache.put(&id, &frame, &cost) {
            notes.push(format!("a truth is not kept for the next run: {problem}"));
        } else if let Err(problem) = cache.trim(&id) {
            notes.push(format!("the truth cache stays over its limit: {problem}"));
        }
    }
    Ok(Truth {
        id,
        frame,
        cost,
        cached: false,
        passes_s: made.passes_s,
        note: (!notes.is_empty()).then(|| notes.join("; ")),
    })
}
