//! Clocks, power and throttling of an NVIDIA device, read through its management library (NVML) where that is found at
//! run time. The library is neither linked nor required: without it there are no readings.

use nvml_wrapper::Nvml;
use nvml_wrapper::enum_wrappers::device::Clock;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ffi::OsStr;

/// Names of the library: the driver alone brings the second, its development package the first.
const LIBRARIES: [&str; 3] = ["libnvidia-ml.so", "libnvidia-ml.so.1", "nvml.dll"];

/// Reads the clocks of one device.
pub struct ClockReader {
    nvml: Nvml,
    bus_id: String,
}

/// One reading; `None` for what the device does not report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClockReading {
    /// Clock of the streaming multiprocessors, MHz.
    pub sm_mhz: Option<f64>,
    /// Clock of the memory, MHz.
    pub memory_mhz: Option<f64>,
    /// Power drawn by the board, W.
    pub power_w: Option<f64>,
    /// Why the clock is not higher, in NVML's words.
    pub throttle_reasons: Vec<String>,
}

/// Clocks and power over the readings of a block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clocks {
    /// Readings, each while a cell's frames were in flight.
    pub readings: usize,
    /// Clock of the streaming multiprocessors, MHz; `null` where the device does not tell, as below.
    pub sm_mhz: Option<Extent>,
    /// Clock of the memory, MHz.
    pub memory_mhz: Option<Extent>,
    /// Power drawn by the board, W.
    pub power_w: Option<Extent>,
    /// Every reason for a lower clock that NVML gave, e.g. `sw_power_cap`; none when empty.
    pub throttle_reasons: BTreeSet<String>,
}

/// Smallest, median and largest of several readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Extent {
    /// Smallest.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub max: f64,
}

impl ClockReader {
    /// A reader for the device on a PCI bus, as wgpu names it; `None` without NVML or where it does not know the device.
    pub fn open(bus_id: &str) -> Option<Self> {
        let open = |library: &&str| Nvml::builder().lib_path(OsStr::new(library)).init().ok();
        let nvml = LIBRARIES.iter().find_map(open)?;
        nvml.device_by_pci_bus_id(bus_id).ok()?;
        Some(Self {
            nvml,
            bus_id: bus_id.to_owned(),
        })
    }

    /// The device's state now; empty when it does not answer any more.
    pub fn read(&self) -> ClockReading {
        let Ok(device) = self.nvml.device_by_pci_bus_id(self.bus_id.as_str()) else {
            return ClockReading::default();
        };
        let clock = |which| device.clock_info(which).ok().map(f64::from);
        let reasons = device.current_throttle_reasons();
        let names = reasons.iter().flat_map(|reasons| reasons.iter_names());
        ClockReading {
            sm_mhz: clock(Clock::SM),
            memory_mhz: clock(Clock::Memory),
            power_w: device.power_usage().ok().map(|mw| f64::from(mw) * 1e-3),
            throttle_reasons: names.map(|(name, _)| name.to_lowercase()).collect(),
        }
    }
}

impl Clocks {
    /// Summary of several readings; `None` where there are none.
    pub fn over(readings: &[ClockReading]) -> Option<Self> {
        let extent = |of: fn(&ClockReading) -> Option<f64>| {
            Extent::over(readings.iter().filter_map(of).collect())
        };
        let reasons = readings.iter().flat_map(|r| &r.throttle_reasons);
        (!readings.is_empty()).then(|| Self {
            readings: readings.len(),
            sm_mhz: extent(|r| r.sm_mhz),
            memory_mhz: extent(|r| r.memory_mhz),
            power_w: extent(|r| r.power_w),
            throttle_reasons: reasons.cloned().collect(),
        })
    }
}

impl Extent {
    /// Extent of the values; `None` where there are none.
    fn over(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        Some(Self {
            min: *values.first()?,
            median: values[values.len() / 2],
            max: *values.last()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_become_extents_and_every_reason_is_kept_once() {
        let reading = |sm_mhz, reason: &str| ClockReading {
            sm_mhz,
            power_w: Some(300.0),
            throttle_reasons: vec![reason.to_owned()],
            ..ClockReading::default()
        };
        let readings = [
            reading(Some(1980.0), "sw_power_cap"),
            reading(Some(345.0), "gpu_idle"),
            reading(None, "sw_power_cap"),
            reading(Some(1965.0), "sw_power_cap"),
        ];
        let clocks = Clocks::over(&readings).expect("readings");
        let sm = clocks.sm_mhz.expect("clock");
        assert_eq!((sm.min, sm.median, sm.max), (345.0, 1965.0, 1980.0));
        assert_eq!((clocks.readings, clocks.memory_mhz), (4, None));
        let reasons: Vec<&str> = clocks.throttle_reasons.iter().map(String::as_str).collect();
        assert_eq!(reasons, ["gpu_idle", "sw_power_cap"]);
        assert_eq!(Clocks::over(&[]), None);
    }

    #[test]
    fn a_machine_without_the_library_or_the_device_has_no_reader() {
        assert!(ClockReader::open("ffff:ff:1f.7").is_none());
    }
}
