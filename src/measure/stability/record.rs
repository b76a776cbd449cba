//! Records of a sweep: one [`SweepCase`] for each extreme, one [`Sweep`] for each folder.

use super::thresholds::Threshold;
use crate::environment::Environment;
use serde::{Deserialize, Serialize};

/// Version of the record format; records of another are made again.
pub const SCHEMA: &str = "occlab-stability-1";

/// Verdict on a method at an extreme; the order is by severity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FormVerdict {
    /// Finite, T in `[0, 1]`, T never rises with depth.
    Ok,
    /// T rises with depth, as the method documents of itself: FOM inside its overshoot, SRM's few samples.
    Rings,
    /// The scene or the setting was not accepted; the reason is recorded.
    Refused,
    /// The device returned an error, whose message is recorded.
    Failed,
    /// Not finite, outside `[0, 1]`, or rising where the method documents no rise.
    Breaks,
}

/// `stability.json`: all data of the page.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// Name of the stability file.
    pub name: String,
    /// `quick` or `full`.
    pub profile: String,
    /// The device; `None` where there was none and only the oracle ran.
    pub environment: Option<Environment>,
    /// Seconds that the sweep took, those of resumed runs together.
    pub wall_s: f64,
    /// Where the published forms begin to fail.
    pub thresholds: Vec<Threshold>,
    /// Cases in file order.
    pub cases: Vec<SweepCase>,
}

impl Sweep {
    /// Rows whose form must hold and does not.
    pub fn defects(&self) -> Vec<(&SweepCase, &SweepRow)> {
        let rows = |case| {
            let case: &SweepCase = case;
            case.rows.iter().map(move |row| (case, row))
        };
        let all = self.cases.iter().flat_map(rows);
        all.filter(|(_, row)| row.is_defect()).collect()
    }

    /// Rows of a form with this verdict on the oracle.
    pub fn count(&self, form: &str, verdict: FormVerdict) -> usize {
        let rows = self.cases.iter().flat_map(|case| &case.rows);
        rows.filter(|row| row.setting.form == form && row.oracle().verdict == verdict)
            .count()
    }
}

/// One extreme.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepCase {
    /// Hash of everything that determines it.
    pub id: String,
    /// The quantity that is taken to an extreme, with its unit.
    pub group: String,
    /// Value of that quantity.
    pub name: String,
    /// Why the scene was refused; there are no rows then.
    pub refused: Option<String>,
    /// Seconds it took.
    pub wall_s: f64,
    /// Depths at which [`SweepRow::curve`] is given, as shares of the first column.
    pub depths: Vec<f64>,
    /// T of the f64 truth there.
    pub truth: Vec<f64>,
    /// One for each method setting that takes part.
    pub rows: Vec<SweepRow>,
}

/// A method, its form, storage and look-up; `-` where it has no such choice.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Method id.
    pub method: String,
    /// `stable`, `published` or `-`.
    pub form: String,
    /// `f16`, `f32` or `-`.
    pub storage: String,
    /// `nearest`, `hardware`, `blend` or `-`.
    pub lookup: String,
}

impl Setting {
    /// Whether a failure is a defect: only a form kept to show where it fails may fail.
    pub fn must_hold(&self) -> bool {
        self.form != "published"
    }
}

/// A method setting at an extreme.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepRow {
    /// Method, form, storage and look-up.
    pub setting: Setting,
    /// Light columns on the oracle, rounding as the setting stores, denormals kept: asserted.
    pub kept: Columns,
    /// The same with denormals flushed to zero: asserted.
    pub flushed: Columns,
    /// A picture on the device: recorded.
    pub device: Option<SweepPicture>,
    /// T at [`SweepCase::depths`] of the first column, denormals flushed; `null` where it is not finite.
    pub curve: Vec<Option<f32>>,
}

impl SweepRow {
    /// The worse of [`Self::kept`] and [`Self::flushed`].
    pub fn oracle(&self) -> &Columns {
        if self.flushed.verdict >= self.kept.verdict {
            &self.flushed
        } else {
            &self.kept
        }
    }

    /// Whether a form that must hold does not, on the oracle or on the device.
    pub fn is_defect(&self) -> bool {
        let device = self.device.as_ref().map(|picture| picture.verdict);
        let broken =
            self.oracle().verdict == FormVerdict::Breaks || device == Some(FormVerdict::Breaks);
        self.setting.must_hold() && broken
    }
}

/// Numbers of a method along the light columns of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Columns {
    /// See [`FormVerdict`].
    pub verdict: FormVerdict,
    /// What was wrong, or why it was refused.
    pub reason: Option<String>,
    /// Values of T that are NaN or infinite.
    pub nonfinite: u64,
    /// Stored map values that are NaN or infinite.
    pub nonfinite_stored: u64,
    /// Smallest and largest finite T.
    pub range: Option<[f64; 2]>,
    /// How often T rises from one depth to the next by more than rounding.
    pub rises: u64,
    /// Largest rise of T from any depth to any deeper one.
    pub largest_rise: f64,
    /// Largest |T − truth| over finite T.
    pub max_error: Option<f64>,
    /// √(Σ σT (ΔT)²/Σ σT) over finite T, T and σ of the truth; `None` in a column without medium.
    pub weighted_rmse: Option<f64>,
}

/// Numbers of a picture on the device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepPicture {
    /// See [`FormVerdict`]; a picture has no depths, so it never rings.
    pub verdict: FormVerdict,
    /// What was wrong, or the device's message.
    pub reason: Option<String>,
    /// Channels of the picture whose exponent bits are all ones.
    pub nonfinite: u64,
    /// Values of the map whose exponent bits are all ones.
    pub nonfinite_stored: u64,
    /// Smallest and largest finite mean V of a pixel that sees medium.
    pub range: Option<[f64; 2]>,
    /// Largest |V − truth| of a pixel, over finite V; the truth is the oracle's.
    pub max_error: Option<f64>,
}
