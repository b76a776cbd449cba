//! Which machine and build the numbers come from.

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
    /// `Vulkan`, `Metal`, `Dx12`.
    pub backend: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `Cpu`…
    pub device_type: String,
    /// Version of this program.
    pub commit: String,
    /// Operating system, architecture and logical cores.
    pub host: String,
}
