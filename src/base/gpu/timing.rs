//! GPU time of compute passes, by timestamp queries at their begin and end, for work that is submitted without waiting.
//!
//! A device that idles between two passes lowers its clock, and a pass of 1 ms then measures that lower clock. So work
//! is put into a [`Flight`]: many submissions, one wait at the end, and only then the times are read.

use super::context::Gpu;
use super::kernel::Kernel;
use super::readback::read_buffer;
use crate::error::Result;
use std::cell::{Cell, RefCell};
use std::time::Instant;

/// Passes of one submission that are timed: their timestamps fill what `resolve_query_set` aligns to, 256 bytes.
const SPANS_A_SUBMISSION: usize = 16;
/// Submissions that a set of queries serves; WebGPU allows 4096 queries in a set.
const SUBMISSIONS_A_SET: usize = 4096 / (2 * SPANS_A_SUBMISSION);
const SLOT_QUERIES: u32 = 2 * SPANS_A_SUBMISSION as u32;
const SLOT_BYTES: u64 = SLOT_QUERIES as u64 * 8;
/// Relative excess of GPU times over CPU times above which timestamps are refused: clocks drift apart by parts in a
/// million, and reading the CPU's clock takes microseconds.
const CLOCK_TOLERANCE: f64 = 0.01;

/// Timestamp queries of a device, for one flight at a time.
pub struct Timer {
    sets: RefCell<Vec<QuerySet>>,
    /// Latest timestamp of the flights so far: an earlier one is left over from them.
    latest: Cell<u64>,
}

#[derive(Clone)]
struct QuerySet {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Timer {
    /// A timer without query sets: they are made as flights need them.
    pub(super) fn new() -> Self {
        Self {
            sets: RefCell::default(),
            latest: Cell::new(0),
        }
    }

    /// The set of a flight's submission.
    fn set(&self, gpu: &Gpu, submission: usize) -> QuerySet {
        let mut sets = self.sets.borrow_mut();
        let index = submission / SUBMISSIONS_A_SET;
        while sets.len() <= index {
            let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass times"),
                ty: wgpu::QueryType::Timestamp,
                count: SLOT_QUERIES * SUBMISSIONS_A_SET as u32,
            });
            let resolved = gpu.empty_buffer(
                "pass times",
                SLOT_BYTES * SUBMISSIONS_A_SET as u64,
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            );
            sets.push(QuerySet { queries, resolved });
        }
        sets[index].clone()
    }
}

/// One pass of a flight, by the order in which they were recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span(usize);

/// Where the timestamps of a span are.
#[derive(Clone, Copy)]
struct Place {
    submission: usize,
    /// Index among the spans of its submission.
    index: usize,
}

/// Work submitted to the device without waiting.
pub struct Flight<'g> {
    gpu: &'g Gpu,
    encoder: Option<wgpu::CommandEncoder>,
    /// Buffers written for the commands that are not submitted yet.
    written: Vec<wgpu::Buffer>,
    spans: Vec<Place>,
    submission: usize,
    spans_of_submission: usize,
    start: Instant,
}

/// Times of a finished flight.
pub struct FlightTimes {
    /// From the flight's begin to the end of its work, seen from the CPU, ms.
    pub wall_ms: f64,
    spans_ms: Option<Vec<Option<f64>>>,
}

/// Time of a pass that may have several spans.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTime {
    /// Sum of its spans, ms; `None` without timestamps or where those of one span are invalid.
    pub ms: Option<f64>,
    /// Timestamps of some span are invalid: 0, reversed, longer than the flight took, or from before it.
    pub refused: bool,
}

impl PassTime {
    /// Time of a pass in parts.
    pub fn sum(parts: &[Self]) -> Self {
        Self {
            ms: parts.iter().map(|part| part.ms).sum(),
            refused: parts.iter().any(|part| part.refused),
        }
    }
}

impl<'g> Flight<'g> {
    /// An empty flight.
    pub fn new(gpu: &'g Gpu) -> Self {
        Self {
            gpu,
            encoder: None,
            written: Vec::new(),
            spans: Vec::new(),
            submission: 0,
            spans_of_submission: 0,
            start: Instant::now(),
        }
    }

    /// Does the adapter compute on the processor?
    pub fn is_software(&self) -> bool {
        self.gpu.is_software()
    }

    /// Records a dispatch over `threads` in a pass of its own. `uniform` is a buffer to be filled before it.
    pub fn dispatch(
        &mut self,
        kernel: &Kernel,
        groups: &[wgpu::BindGroup],
        threads: [u32; 3],
        uniform: Option<(&wgpu::Buffer, &[u8])>,
    ) -> Span {
        let rewritten = uniform.is_some_and(|(buffer, _)| self.written.contains(buffer));
        if rewritten || self.spans_of_submission == SPANS_A_SUBMISSION {
            self.submit();
        }
        if let Some((buffer, bytes)) = uniform {
            // Written before everything that the next submission does, and after what was submitted before.
            self.gpu.queue.write_buffer(buffer, 0, bytes);
            self.written.push(buffer.clone());
        }
        let place = Place {
            submission: self.submission,
            index: self.spans_of_submission,
        };
        let timer = self.gpu.timer();
        let set = timer.map(|timer| timer.set(self.gpu, place.submission));
        let device = &self.gpu.device;
        let encoder = self
            .encoder
            .get_or_insert_with(|| device.create_command_encoder(&Default::default()));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: set.as_ref().map(|set| {
                let begin = place.first_query();
                wgpu::ComputePassTimestampWrites {
                    query_set: &set.queries,
                    beginning_of_pass_write_index: Some(begin),
                    end_of_pass_write_index: Some(begin + 1),
                }
            }),
        });
        kernel.dispatch(&mut pass, groups, threads);
        drop(pass);
        self.spans.push(place);
        self.spans_of_submission += 1;
        Span(self.spans.len() - 1)
    }

    /// Submits what was recorded; later dispatches go into another submission.
    pub fn submit(&mut self) {
        let Some(mut encoder) = self.encoder.take() else {
            return;
        };
        if let Some(timer) = self.gpu.timer() {
            let set = timer.set(self.gpu, self.submission);
            let slot = self.submission % SUBMISSIONS_A_SET;
            let first = slot as u32 * SLOT_QUERIES;
            let queries = first..first + 2 * self.spans_of_submission as u32;
            let offset = slot as u64 * SLOT_BYTES;
            encoder.resolve_query_set(&set.queries, queries, &set.resolved, offset);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.written.clear();
        self.submission += 1;
        self.spans_of_submission = 0;
    }

    /// Submits the rest and waits for all of it; `meanwhile` is called between the two, when most of a long flight is
    /// still to be done.
    pub fn finish(mut self, meanwhile: impl FnOnce()) -> Result<FlightTimes> {
        self.submit();
        meanwhile();
        self.gpu.wait()?;
        let wall_ms = self.start.elapsed().as_secs_f64() * 1e3;
        let spans_ms = match self.gpu.timer() {
            None => None,
            Some(timer) => Some(self.read(timer, wall_ms)?),
        };
        Ok(FlightTimes { wall_ms, spans_ms })
    }

    fn read(&self, timer: &Timer, wall_ms: f64) -> Result<Vec<Option<f64>>> {
        let mut ticks: Vec<u64> = Vec::new();
        for first in (0..self.submission).step_by(SUBMISSIONS_A_SET) {
            let slots = (self.submission - first).min(SUBMISSIONS_A_SET) as u64;
            let set = timer.set(self.gpu, first);
            let bytes = read_buffer(self.gpu, &set.resolved, slots * SLOT_BYTES)?;
            ticks.extend(bytemuck::pod_collect_to_vec::<u8, u64>(&bytes));
        }
        let tick_ms = f64::from(self.gpu.queue.get_timestamp_period()) * 1e-6;
        let pair = |place: &Place| {
            let at = place.submission * SLOT_QUERIES as usize + 2 * place.index;
            [ticks[at], ticks[at + 1]]
        };
        let pairs: Vec<_> = self.spans.iter().map(pair).collect();
        let after = timer.latest.get();
        let spans = spans_ms(&pairs, after, tick_ms, wall_ms);
        let valid = pairs.iter().zip(&spans).filter(|(_, ms)| ms.is_some());
        timer
            .latest
            .set(valid.fold(after, |latest, ([_, end], _)| latest.max(*end)));
        Ok(spans)
    }
}

impl Place {
    /// Index of the span's first query in its set.
    fn first_query(self) -> u32 {
        (self.submission % SUBMISSIONS_A_SET) as u32 * SLOT_QUERIES + 2 * self.index as u32
    }
}

impl FlightTimes {
    /// Time of the pass that consists of `spans`.
    pub fn pass(&self, spans: &[Span]) -> PassTime {
        let Some(all) = &self.spans_ms else {
            return PassTime::default();
        };
        let ms: Option<f64> = spans.iter().map(|span| all[span.0]).sum();
        PassTime {
            ms,
            refused: ms.is_none(),
        }
    }
}

/// Durations, ms, of spans that were submitted after the timestamp `after` and ran within `wall_ms`. Timestamps of a
/// span that are 0, reversed, further apart than that or earlier than `after` are invalid: Metal reports such of empty
/// passes, AMD's driver of queries that it did not write. Where all spans together are longer than the wall time,
/// although one queue runs them one after the other, all of them are refused.
fn spans_ms(ticks: &[[u64; 2]], after: u64, tick_ms: f64, wall_ms: f64) -> Vec<Option<f64>> {
    let limit_ms = wall_ms * (1.0 + CLOCK_TOLERANCE);
    let span_ms = |[begin, end]: &[u64; 2]| {
        let ms = end.checked_sub(*begin).filter(|ticks| *ticks > 0)? as f64 * tick_ms;
        (ms <= limit_ms && *begin >= after).then_some(ms)
    };
    let spans: Vec<Option<f64>> = ticks.iter().map(span_ms).collect();
    let sum_ms: f64 = spans.iter().flatten().sum();
    match sum_ms <= limit_ms {
        true => spans,
        false => vec![None; spans.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_of_nothing_reversed_too_long_or_left_over_is_invalid() {
        let ticks = [
            [1000, 3000],
            [5000, 5000],
            [7000, 6000],
            [0, 0],
            [900, u64::MAX],
            [899, 950],
        ];
        let read = spans_ms(&ticks, 900, 1e-3, 10.0);
        assert_eq!(read, [Some(2.0), None, None, None, None, None]);
    }

    #[test]
    fn spans_that_together_exceed_the_wall_are_all_invalid() {
        let ticks = [[0, 6000], [6000, 12_000]];
        assert_eq!(spans_ms(&ticks, 0, 1e-3, 12.0), [Some(6.0), Some(6.0)]);
        assert_eq!(spans_ms(&ticks, 0, 1e-3, 10.0), [None, None]);
    }

    #[test]
    fn a_pass_of_which_one_span_is_invalid_has_no_time() {
        let finished = FlightTimes {
            wall_ms: 10.0,
            spans_ms: Some(vec![Some(1.0), Some(2.5), None]),
        };
        let pass = |spans: &[usize]| {
            let spans: Vec<Span> = spans.iter().map(|i| Span(*i)).collect();
            finished.pass(&spans)
        };
        assert_eq!(
            (pass(&[0, 1]).ms, pass(&[0, 1]).refused),
            (Some(3.5), false)
        );
        assert_eq!((pass(&[0, 2]).ms, pass(&[0, 2]).refused), (None, true));
        let without = FlightTimes {
            wall_ms: 10.0,
            spans_ms: None,
        };
        assert_eq!(without.pass(&[Span(0)]), PassTime::default());
    }
}
