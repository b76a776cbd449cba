//! Clock record of a block of cells: how steady the adapter was while they were timed.

use crate::backend::Backend;
use crate::error::Result;
use crate::gpu::{ClockReading, ClockWatch, Clocks, Gpu, in_flight_ms};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Clock record of a block: times of a probe, a fixed piece of arithmetic (`shaders/clock_probe.wgsl`), around the
/// timed rounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClockRecord {
    /// Key of the truth, which stands for scene, sun and image size.
    pub reference: String,
    /// Index of the block's first cell, as in the cells of the block.
    pub block: usize,
    /// Whether the probe's time had stopped changing before the first timed round; false where the wait was given up
    /// after some seconds.
    pub settled: bool,
    /// How long the device was kept busy before the first timed round, s.
    pub warm_up_s: f64,
    /// Probe time at the end of this warm-up, ms.
    pub settled_ms: f64,
    /// Work of the probe, rows of 131072 threads: chosen for the device, so that its time is some milliseconds.
    pub probe_rows: u32,
    /// Probe time before each timed round and after the last, ms.
    pub rounds_ms: Vec<f64>,
    /// Clocks, power and throttling that an NVIDIA device reported while frames were in flight; absent elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clocks: Option<Clocks>,
}

impl ClockRecord {
    /// Least and largest change of the probe's time over the rounds, relative to the time at which it had settled:
    /// +0.05 means that the device had become slower by 5 %.
    pub fn drift(&self) -> Option<[f64; 2]> {
        let changes = self.rounds_ms.iter().map(|ms| ms / self.settled_ms - 1.0);
        changes.fold(None, |range, change| match range {
            None => Some([change, change]),
            Some([least, most]) => Some([change.min(least), change.max(most)]),
        })
    }
}

/// Watches the adapter through the rounds of a block.
pub(super) struct Watch<'a> {
    device: Option<(&'a Gpu, &'a ClockWatch)>,
    record: Option<ClockRecord>,
    readings: Vec<ClockReading>,
    /// Seconds that watching took.
    pub seconds: f64,
}

impl<'a> Watch<'a> {
    /// Nothing is watched on the oracle.
    pub fn new(backend: &'a Backend) -> Result<Self> {
        Ok(Self {
            device: backend.watched()?,
            record: None,
            readings: Vec::new(),
            seconds: 0.0,
        })
    }

    /// Whether the device has a clock that drops when idle. A software adapter runs on the CPU, which is never idle
    /// here.
    pub fn has_clock(&self) -> bool {
        self.device.is_some_and(|(gpu, _)| !gpu.is_software())
    }

    /// Work that a cell submits in a round, ms; 0 on the oracle, which renders one picture at a time.
    pub fn in_flight_ms(&self) -> f64 {
        self.device.map_or(0.0, |(gpu, _)| in_flight_ms(gpu))
    }

    /// Keeps the device busy until its clock has settled.
    pub fn settle(&mut self, reference: &str, block: usize) -> Result<()> {
        let Some((gpu, watch)) = self.device else {
            return Ok(());
        };
        let warm_up = watch.settle(gpu)?;
        self.seconds += warm_up.seconds;
        self.record = Some(ClockRecord {
            reference: reference.to_owned(),
            block,
            settled: warm_up.settled,
            warm_up_s: warm_up.seconds,
            settled_ms: warm_up.probe_ms,
            probe_rows: warm_up.rows,
            rounds_ms: Vec::new(),
            clocks: None,
        });
        Ok(())
    }

    /// Times the probe between two rounds.
    pub fn between_rounds(&mut self) -> Result<()> {
        if let (Some((gpu, watch)), Some(record)) = (self.device, &mut self.record) {
            let start = std::time::Instant::now();
            record.rounds_ms.push(watch.probe_ms(gpu)?);
            self.seconds += start.elapsed().as_secs_f64();
        }
        Ok(())
    }

    /// Reads the clocks of the device while it is busy.
    pub fn read(&mut self) {
        let reading = self.device.and_then(|(_, watch)| watch.reading());
        self.readings.extend(reading);
    }

    /// The record of the block, if anything was watched.
    pub fn finish(self) -> Option<ClockRecord> {
        let clocks = Clocks::over(&self.readings);
        self.record.map(|record| ClockRecord { clocks, ..record })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drift_is_relative_to_the_settled_probe() {
        let mut record = ClockRecord {
            reference: String::new(),
            block: 0,
            settled: true,
            warm_up_s: 0.6,
            settled_ms: 4.0,
            probe_rows: 1,
            rounds_ms: vec![4.0, 4.2, 3.9],
            clocks: None,
        };
        let [least, most] = record.drift().expect("rounds");
        assert!((least + 0.025).abs() < 1e-12 && (most - 0.05).abs() < 1e-12);
        record.rounds_ms.clear();
        assert_eq!(record.drift(), None);
    }
}
