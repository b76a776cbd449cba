//! The charts of a report, as SVG text. A chart without data is not made.

mod axis;
mod bars;
mod canvas;
mod labels;
mod memory;
mod plot;
mod scatter;
mod steps;

use super::files;
use super::view::View;
use crate::error::{Error, Result};
use std::path::Path;

/// Width of every chart in pixels; text is at least 12 px at this width.
pub const WIDTH: i32 = 700;

/// One chart.
pub struct Chart {
    /// File name inside `charts/`.
    pub file: String,
    /// What it shows, of which scene and sun.
    pub title: String,
    /// [`Case::number`] of the case it shows; `None` for a chart of the whole report.
    pub case: Option<usize>,
    /// The picture.
    pub svg: String,
}

/// First words of the file names, which mark the files in `charts/` that belong to the report.
const KINDS: [&str; 5] = ["error-time", "error-bytes", "error-steps", "time", "memory"];

/// Every chart that has data, case by case.
pub fn all(view: &View<'_>) -> Result<Vec<Chart>> {
    let mut out = Vec::new();
    for case in &view.cases {
        let drawn = [
            (
                "error-time",
                "Error against time",
                scatter::error_time(view, case)?,
            ),
            (
                "error-bytes",
                "Error against memory",
                scatter::error_bytes(view, case)?,
            ),
            (
                "error-steps",
                "Error against steps",
                steps::draw(view, case)?,
            ),
            ("time", "Time of each cell", bars::draw(view, case)?),
        ];
        for (kind, what, svg) in drawn {
            out.extend(svg.map(|svg| Chart {
                file: format!("{kind}-{}.svg", case.slug),
                title: format!("{what}: {}", case.name),
                case: Some(case.number),
                svg,
            }));
        }
    }
    out.extend(memory::draw(view)?.map(|svg| Chart {
        file: "memory.svg".to_owned(),
        title: memory::TITLE.to_owned(),
        case: None,
        svg,
    }));
    Ok(out)
}

/// Writes the charts and removes those of an earlier report.
pub fn write(folder: &Path, charts: &[Chart]) -> Result<()> {
    if let Ok(entries) = std::fs::read_dir(folder) {
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let ours = name.ends_with(".svg") && KINDS.iter().any(|k| name.starts_with(k));
            if ours && !charts.iter().any(|c| c.file == name) {
                std::fs::remove_file(entry.path()).map_err(Error::writing(&entry.path()))?;
            }
        }
    }
    charts
        .iter()
        .try_for_each(|chart| files::write(&folder.join(&chart.file), chart.svg.as_bytes()))
}
