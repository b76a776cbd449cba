//! The charts of a report, as SVG text. A chart without data is not made.

mod axis;
mod bars;
pub mod canvas;
pub mod curves;
mod errors;
pub mod extremes;
pub mod ghosting;
mod labels;
mod memory;
mod plot;
pub mod probe;
mod scatter;
mod steps;

use super::view::View;
use crate::error::Result;
use crate::scene::CameraTrack;

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
                steps::COUNT.title,
                steps::draw(view, case, &steps::COUNT)?,
            ),
            (
                "error-step-length",
                steps::LENGTH.title,
                steps::draw(view, case, &steps::LENGTH)?,
            ),
            ("time", "Time of each cell", bars::draw(view, case)?),
            (
                "three-errors",
                "Three errors of each cell",
                errors::draw(view, case)?,
            ),
            (
                "ghosting-pan",
                ghosting::title_of(CameraTrack::Pan),
                ghosting::draw(view, case, CameraTrack::Pan)?,
            ),
            (
                "ghosting-dolly",
                ghosting::title_of(CameraTrack::Dolly),
                ghosting::draw(view, case, CameraTrack::Dolly)?,
            ),
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
