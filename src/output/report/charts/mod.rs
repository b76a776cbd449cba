//! The charts of a report.
//!
//! A chart is data ([`chart::Chart`]): title, axes, series or rows. One function draws them all, so sizes, dashes,
//! legends and number formats are decided once, for batch reports, studies, the stability sweep and the probe.
//!
//! To add a chart to batch reports, add a row to [`CHARTS`]. Two numbers of a cell against each other, or a number over
//! a parameter, need no more ([`numbers`] has the numbers); a chart that arranges its data in another way has a file
//! here with a function that returns [`Data`]. A chart without data is not made.

pub mod axis;
pub mod canvas;
mod cells;
pub mod chart;
mod draw;
mod errors;
pub mod ghosting;
mod labels;
mod memory;
mod numbers;
mod plane;
mod plot;
pub mod probe;
mod rows;
mod times;

use super::view::{CellGroup, ReportView};
use crate::error::Result;
use crate::scene::CameraTrack;
use cells::ParamAxis;
use chart::{Chart, Data};
use numbers::{ERROR, MEMORY, Number, TIME};

/// Width of every chart in pixels; text is at least 12 px at this width.
pub const WIDTH: i32 = 700;

/// Kind of chart of batch reports.
struct ChartKind {
    /// Prefix of its files' names.
    stem: &'static str,
    /// Title of the chart.
    title: &'static str,
    /// Source of its data.
    source: Source,
}

/// Source of the data of a chart and of its note on how to read it. A chart without data is not drawn.
enum Source {
    /// For each case: one number against another, a point for each cell, and the frontier of both.
    Cells(&'static Number, &'static Number),
    /// For each case: a number over a parameter, a line for each remaining setting.
    Sweep(ParamAxis, &'static Number),
    /// For each case: a function of the chart's own.
    Case(fn(&ReportView<'_>, &CellGroup<'_>) -> Option<(Data, String)>),
    /// For the whole report: a function of the chart's own.
    Report(fn(&ReportView<'_>) -> Option<(Data, String)>),
}

/// Every chart, in the order of the page.
const CHARTS: &[ChartKind] = &[
    ChartKind {
        stem: "error-time",
        title: "Error against time",
        source: Source::Cells(&TIME, &ERROR),
    },
    ChartKind {
        stem: "error-bytes",
        title: "Error against memory",
        source: Source::Cells(&MEMORY, &ERROR),
    },
    ChartKind {
        stem: "error-steps",
        title: "Error against steps",
        source: Source::Sweep(
            ParamAxis {
                param: "steps",
                axis: "steps of the light or map march (log)",
                note: "Each line: one method at one setting of everything but its steps.",
            },
            &ERROR,
        ),
    },
    ChartKind {
        stem: "error-step-length",
        title: "Error against step length",
        source: Source::Sweep(
            ParamAxis {
                param: "step_m",
                axis: "step of the light march (m, log)",
                note: "Each line: one method at one setting of everything but its step. The truth's own step has no error.",
            },
            &ERROR,
        ),
    },
    ChartKind {
        stem: "time",
        title: "Time of each cell",
        source: Source::Case(times::data),
    },
    ChartKind {
        stem: "three-errors",
        title: "Three errors of each cell",
        source: Source::Case(errors::data),
    },
    ChartKind {
        stem: "ghosting-pan",
        title: "Ghosting on a pan",
        source: Source::Case(|view, case| ghosting::data(view, case, CameraTrack::Pan)),
    },
    ChartKind {
        stem: "ghosting-dolly",
        title: "Ghosting on a dolly",
        source: Source::Case(|view, case| ghosting::data(view, case, CameraTrack::Dolly)),
    },
    ChartKind {
        stem: "memory",
        title: "Memory of the maps",
        source: Source::Report(memory::data),
    },
];

/// Subtitle of charts of the whole report.
const WHOLE: &str = "all scenes and suns";

/// A drawn chart of a report.
pub struct Drawing {
    /// File name inside `charts/`.
    pub file: String,
    /// Title with scene and sun.
    pub title: String,
    /// [`CellGroup::number`] of the case it shows; `None` for a chart of the whole report.
    pub case: Option<usize>,
    /// The picture.
    pub svg: String,
}

/// Prefixes of the file names of all charts.
pub fn kinds() -> impl Iterator<Item = &'static str> {
    CHARTS.iter().map(|kind| kind.stem)
}

/// Every chart that has data, case by case, then those of the whole report.
pub fn all(view: &ReportView<'_>) -> Result<Vec<Drawing>> {
    let cases = view.cases.iter().map(Some).chain([None]);
    let pairs = cases.flat_map(|case| CHARTS.iter().map(move |kind| (case, kind)));
    let drawn = pairs.filter_map(|(case, kind)| kind.draw(view, case).transpose());
    drawn.collect()
}

impl ChartKind {
    /// The chart of one case or, without one, of the whole report; `None` where the kind does not apply or has no data.
    fn draw(&self, view: &ReportView<'_>, case: Option<&CellGroup<'_>>) -> Result<Option<Drawing>> {
        let data = match (&self.source, case) {
            (Source::Cells(x, y), Some(case)) => cells::scatter(view, case, [x, y]),
            (Source::Sweep(over, y), Some(case)) => cells::sweep(view, case, over, y),
            (Source::Case(data), Some(case)) => data(view, case),
            (Source::Report(data), None) => data(view),
            _ => None,
        };
        let Some((data, note)) = data else {
            return Ok(None);
        };
        let (name, of) = case.map_or((WHOLE, WHOLE), |c| (c.name.as_str(), c.short_name.as_str()));
        let chart = Chart {
            title: self.title.to_owned(),
            of: of.to_owned(),
            data,
            source: format!("Measured on {}", view.adapter()),
            note,
        };
        let stem = self.stem;
        Ok(chart.svg()?.map(|svg| Drawing {
            file: case.map_or_else(
                || format!("{stem}.svg"),
                |c| format!("{stem}-{}.svg", c.slug),
            ),
            title: format!("{}: {name}", self.title),
            case: case.map(|case| case.number),
            svg,
        }))
    }
}
