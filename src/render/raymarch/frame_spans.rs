//! Timed passes of one picture within a flight.

use crate::cost::PassTimes;
use crate::gpu::{FlightTimes, PassTime, Span};

/// Times of a picture from those of its passes; `None` for a pass that it does not have.
pub(super) fn pass_times(
    generate: Option<PassTime>,
    march: PassTime,
    reconstruct: Option<PassTime>,
    wall: f64,
) -> PassTimes {
    let parts = [generate, Some(march), reconstruct];
    PassTimes {
        generate: generate.and_then(|pass| pass.ms),
        march: march.ms,
        reconstruct: reconstruct.and_then(|pass| pass.ms),
        wall,
        refused: parts.into_iter().flatten().any(|pass| pass.refused),
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
        pass_times(
            optional(&self.generate),
            finished.pass(&self.march),
            optional(&self.reconstruct),
            finished.wall_ms / f64::from(frames),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_with_invalid_timestamps_is_missing_from_no_sum() {
        let time = |ms| PassTime {
            ms,
            refused: ms.is_none(),
        };
        let times = pass_times(Some(time(None)), time(Some(2.0)), None, 9.0);
        assert_eq!((times.generate, times.march), (None, Some(2.0)));
        assert_eq!(times.total(), None);
        let times = pass_times(Some(time(Some(1.0))), time(Some(2.0)), None, 9.0);
        assert_eq!(times.total(), Some(3.0));
    }
}
