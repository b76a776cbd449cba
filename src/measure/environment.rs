//! Which machine and build the numbers come from.

use crate::gpu::Gpu;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The machine and the build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Adapter name as the driver gives it.
    pub adapter: String,
    /// Driver and its version.
    pub driver: String,
    /// `Vulkan`, `Metal`, `Dx12`, or [`Environment::ORACLE`].
    pub backend: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `Cpu`…
    pub device_type: String,
    /// Version of this program and the commit it is built from, see [`program`].
    pub commit: String,
    /// Operating system, architecture and logical cores.
    pub host: String,
}

impl Environment {
    /// [`Self::backend`] where no adapter was used: the f64 oracle on the CPU.
    pub const ORACLE: &str = "oracle";

    /// The environment of this build on a device.
    pub fn of_device(gpu: &Gpu) -> Self {
        Self {
            adapter: gpu.info.name.clone(),
            driver: format!("{} {}", gpu.info.driver, gpu.info.driver_info),
            backend: format!("{:?}", gpu.info.backend),
            device_type: format!("{:?}", gpu.info.device_type),
            commit: program(),
            host: host(),
        }
    }

    /// Do the numbers come from the oracle, whose times are wall times of a CPU?
    pub fn is_oracle(&self) -> bool {
        self.backend == Self::ORACLE
    }
}

/// This program with version and commit, for [`Environment::commit`]: `occlab 0.1.0 (0123456789ab)`.
pub fn program() -> String {
    format!("occlab {}", crate::provenance::version())
}

/// This machine, for [`Environment::host`].
pub fn host() -> String {
    format!(
        "{} {}, {} logical cores",
        std::env::consts::OS,
        std::env::consts::ARCH,
        std::thread::available_parallelism().map_or(1, usize::from)
    )
}
