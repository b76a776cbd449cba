//! Records of a batch: one [`Cell`] for each point of the matrix, one [`Report`] for each folder.

use super::clock::ClockRecord;
use crate::cost::{Memory, Samples};
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::metrics::{ErrorNumbers, Stats};
use crate::reconstruct;
use crate::scene::{CameraTrack, ImageSize, ReconstructionInfo, Track};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
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
    /// Hash of the sources that decided the numbers; empty in reports of earlier versions.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub sources: String,
    /// The experiment as it was read.
    pub experiment: Value,
    /// The scenes of the cells, each once: from them and the experiment's counts `occlab batch` measures a report
    /// again. Empty in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenes: Vec<SceneRecord>,
    /// The files that the scenes read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<InputFile>,
    /// One entry a cell of the matrix, in matrix order; failed cells are kept.
    pub cells: Vec<Cell>,
    /// The truths the cells were compared with.
    pub references: Vec<Reference>,
    /// How steady the adapter was, one entry a block of cells; empty where the oracle rendered.
    #[serde(default)]
    pub clock: Vec<ClockRecord>,
    /// Verdicts on published claims (empty for a plain batch).
    pub claims: Vec<Value>,
    /// Wall-clock account of the whole run.
    pub wall: WallClock,
}

/// A scene as it was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneRecord {
    /// Key that cells name in `scene_id`.
    pub id: String,
    /// The whole scene, with values that the experiment sets and defaults. Paths are relative to the report's folder.
    #[schemars(with = "crate::scene::Scene")]
    pub scene: Value,
}

/// A file that scenes read, as it was when it was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InputFile {
    /// Path as the scenes name it, with the array that they take from an archive: `clouds.npz:density`.
    pub path: String,
    /// Length of the file.
    pub bytes: u64,
    /// BLAKE3 of its content, 64 hexadecimal digits.
    pub blake3: String,
}

/// Where the wall-clock time of a batch went, in seconds, summed over resumed runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallClock {
    /// From start to report.
    pub total_s: f64,
    /// Passes on the device: timed runs, discarded runs, warming up, truths, counting, floor, flicker and ghosting
    /// renders, view-step checks.
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
    /// Time to render it, seen from the CPU, ms: the only one where no adapter was used.
    #[serde(default)]
    pub wall_ms: Option<f64>,
    /// Density samples taken by its light marches.
    pub light_samples: Option<u64>,
    /// Density samples taken by its view marches.
    pub view_samples: Option<u64>,
    /// True when it was read from the disk cache (times are those of the run that made it).
    pub cached: bool,
    /// View steps a ray takes in this scene; `null` when it fixes their length instead.
    #[serde(default)]
    pub view_steps: Option<u32>,
    /// `rel_rmse` of the scene's view steps against steps of a quarter of the length, both shadowed by `srm` with 20
    /// quadratic steps: an error that the truth shares with every cell, so that no cell's error contains it. `null`
    /// where so many steps exceed the limit or nothing of the cloud is lit.
    #[serde(default)]
    pub view_step_rel_rmse: Option<f64>,
    /// Movements that flicker was measured along.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tracks: Vec<TrackRecord>,
    /// Files relative to the report folder: `exr`, `png`.
    pub files: Map<String, Value>,
}

/// A movement that flicker was measured along.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackRecord {
    /// What moves: `pan` gives `error.flicker`, `sun` gives `error.flicker_sun`,
    /// `dolly` gives `error.flicker_dolly`.
    pub track: Track,
    /// Frames, the view's own included.
    pub frames: u32,
    /// Turn of the camera (one pixel of the picture's centre) or change of the sun's elevation a frame, degrees; absent
    /// on a dolly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_deg: Option<f64>,
    /// Way of the camera a frame, one texel of the map of 256² texels in the `square` fit, metres; absent where it stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_m: Option<f64>,
}

/// One cell of the matrix: a scene rendered by a method at one setting.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Stable key: hash of everything that decides the cell's numbers, contents of files and sources of the program
    /// included.
    pub id: String,
    /// Position in the matrix, from 0.
    pub index: usize,
    /// Scene name.
    pub scene: String,
    /// Key of its scene in `scenes`; empty in reports of earlier versions.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub scene_id: String,
    /// Scene values that this experiment varies or overrides, by JSON pointer.
    pub scene_set: Map<String, Value>,
    /// Sun elevation in degrees.
    pub sun_elevation_deg: f64,
    /// Method id of the registry.
    pub method: String,
    /// Every parameter of the method that applies at this setting, defaults included.
    pub params: Map<String, Value>,
    /// Reconstruction of its pictures; absent = `full`, every pixel marched. The picture is that of a camera at rest,
    /// after as many frames as it takes until it changes no more; times and samples are those of one frame.
    #[serde(
        default = "reconstruct::full",
        deserialize_with = "reconstruct::deserialize",
        skip_serializing_if = "ReconstructionInfo::is_full"
    )]
    #[schemars(schema_with = "reconstruct::schema")]
    pub reconstruct: &'static ReconstructionInfo,
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
    /// Memory, bytes.
    pub memory: Memory,
    /// Index of the first cell of the block that this one was timed in: cells of one view and block share their rounds.
    pub block: usize,
    /// Statistics of each pass over the rounds, ms.
    pub time_ms: Times,
    /// Frames in flight, submitted without waiting between them: the fewest of any round. A round's time is their
    /// median.
    #[serde(default = "one")]
    pub frames_in_flight: u32,
    /// Total time of each round, ms, in round order: ratios between methods are taken inside a round. `null` for a
    /// round whose timestamps are invalid; empty without timestamps.
    pub rounds_total_ms: Vec<Option<f64>>,
    /// Time of the map pass in each round, ms, in the same order. Empty without a map.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rounds_generate_ms: Vec<Option<f64>>,
    /// Density samples, from an untimed counting pipeline.
    pub samples: Samples,
    /// Light look-ups in a map, from the same pipeline; 0 without a map.
    #[serde(default)]
    pub look_ups: u64,
    /// Error numbers against the truth.
    pub error: ErrorNumbers,
    /// The error's three parts, where the experiment asks for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decomposition: Option<Decomposition>,
    /// Error and memory of the reconstruction; absent for `full`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reconstruction: Option<ReconstructionNumbers>,
    /// Notes on numbers that were asked for and could not be measured; such a number is `null` and is not tried again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Files relative to the report folder: `exr`, `png`, `diff_png`; with a decomposition `model_png`, `sampling_png`,
    /// `precision_png`, all differences at the scale `diff_scale`.
    pub files: Map<String, Value>,
}

/// Reports of earlier versions had one frame in flight.
fn one() -> u32 {
    1
}

/// The parts of a cell's error, each the RMS of a signed image over the truth's own RMS, ≥ 0. The images add up to the
/// cell's difference from the truth, but for the truths' own difference; these numbers do not add.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Decomposition {
    /// The method in f64 with ample steps and texels, minus the f64 truth.
    pub model_rel_rmse: f64,
    /// The method in f64 at the cell's steps and texels, minus the same with ample ones.
    pub sampling_rel_rmse: f64,
    /// The cell's picture minus the f64 one at the same settings: stored values, f32 arithmetic, and what is left of
    /// the device's filtering of noise.
    pub precision_rel_rmse: f64,
    /// Part of the precision error: rounding of stored map values alone, to nearest, all else in f64.
    pub storage_rel_rmse: f64,
    /// The f64 truth minus the truth that the cell was compared with.
    pub truth_rel_rmse: f64,
    /// Steps that count as ample; `null` for a method without.
    pub ample_steps: Option<u32>,
    /// Texels along an edge that count as ample; `null` without a map.
    pub ample_resolution: Option<u32>,
    /// How the f64 pictures filter noise textures: `exact`, or `8 bit` as some devices do, whichever truth is nearer;
    /// `null` without noise.
    pub noise_filter: Option<String>,
}

/// Error and memory of a reconstruction. Its errors are relative RMSE of the sun-lit radiance against the full render
/// of the same frame by the same method, over pixels where either shows cloud ([`crate::metrics::ghosting`]).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReconstructionNumbers {
    /// Error of a camera at rest, once the picture changes no more.
    pub full_rel_rmse: f64,
    /// Error of a moving camera, along each movement that the experiment asks for; only for reconstructions with a
    /// history.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ghosting: BTreeMap<CameraTrack, Ghosting>,
    /// Memory of the history, bytes.
    pub history_bytes: u64,
}

/// Error of a reconstruction along one movement of the camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ghosting {
    /// Turn of the camera from one frame to the next, degrees; absent where it does not turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_deg: Option<f64>,
    /// Distance the camera moves from one frame to the next, metres; absent where it stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_m: Option<f64>,
    /// Error of each frame; the first is the one at rest.
    pub rel_rmse: Vec<f64>,
}

/// Statistics of each pass over the rounds, ms; a round's value is the median of its frames, and single frames scatter
/// more; `null` where the adapter has no timestamps ("n/a", never 0).
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Times {
    /// The map pass; `null` for methods without one.
    pub generate: Option<Stats>,
    /// The view march.
    pub march: Option<Stats>,
    /// The reconstruction pass, which fills the pixels that were not marched; absent where every pixel is marched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reconstruct: Option<Stats>,
    /// All passes of a frame together.
    pub total: Option<Stats>,
    /// From submission to completion of all frames of a round, seen from the CPU, divided by their number.
    pub wall: Option<Stats>,
}

/// Which time of a cell stands for its cost in a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Time of the passes on the device.
    Device,
    /// From submission to completion, seen from the CPU.
    Wall,
}

impl Clock {
    /// The cost of a cell, ms; `None` where this clock has no time of it.
    pub fn cost(self, times: &Times) -> Option<Stats> {
        match self {
            Self::Device => times.total,
            Self::Wall => times.wall,
        }
    }

    /// `total` or `wall`, as in [`Times`].
    pub fn name(self) -> &'static str {
        match self {
            Self::Device => "total",
            Self::Wall => "wall",
        }
    }
}

impl Report {
    /// The device's clock where any cell has its time, else the wall clock, which also counts recording and submission;
    /// the two are never mixed.
    pub fn clock(&self) -> Clock {
        let timed = |cell: &Cell| {
            let result = cell.result.as_ref();
            result.is_some_and(|result| result.time_ms.total.is_some())
        };
        if self.cells.iter().any(timed) {
            Clock::Device
        } else {
            Clock::Wall
        }
    }

    /// Least and largest drift of the clock probe over all blocks, see [`ClockRecord::drift`]; `None` where nothing was
    /// watched.
    pub fn clock_drift(&self) -> Option<[f64; 2]> {
        let drifts = self.clock.iter().filter_map(ClockRecord::drift);
        drifts.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// Reads `report.json` of a folder.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(Error::reading(path))?;
        Self::parse(path, &text)
    }

    /// [`Self::read`] from the text of the file; `path` is for messages.
    pub(super) fn parse(path: &Path, text: &str) -> Result<Self> {
        let report: Self = serde_json::from_str(text).map_err(|e| {
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
