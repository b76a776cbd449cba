//! Chart of the time of each cell, split into map, march and reconstruction passes where the device timed them.

use super::super::format::ms;
use super::super::style::Style;
use super::super::view::{CellGroup, ReportView, Shot};
use super::axis::{AxisSpec, Scale};
use super::canvas::INK;
use super::chart::{Bar, ChartRow, Data, Rows, Shape};
use super::plot::Key;
use crate::batch::record::Clock;

/// Opacity of the map and reconstruction parts of a bar; that of the march is 1.
const MAP_SHADE: f64 = 0.25;
const RECONSTRUCT_SHADE: f64 = 0.55;
/// Largest number of rows in a chart; of more, only the fastest are shown.
const MOST: usize = 60;

/// Times as bars; `None` when no cell has a time.
pub fn data(view: &ReportView<'_>, case: &CellGroup<'_>) -> Option<(Data, String)> {
    let mut shots = case.shots();
    shots.retain(|shot| shot.time_ms().is_some());
    if shots.is_empty() {
        return None;
    }
    let all = shots.len();
    if all > MOST {
        let time = |shot: &Shot<'_>| shot.time_ms().unwrap_or(f64::INFINITY);
        shots.sort_by(|a, b| time(a).total_cmp(&time(b)));
        shots.truncate(MOST);
    }
    let title = format!("{} time of {} (ms)", view.clock().name(), view.timed());
    let rows = Rows {
        axis: AxisSpec::new(title, Scale::Linear),
        keys: keys(view, &shots),
        rows: shots.iter().filter_map(|shot| row(view, shot)).collect(),
    };
    Some((Data::Rows(rows), note(view, all)))
}

fn note(view: &ReportView<'_>, all: usize) -> String {
    match (all > MOST, view.frames()) {
        (false, "") => {
            "Bars and numbers: medians. Whiskers: smallest to 95th percentile.".to_owned()
        }
        (false, frames) => format!("Medians. Whiskers: min to p95.{frames}"),
        (true, "") => format!(
            "The {MOST} fastest of {all} cells, the table has the rest. Whiskers: min to 95th percentile."
        ),
        (true, frames) => format!("The {MOST} fastest of {all} cells.{frames}"),
    }
}

fn keys(view: &ReportView<'_>, shots: &[Shot<'_>]) -> Vec<(Key, String)> {
    let mut keys = match view.clock() {
        Clock::Device => vec![
            (MAP_SHADE, "making the map (pale)"),
            (1.0, "view march (full)"),
        ],
        Clock::Wall => vec![(1.0, "map and view march together")],
    };
    if shots.iter().any(|shot| reconstruct_ms(shot) > 0.0) {
        keys.push((RECONSTRUCT_SHADE, "reconstruction (half)"));
    }
    let key = |(shade, text): (f64, &str)| (Key::Swatch(INK, shade), text.to_owned());
    keys.into_iter().map(key).collect()
}

/// Time of the reconstruction pass, ms; 0 where there is none or only the total was timed.
fn reconstruct_ms(shot: &Shot<'_>) -> f64 {
    match shot.clock {
        Clock::Device => shot.numbers.time_ms.reconstruct.map_or(0.0, |t| t.median),
        Clock::Wall => 0.0,
    }
}

fn row(view: &ReportView<'_>, shot: &Shot<'_>) -> Option<ChartRow> {
    let total = shot.time()?;
    let map_ms = match shot.clock {
        Clock::Device => shot.numbers.time_ms.generate.map_or(0.0, |t| t.median),
        Clock::Wall => 0.0,
    };
    // Medians of passes need not add up to the median total: the march gets the remainder.
    let map_end = map_ms.min(total.median);
    let march_end = (total.median - reconstruct_ms(shot)).max(map_end);
    let parts = vec![
        (map_end, MAP_SHADE),
        (march_end, 1.0),
        (total.median, RECONSTRUCT_SHADE),
    ];
    Some(ChartRow {
        label: view.short(shot.cell),
        style: Style::of(&shot.cell.method),
        bars: vec![Bar {
            name: "",
            shape: Shape::Parts(parts, Some([total.min, total.p95])),
            text: ms(Some(total.median)),
        }],
    })
}
