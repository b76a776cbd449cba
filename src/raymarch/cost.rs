//! What a picture costs: time, density samples, memory.

use crate::gpu::{FlightTimes, PassTime, Span};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Times of one run, ms; GPU times are `None` where the adapter has no timestamps, or gave invalid ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// The map pass; `None` without a map.
    pub generate: Option<f64>,
    /// The view march, all tiles.
    pub march: Option<f64>,
    /// What temporal integration adds to the pixels it marched; `None` where every pixel is marched.
    pub reconstruct: Option<f64>,
    /// From submission to completion, seen from the CPU; of frames in flight together an equal share, recording included.
    pub wall: f64,
    /// Timestamps of some pass are invalid (see [`PassTime`]): that pass and the total have no time.
    pub refused: bool,
}

impl PassTimes {
    /// From the passes of a picture; `None` for a pass that it does not have.
    pub(super) fn of_passes(
        generate: Option<PassTime>,
        march: PassTime,
        reconstruct: Option<PassTime>,
        wall: f64,
    ) -> Self {
        let parts = [generate, Some(march), reconstruct];
        Self {
            generate: generate.and_then(|pass| pass.ms),
            march: march.ms,
            reconstruct: reconstruct.and_then(|pass| pass.ms),
            wall,
            refused: parts.into_iter().flatten().any(|pass| pass.refused),
        }
    }

    /// Sum of the passes; `None` where one that ran has no time.
    pub fn total(&self) -> Option<f64> {
        let others = [self.generate, self.reconstruct].into_iter().flatten();
        let march = self.march.filter(|_| !self.refused)?;
        Some(march + others.sum::<f64>())
    }
}

/// The passes of one picture in a flight; no spans for a pass that it does not have.
#[derive(Debug, Default)]
pub(super) struct FrameSpans {
    pub generate: Vec<Span>,
    pub march: Vec<Span>,
    pub reconstruct: Vec<Span>,
}

impl FrameSpans {
    /// Times of the picture, one of `frames` in flight together.
    pub fn times(&self, finished: &FlightTimes, frames: u32) -> PassTimes {
        let optional = |spans: &[Span]| (!spans.is_empty()).then(|| finished.pass(spans));
        PassTimes::of_passes(
            optional(&self.generate),
            finished.pass(&self.march),
            optional(&self.reconstruct),
            finished.wall_ms / f64::from(frames),
        )
    }
}

/// What one picture took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Density samples.
    pub samples: Samples,
    /// Light look-ups in a map.
    pub look_ups: u64,
    /// Of these, outside the map and therefore marched.
    pub fallbacks: u64,
}

/// Density samples taken for one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Samples {
    /// By view rays.
    pub view: u64,
    /// By light rays (secondary marches, fallbacks).
    pub light: u64,
    /// By the map pass.
    pub map: u64,
}

/// Memory of a method, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Values × bytes a value × texels.
    pub payload_bytes: u64,
    /// The textures as allocated.
    pub map_bytes: u64,
    /// Growth that wgpu's allocator reports; `null` where the backend does not report.
    pub allocator_bytes: Option<u64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_every_pass_and_nothing_without_a_march() {
        let mut times = PassTimes {
            generate: Some(1.0),
            march: Some(2.0),
            reconstruct: Some(4.0),
            wall: 100.0,
            refused: false,
        };
        assert_eq!(times.total(), Some(7.0));
        times.generate = None;
        assert_eq!(times.total(), Some(6.0));
        times.march = None;
        assert_eq!(times.total(), None);
    }

    #[test]
    fn a_pass_with_invalid_timestamps_is_missing_from_no_sum() {
        let time = |ms| PassTime {
            ms,
            refused: ms.is_none(),
        };
        let times = PassTimes::of_passes(Some(time(None)), time(Some(2.0)), None, 9.0);
        assert_eq!((times.generate, times.march), (None, Some(2.0)));
        assert_eq!(times.total(), None);
        let times = PassTimes::of_passes(Some(time(Some(1.0))), time(Some(2.0)), None, 9.0);
        assert_eq!(times.total(), Some(3.0));
    }
}
