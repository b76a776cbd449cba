//! Grouped bars of the three errors of each cell and their total; not stacked, since RMSEs do not add up.

use super::super::format::number;
use super::super::style::Style;
use super::super::view::{CellGroup, ReportView, Shot};
use super::axis::{AxisSpec, Scale};
use super::chart::{Bar, ChartRow, Data, Rows, Shape};
use crate::batch::record::{Cell, Decomposition};

/// Largest number of cells in a chart; of more, only the first are shown.
const MOST: usize = 24;

/// The bars of every cell; `None` when no cell was decomposed.
pub fn data(view: &ReportView<'_>, case: &CellGroup<'_>) -> Option<(Data, String)> {
    let shots = case.shots();
    let decomposed = shots
        .iter()
        .filter_map(|shot| Some((shot.cell, bars(shot)?)));
    let all: Vec<(&Cell, Vec<Bar>)> = decomposed.collect();
    if all.is_empty() {
        return None;
    }
    let shown = shots
        .iter()
        .filter_map(|shot| shot.numbers.decomposition.as_ref());
    let truths = shown.take(MOST).map(|parts| parts.truth_rel_rmse);
    let truths = number(truths.fold(0.0, f64::max));
    let mut note = format!(
        "RMSEs do not add: nothing is stacked. The device's and the f64 truth differ by {truths} at most."
    );
    if all.len() > MOST {
        note += &format!(" The first {MOST} of {} cells.", all.len());
    }
    let title = "RMS over that of the truth (log; bars of one cell beside each other)";
    let row = |(cell, bars): (&Cell, Vec<Bar>)| ChartRow {
        label: view.short(cell),
        style: Style::of(&cell.method),
        bars,
    };
    let rows = Rows {
        axis: AxisSpec::new(title, Scale::Log),
        keys: Vec::new(),
        rows: all.into_iter().take(MOST).map(row).collect(),
    };
    Some((Data::Rows(rows), note))
}

/// The bars of a cell, top to bottom.
fn bars(shot: &Shot<'_>) -> Option<Vec<Bar>> {
    let parts: &Decomposition = shot.numbers.decomposition.as_ref()?;
    let bars = [
        ("total", shot.rel_rmse(), 1.0),
        ("model", parts.model_rel_rmse, 0.55),
        ("sampling", parts.sampling_rel_rmse, 0.3),
        ("precision", parts.precision_rel_rmse, 0.1),
    ];
    let bar = |(name, value, shade): (&'static str, f64, f64)| Bar {
        name,
        shape: Shape::Parts(vec![(value, shade)], None),
        text: number(value),
    };
    Some(bars.map(bar).into())
}
