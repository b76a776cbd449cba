//! Clock of a device while it is measured: the time of the probe and, with NVML, the device's own readings.

use super::clock_probe::{ClockProbe, WarmUp};
use super::clocks::{ClockReader, ClockReading};
use super::context::Gpu;
use crate::error::Result;

/// Clock probe and clock reader of one device.
pub struct ClockWatch {
    probe: ClockProbe,
    reader: Option<ClockReader>,
}

impl ClockWatch {
    /// Compiles the probe and looks for the device's management library.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            probe: ClockProbe::new(gpu)?,
            reader: ClockReader::open(&gpu.info.device_pci_bus_id),
        })
    }

    /// Keeps the device busy until the probe's time no longer changes.
    pub fn settle(&self, gpu: &Gpu) -> Result<WarmUp> {
        self.probe.settle(gpu)
    }

    /// The probe's time now, ms.
    pub fn probe_ms(&self, gpu: &Gpu) -> Result<f64> {
        self.probe.read_ms(gpu)
    }

    /// Clocks, power and throttling as the device reports them now; `None` without NVML.
    pub fn reading(&self) -> Option<ClockReading> {
        self.reader.as_ref().map(ClockReader::read)
    }
}
