//! Numbers of a cell that charts have axes for: time, memory, error.

use super::super::view::{ReportView, Shot};
use super::axis::{AxisSpec, Scale};

/// Minimum and 95th percentile over the repeats, for numbers that were measured repeatedly.
pub type Range = Option<[f64; 2]>;

/// A number that every cell may have.
pub struct Number {
    /// Axis that shows the number.
    pub axis: fn(&ReportView<'_>) -> AxisSpec,
    /// The number and its range.
    pub of: fn(&Shot<'_>) -> Option<(f64, Range)>,
    /// A sentence on how to read it in a scatter chart; may be empty.
    pub note: fn(&ReportView<'_>) -> String,
    /// Noun for what a cell lacks that has no such number.
    pub without: &'static str,
}

/// Time of one picture by the report's clock, ms.
pub const TIME: Number = Number {
    axis: |view| {
        let clock = view.clock().name();
        let title = format!("{clock} time of {} (ms, median, log)", view.timed());
        AxisSpec::new(title, Scale::Log)
    },
    of: |shot| {
        let time = shot.time()?;
        Some((
            time.median,
            (time.min > 0.0).then_some([time.min, time.p95]),
        ))
    },
    note: |view| match view.frames() {
        "" => "Points: medians. Horizontal bars: smallest to 95th percentile.".to_owned(),
        frames => format!("Medians. Bars: min to p95.{frames}"),
    },
    without: "timestamps",
};

/// Memory of the map and of the history, bytes.
pub const MEMORY: Number = Number {
    axis: |view| {
        let (title, zero) = match view.reconstructed() {
            true => (
                "textures of the map as allocated and history (bytes, log)",
                "0 (neither)",
            ),
            false => (
                "textures of the map as allocated (bytes, log)",
                "0 (no map)",
            ),
        };
        AxisSpec {
            zero,
            ..AxisSpec::new(title, Scale::Bytes)
        }
    },
    of: |shot| Some((shot.memory_bytes() as f64, None)),
    note: |view| {
        let what = match view.reconstructed() {
            true => "Full pictures",
            false => "Methods",
        };
        format!(
            "{what} without a map stand at 0. Circled: no other cell has both less memory and less error."
        )
    },
    without: "a map",
};

/// Relative RMSE against the truth.
pub const ERROR: Number = Number {
    axis: |_| AxisSpec::new("relative RMSE against the truth (log)", Scale::Log),
    of: |shot| Some((shot.rel_rmse(), None)),
    note: |_| String::new(),
    without: "an error",
};
