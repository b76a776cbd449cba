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

use super::view::{Case, View};
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

/// Draws a chart of one case; `None` when it has no data for it.
type Draw = fn(&View<'_>, &Case<'_>) -> Result<Option<String>>;

/// The charts of a case: how their files' names begin, their titles, and who draws them.
const OF_CASES: [(&str, &str, Draw); 8] = [
    ("error-time", "Error against time", scatter::error_time),
    ("error-bytes", "Error against memory", scatter::error_bytes),
    ("error-steps", steps::COUNT.title, |view, case| {
        steps::draw(view, case, &steps::COUNT)
    }),
    ("error-step-length", steps::LENGTH.title, |view, case| {
        steps::draw(view, case, &steps::LENGTH)
    }),
    ("time", "Time of each cell", bars::draw),
    ("three-errors", "Three errors of each cell", errors::draw),
    (
        "ghosting-pan",
        ghosting::title_of(CameraTrack::Pan),
        |view, case| ghosting::draw(view, case, CameraTrack::Pan),
    ),
    (
        "ghosting-dolly",
        ghosting::title_of(CameraTrack::Dolly),
        |view, case| ghosting::draw(view, case, CameraTrack::Dolly),
    ),
];

/// How the name of the chart of the whole report begins.
const MEMORY: &str = "memory";

/// How the names of all charts begin.
pub fn kinds() -> impl Iterator<Item = &'static str> {
    OF_CASES.iter().map(|(kind, ..)| *kind).chain([MEMORY])
}

/// Every chart that has data, case by case.
pub fn all(view: &View<'_>) -> Result<Vec<Chart>> {
    let mut out = Vec::new();
    for case in &view.cases {
        for (kind, what, draw) in OF_CASES {
            out.extend(draw(view, case)?.map(|svg| Chart {
                file: format!("{kind}-{}.svg", case.slug),
                title: format!("{what}: {}", case.name),
                case: Some(case.number),
                svg,
            }));
        }
    }
    out.extend(memory::draw(view)?.map(|svg| Chart {
        file: format!("{MEMORY}.svg"),
        title: memory::TITLE.to_owned(),
        case: None,
        svg,
    }));
    Ok(out)
}
