//! Rounds of a block: every cell in turn, many frames in flight, one wait per cell and round.
//!
//! A device that waits between frames lowers its clock, and the time of a frame of a millisecond then depends on the
//! clock. So before the first timed round a probe runs until its time no longer changes, and in a round each cell
//! submits [`in_flight_ms`](crate::gpu::in_flight_ms) of frames before waiting for any. The round's time of a pass, and
//! of the whole, is the median over these frames.

use crate::backend::Prepared;
use crate::cost::PassTimes;
use crate::error::Result;
use crate::metrics::summarise;

/// Most frames in flight: each holds a submission, and shorter frames than 0.1 ms are bound by submitting them.
const MOST_FRAMES: u32 = 2000;
/// Shortfall, as a share of the aimed work, beyond which a cell is run again with more frames.
const SHORT_BY: f64 = 0.25;
/// Most attempts until the number of frames fits.
const MOST_FLIGHTS: usize = 4;

/// What is timed: a prepared cell, or something of known duration in a test.
pub(super) trait Timed {
    /// Renders `frames` pictures without waiting between them; `meanwhile` is called while they are in flight.
    fn repeat(&self, frames: u32, meanwhile: &mut dyn FnMut()) -> Result<Vec<PassTimes>>;
}

impl Timed for Prepared<'_> {
    fn repeat(&self, frames: u32, meanwhile: &mut dyn FnMut()) -> Result<Vec<PassTimes>> {
        Prepared::repeat(self, frames, meanwhile)
    }
}

/// One cell in one round.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Round {
    /// Median of each pass over the frames whose timestamps are valid.
    pub times: PassTimes,
    /// Median of the frames' total times, ms, which need not be the sum of the passes' medians.
    pub total_ms: Option<f64>,
    /// Frames in flight.
    pub frames: u32,
    /// Frames among them with invalid timestamps.
    pub refused: u32,
    /// Seconds of all frames, those of attempts with too few frames included.
    pub seconds: f64,
}

/// Keeps frames of `aim_ms` in all in flight, and waits for them. `frame_ms` is the estimated time of one; afterwards
/// the measured time.
pub(super) fn fly(
    cell: &impl Timed,
    aim_ms: f64,
    frame_ms: &mut f64,
    meanwhile: &mut dyn FnMut(),
) -> Result<Round> {
    let mut seconds = 0.0;
    let mut flights = 0;
    loop {
        let frames = (aim_ms / *frame_ms).ceil();
        let frames = frames.clamp(1.0, f64::from(MOST_FRAMES)) as u32;
        let runs = cell.repeat(frames, meanwhile)?;
        flights += 1;
        seconds += runs.iter().map(|run| run.wall * 1e-3).sum::<f64>();
        let work_ms: f64 = runs.iter().map(cost_ms).sum();
        *frame_ms = work_ms / f64::from(frames);
        let enough = work_ms >= aim_ms * (1.0 - SHORT_BY) || frames == MOST_FRAMES;
        if enough || flights == MOST_FLIGHTS {
            return Ok(Round {
                times: medians(&runs),
                total_ms: median(&runs, PassTimes::total),
                frames,
                refused: runs.iter().filter(|run| run.refused).count() as u32,
                seconds,
            });
        }
    }
}

/// Device time of a frame, ms; its share of the wall time where there are no timestamps.
pub(super) fn cost_ms(run: &PassTimes) -> f64 {
    run.total().unwrap_or(run.wall).max(1e-6)
}

/// A time over the frames that have it; a frame with invalid timestamps in one pass counts in none: its passes belong
/// together.
fn median(runs: &[PassTimes], of: fn(&PassTimes) -> Option<f64>) -> Option<f64> {
    let valid = runs.iter().filter(|run| !run.refused);
    let times: Vec<f64> = valid.filter_map(of).collect();
    summarise(&times).map(|stats| stats.median)
}

/// Median of each pass; a pass has none where no frame has.
fn medians(runs: &[PassTimes]) -> PassTimes {
    PassTimes {
        generate: median(runs, |run| run.generate),
        march: median(runs, |run| run.march),
        reconstruct: median(runs, |run| run.reconstruct),
        wall: runs.iter().map(|run| run.wall).sum::<f64>() / runs.len().max(1) as f64,
        refused: runs.iter().all(|run| run.refused),
    }
}

/// Note on frames with invalid timestamps; `None` where there are none.
pub(super) fn note(rounds: &[Round]) -> Option<String> {
    let refused: u32 = rounds.iter().map(|round| round.refused).sum();
    let frames: u32 = rounds.iter().map(|round| round.frames).sum();
    (refused > 0).then(|| {
        format!(
            "time: {refused} of {frames} frames have invalid timestamps (0, reversed, left over, or longer than the frames \
             took as seen from the CPU); they count in no time"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    const AIM_MS: f64 = 200.0;

    /// A cell whose frames take a known time; `bad` of them, counted over all flights, have no timestamps.
    struct Known {
        frame_ms: f64,
        bad: fn(u32) -> bool,
        flights: RefCell<Vec<u32>>,
    }

    impl Known {
        fn new(frame_ms: f64, bad: fn(u32) -> bool) -> Self {
            Self {
                frame_ms,
                bad,
                flights: RefCell::default(),
            }
        }
    }

    impl Timed for Known {
        fn repeat(&self, frames: u32, meanwhile: &mut dyn FnMut()) -> Result<Vec<PassTimes>> {
            meanwhile();
            self.flights.borrow_mut().push(frames);
            let frame = |i| {
                let refused = (self.bad)(i);
                PassTimes {
                    generate: (!refused).then_some(self.frame_ms * 0.25),
                    march: Some(self.frame_ms * 0.75),
                    wall: self.frame_ms * 1.1,
                    refused,
                    ..PassTimes::default()
                }
            };
            Ok((0..frames).map(frame).collect())
        }
    }

    #[test]
    fn the_queue_is_full_whatever_was_thought_of_the_frame() {
        for (frame_ms, thought_ms) in [(1.0, 8.0), (0.3, 50.0), (40.0, 1.0), (900.0, 900.0)] {
            let cell = Known::new(frame_ms, |_| false);
            let mut known_ms = thought_ms;
            let round = fly(&cell, AIM_MS, &mut known_ms, &mut || ()).expect("round");
            let work_ms = f64::from(round.frames) * frame_ms;
            assert!(work_ms >= 0.75 * AIM_MS, "{frame_ms}: {work_ms}");
            assert!((known_ms / frame_ms - 1.0).abs() < 1e-9);
            assert!((round.total_ms.expect("time") / frame_ms - 1.0).abs() < 1e-9);
            let flown: u32 = cell.flights.borrow().iter().sum();
            assert!((round.seconds - f64::from(flown) * frame_ms * 1.1e-3).abs() < 1e-9);
        }
    }

    #[test]
    fn a_frame_as_long_as_the_aim_flies_once_and_alone() {
        let cell = Known::new(300.0, |_| false);
        fly(&cell, AIM_MS, &mut 300.0, &mut || ()).expect("round");
        assert_eq!(*cell.flights.borrow(), [1]);
    }

    #[test]
    fn frames_without_a_time_count_in_none_and_are_noted() {
        let some = Known::new(10.0, |i| i % 4 == 0);
        let round = fly(&some, AIM_MS, &mut 10.0, &mut || ()).expect("round");
        assert_eq!((round.frames, round.refused), (20, 5));
        assert_eq!((round.total_ms, round.times.refused), (Some(10.0), false));
        let text = note(&[round]).expect("note");
        assert!(text.contains("5 of 20 frames"), "{text}");

        let all = Known::new(10.0, |_| true);
        let round = fly(&all, AIM_MS, &mut 10.0, &mut || ()).expect("round");
        assert_eq!(round.total_ms, None);
        assert_eq!((round.times.march, round.times.generate), (None, None));
        assert_eq!(note(&[Round::default()]), None);
    }

    #[test]
    fn the_total_is_that_of_the_middle_frame_and_not_the_sum_of_middle_passes() {
        let frame = |generate, march| PassTimes {
            generate: Some(generate),
            march: Some(march),
            ..PassTimes::default()
        };
        let runs = [frame(1.0, 9.0), frame(2.0, 4.0), frame(8.0, 3.0)];
        let passes = medians(&runs);
        assert_eq!((passes.generate, passes.march), (Some(2.0), Some(4.0)));
        assert_eq!(median(&runs, PassTimes::total), Some(10.0));
    }
}
