//! What a batch leaves behind: one [`Cell`] for each point of the matrix, one [`Report`] for each folder.

use crate::error::{Error, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// Version of the record format; a reader refuses another.
pub const SCHEMA: &str = "occlab-report-1";

/// `report.json`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// Where the numbers come from.
    pub environment: Environment,
    /// The experiment as it was read, for reruns.
    pub experiment: Value,
    /// One entry a cell of the matrix, in matrix order; failed cells are kept.
    pub cells: Vec<Cell>,
    /// The truths the cells were compared with.
    pub references: Vec<Reference>,
    /// Verdicts on published claims (empty for a plain batch).
    pub claims: Vec<Value>,
    /// Wall-clock account of the whole run.
    pub wall: WallClock,
}

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

/// Where the wall-clock time of a batch went, in seconds, summed over resumed runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallClock {
    /// From start to report.
    pub total_s: f64,
    /// Passes on the device: timed runs, discarded runs, truths, counting and floor renders.
    pub passes_s: f64,
    /// Shader composition and pipeline compilation.
    pub compile_s: f64,
}

/// The 1000-step truth of one scene, sun and image size.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Key that cells name in `reference`.
    pub id: String,
    /// Scene name.
    pub scene: String,
    /// Sun elevation in degrees.
    pub sun_elevation_deg: f64,
    /// Image size.
    pub image: ImageSize,
    /// Device time to render it, ms; `null` when it came from the cache of an adapter without timestamps.
    pub march_ms: Option<f64>,
    /// Density samples taken by its light marches.
    pub light_samples: Option<u64>,
    /// Density samples taken by its view marches.
    pub view_samples: Option<u64>,
    /// True when it was read from the disk cache (times are those of the run that made it).
    pub cached: bool,
    /// Files relative to the report folder: `exr`, `png`.
    pub files: Map<String, Value>,
}

/// Image size in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageSize {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// One cell of the matrix: a scene rendered by a method at one setting.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Stable key: hash of everything that determines the cell.
    pub id: String,
    /// Position in the matrix, from 0.
    pub index: usize,
    /// Scene name.
    pub scene: String,
    /// Scene values that this experiment varies or overrides, by JSON pointer.
    pub scene_set: Map<String, Value>,
    /// Sun elevation in degrees.
    pub sun_elevation_deg: f64,
    /// Method id of the registry.
    pub method: String,
    /// Every parameter of the method, defaults included.
    pub params: Map<String, Value>,
    /// Backend and adapter type that produced the times.
    pub backend: String,
    /// Image size.
    pub image: ImageSize,
    /// Why the cell has no numbers; everything below is then absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// Measurements.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub result: Option<Measured>,
}

/// The numbers of a cell that did not fail.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Key of the truth it was compared with.
    pub reference: String,
    /// Share of pixels whose opacity in the truth exceeds 0.01.
    pub cloud_pixel_fraction: f64,
    /// Share of light look-ups that fell outside the map and were marched; 0 without a map.
    pub fallback_fraction: f64,
    /// Bytes.
    pub memory: Memory,
    /// Milliseconds over the repeats.
    pub time_ms: Times,
    /// Total time of each round, ms, in round order: ratios between methods are taken inside a round.
    pub rounds_total_ms: Vec<f64>,
    /// Density samples, from an untimed counting pipeline.
    pub samples: Samples,
    /// Against the truth.
    pub error: ErrorNumbers,
    /// Files relative to the report folder: `exr`, `png`, `diff_png`.
    pub files: Map<String, Value>,
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

/// Statistics of each pass over the repeats; `null` where the adapter has no timestamps ("n/a", never 0).
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Times {
    /// The map pass; `null` for methods without one.
    pub generate: Option<Stats>,
    /// The view march.
    pub march: Option<Stats>,
    /// Sum of the passes.
    pub total: Option<Stats>,
    /// Submission to completion, seen from the CPU.
    pub wall: Option<Stats>,
}

/// Five numbers of a sample of times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stats {
    /// Median.
    pub median: f64,
    /// Smallest.
    pub min: f64,
    /// 95th percentile (nearest rank).
    pub p95: f64,
    /// Standard deviation / mean.
    pub cv: f64,
    /// Number of samples.
    pub n: usize,
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

/// Error numbers of a picture against its truth; see `metrics` for the definitions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorNumbers {
    /// √Σ(L̂−L)² / √ΣL² over RGB and cloud pixels of the sun-lit radiance.
    pub rel_rmse: f64,
    /// ΣΔL / ΣL.
    pub bias: f64,
    /// Σmax(ΔL, 0) / ΣL: light where there should be shadow.
    pub leak: f64,
    /// Σmin(ΔL, 0) / ΣL: shadow where there should be light (≤ 0).
    pub darken: f64,
    /// 99th percentile of |ΔL| / mean L.
    pub p99_abs: f64,
    /// Largest |ΔL| / mean L.
    pub max_abs: f64,
    /// RMSE of the σT-weighted light transmittance over cloud pixels.
    pub transmittance_rmse: f64,
    /// `rel_rmse` of the uncompressed column at the same steps and texels; `null` for methods without a map.
    pub floor_rel_rmse: Option<f64>,
    /// RMS frame-to-frame change of ΔL / mean L over a camera pan; `null` when the experiment has none.
    pub flicker: Option<f64>,
    /// Mean FLIP (LDR, 67 pixels a degree).
    pub flip_mean: f64,
    /// 99th percentile of FLIP.
    pub flip_p99: f64,
    /// Peak signal-to-noise ratio, dB, tone-mapped, peak 1; `null` when the images are equal.
    pub psnr_db: Option<f64>,
    /// Structural similarity (Wang et al. 2004) of the tone-mapped luma.
    pub ssim: f64,
    /// Channels of the picture that are NaN or infinite.
    pub nonfinite: u64,
}

impl Report {
    /// Reads `report.json` of a folder.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(Error::reading(path))?;
        let report: Self = serde_json::from_str(&text).map_err(|e| {
            Error::input(
                path.display().to_string(),
                e.to_string(),
                "Rebuild the folder with `occlab batch`.",
            )
        })?;
        if report.schema != SCHEMA {
            return Err(Error::input(
                path.display().to_string(),
                format!(
                    "schema is `{}`, this program reads `{SCHEMA}`",
                    report.schema
                ),
                "Run the batch again with this version.",
            ));
        }
        Ok(report)
    }
}
