//! Clock probe: a fixed amount of arithmetic whose GPU time tells the device's present clock
//! (`shaders/clock_probe.wgsl`).

use super::context::Gpu;
use super::kernel::{Inputs, Kernel, Resource};
use super::shader::Program;
use super::timing::Flight;
use super::uniform::UniformValue;
use crate::error::Result;
use std::time::Instant;

/// Threads of a row of the probe; rows are added until it takes [`PROBE_MS`].
const ROW_THREADS: u32 = 1 << 17;
const MOST_ROWS: u32 = 1 << 15;
/// Least duration of a probe, ms: long beside what a dispatch costs to start, short beside a round.
const PROBE_MS: f64 = 2.0;
/// Work kept in flight, ms: with less of it queued a device may lower its clock.
const IN_FLIGHT_MS: f64 = 200.0;
/// Work kept in flight on a software adapter, ms: its clock does not depend on the queue, so that this only has to be
/// enough to time several short frames together.
const SOFTWARE_IN_FLIGHT_MS: f64 = 50.0;
/// Probes in flight for one reading between rounds.
const READING_PROBES: u32 = 8;
/// Number of consecutive flights whose medians must agree.
const SETTLED_FLIGHTS: usize = 4;
/// Relative difference of medians that always counts as settled, even where repeats within a flight agree better; also
/// the largest difference allowed on an adapter whose repeats agree no better.
const SETTLED_WITHIN: f64 = 0.02;
const NOISE_WITHIN: f64 = 0.1;
/// Longest wait for the clock, s: a laptop that cools its GPU for minutes must not hold a batch.
const MOST_WARM_UP_S: f64 = 3.0;

/// The probe of one device.
pub struct ClockProbe {
    kernel: Kernel,
    groups: Vec<wgpu::BindGroup>,
    rows: u32,
}

/// Result of warming up a device until its clock settles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarmUp {
    /// Time of the probe at the end of the wait, measured as between rounds, ms.
    pub probe_ms: f64,
    /// Size of the probe, rows of 131 072 threads.
    pub rows: u32,
    /// Medians of the last flights agreed; `false`: the wait ended at its time limit.
    pub settled: bool,
    /// Length of the wait, s.
    pub seconds: f64,
}

impl ClockProbe {
    /// Compiles the probe and chooses its size for this device.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let kernel = Kernel::new(
            gpu,
            &Program {
                entry: "clock_probe.wgsl",
                roles: Vec::new(),
                defs: Default::default(),
            },
        )?;
        let mut inputs = Inputs::default();
        let work = [("a", 0.75), ("b", 0.5)].map(|(name, v)| (name, UniformValue::F32(v)));
        inputs.uniform("work", work);
        let never = gpu.empty_buffer("clock probe", 16, wgpu::BufferUsages::STORAGE);
        inputs.resource("never", Resource::Buffer(never));
        let groups = kernel.bind(gpu, &[&inputs])?;
        let mut probe = Self {
            kernel,
            groups,
            rows: 1,
        };
        // The first run includes work that the driver defers until then. A size chosen on an idle device, whose clock
        // is low, is too small once the clock has risen: the size is chosen in flights of full length.
        probe.fly(gpu, 1)?;
        while probe.rows < MOST_ROWS && median(&probe.fly(gpu, READING_PROBES)?) < PROBE_MS {
            probe.rows *= 2;
        }
        loop {
            let rough_ms = median(&probe.fly(gpu, READING_PROBES)?);
            let probe_ms = median(&probe.fly(gpu, full_flight(gpu, rough_ms))?);
            if probe_ms >= PROBE_MS || probe.rows >= MOST_ROWS {
                break;
            }
            probe.rows *= 2;
        }
        Ok(probe)
    }

    /// Times of `count` probes in flight together, ms; without timestamps, or where one is invalid, the wall time shared
    /// equally.
    fn fly(&self, gpu: &Gpu, count: u32) -> Result<Vec<f64>> {
        let mut flight = Flight::new(gpu);
        let mut spans = Vec::new();
        for _ in 0..count {
            let threads = [ROW_THREADS, self.rows, 1];
            spans.push(flight.dispatch(&self.kernel, &self.groups, threads, None));
            flight.submit();
        }
        let finished = flight.finish(|| ())?;
        let share_ms = finished.wall_ms / f64::from(count);
        let times = spans.iter().map(|span| finished.pass(&[*span]).ms);
        Ok(times
            .collect::<Option<_>>()
            .unwrap_or_else(|| vec![share_ms; spans.len()]))
    }

    /// Keeps the device busy until the probe's time no longer changes.
    pub fn settle(&self, gpu: &Gpu) -> Result<WarmUp> {
        let start = Instant::now();
        let mut flights = Vec::new();
        let mut probe_ms = PROBE_MS;
        loop {
            let times = self.fly(gpu, full_flight(gpu, probe_ms))?;
            probe_ms = median(&times);
            flights.push(times);
            let seconds = start.elapsed().as_secs_f64();
            let settled = is_settled(&flights);
            if settled || seconds > MOST_WARM_UP_S {
                return Ok(WarmUp {
                    probe_ms: self.read_ms(gpu)?,
                    rows: self.rows,
                    settled,
                    seconds,
                });
            }
        }
    }

    /// The probe's time now: median of a few, ms.
    pub fn read_ms(&self, gpu: &Gpu) -> Result<f64> {
        self.fly(gpu, READING_PROBES).map(|times| median(&times))
    }
}

/// Work that is submitted to a device before waiting for it, ms.
pub fn in_flight_ms(gpu: &Gpu) -> f64 {
    match gpu.is_software() {
        true => SOFTWARE_IN_FLIGHT_MS,
        false => IN_FLIGHT_MS,
    }
}

/// Number of probes of `probe_ms` each that fill [`in_flight_ms`], 1…1000.
fn full_flight(gpu: &Gpu, probe_ms: f64) -> u32 {
    (in_flight_ms(gpu) / probe_ms).ceil().clamp(1.0, 1000.0) as u32
}

/// Do the medians of the last flights agree, as far as repeats within a flight do?
fn is_settled(flights: &[Vec<f64>]) -> bool {
    let Some(last) = flights.len().checked_sub(SETTLED_FLIGHTS) else {
        return false;
    };
    let last = &flights[last..];
    let medians: Vec<f64> = last.iter().map(|times| median(times)).collect();
    let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let spreads: Vec<f64> = last.iter().map(|times| middle_half(times)).collect();
    let allowed = (least(&spreads) / least(&medians)).clamp(SETTLED_WITHIN, NOISE_WITHIN);
    most(&medians) - least(&medians) <= allowed * least(&medians)
}

/// Interquartile range of a sample.
fn middle_half(times: &[f64]) -> f64 {
    let sorted = sorted(times);
    sorted[sorted.len() * 3 / 4] - sorted[sorted.len() / 4]
}

/// Median of a flight's times; a flight has at least one.
fn median(times: &[f64]) -> f64 {
    sorted(times)[times.len() / 2]
}

fn sorted(times: &[f64]) -> Vec<f64> {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Flights whose repeats alternate by ± 1 ‰ around a median.
    fn flights(medians: &[f64]) -> Vec<Vec<f64>> {
        let flight = |m: &f64| vec![m * 0.999, *m, m * 1.001];
        medians.iter().map(flight).collect()
    }

    #[test]
    fn a_clock_that_still_rises_has_not_settled() {
        assert!(!is_settled(&flights(&[5.0])));
        assert!(!is_settled(&flights(&[5.0, 5.0])));
        assert!(!is_settled(&flights(&[9.0, 7.0, 6.0, 5.5])));
        assert!(
            !is_settled(&flights(&[5.1, 5.05, 5.0, 4.95])),
            "1 % a flight"
        );
        assert!(is_settled(&flights(&[9.0, 5.03, 5.0, 5.01, 5.02])));
    }

    #[test]
    fn a_noisy_adapter_settles_within_its_own_noise() {
        let noisy = |m: f64| vec![m * 0.9, m * 0.95, m, m * 1.05, m * 1.1];
        let steady: Vec<_> = [5.0, 5.2, 5.1, 5.0].map(noisy).into();
        assert!(is_settled(&steady));
        let falling: Vec<_> = [9.0, 8.0, 7.0, 6.0].map(noisy).into();
        assert!(!is_settled(&falling));
        let toggling = |m: f64| vec![m * 0.7, m * 0.7, m, m * 1.3, m * 1.3];
        let unsteady: Vec<_> = [5.0, 6.0, 5.0, 6.0].map(toggling).into();
        assert!(!is_settled(&unsteady));
    }
}
