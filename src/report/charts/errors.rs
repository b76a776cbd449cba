//! The three errors of each cell beside their total, in groups: RMSEs do not add, so nothing is stacked.

use super::super::format::number;
use super::super::style::Style;
use super::super::view::{Case, Shot, View};
use super::axis::Axis;
use super::canvas::{Canvas, Hang, INK, MUTED, SMALL, ink_of, sheet};
use super::plot::{Plot, caption, room_for_rows, row_label, title};
use crate::batch::record::Decomposition;
use crate::error::Result;
use plotters::style::{Color as _, WHITE};

/// Height of one bar with its gap, px.
const BAR: i32 = 17;
/// Height of a cell's group, px.
const GROUP: i32 = 4 * BAR + 16;
/// Cells a chart may have before only the first are shown.
const MOST: usize = 24;
/// Room for the names of bars, px.
const NAMES: i32 = 74;

/// The chart; `None` when no cell was decomposed.
pub fn draw(view: &View<'_>, case: &Case<'_>) -> Result<Option<String>> {
    let mut cells: Vec<(Shot<'_>, &Decomposition)> = case
        .shots()
        .into_iter()
        .filter_map(|shot| Some((shot, shot.numbers.decomposition.as_ref()?)))
        .collect();
    if cells.is_empty() {
        return Ok(None);
    }
    let all = cells.len();
    cells.truncate(MOST);
    let truths = cells.iter().map(|(_, d)| d.truth_rel_rmse);
    let truths = number(truths.fold(0.0, f64::max));
    let mut note = format!(
        "RMSEs do not add: nothing is stacked. The device's and the f64 truth differ by {truths}."
    );
    if all > MOST {
        note += &format!(" The first {MOST} of {all} cells.");
    }
    let height = 170 + GROUP * cells.len() as i32;
    let svg = sheet(height, |canvas| {
        let top = title(canvas, "Three errors of each cell", &case.short_name)?;
        let values = cells.iter().flat_map(bars).map(|(_, value, _)| value);
        let values: Vec<f64> = values.collect();
        let axis = Axis::log(
            "RMS over that of the truth (log; bars of one cell beside each other)",
            "0",
            values.into_iter(),
        );
        let labels: Vec<String> = cells.iter().map(|(s, _)| view.short(s.cell)).collect();
        let left = room_for_rows(canvas, labels.iter().map(String::as_str))? + NAMES;
        let plot = Plot::new(top, height, left, axis.clone(), axis);
        plot.draw_x(canvas)?;
        for (i, (cell, label)) in cells.iter().zip(&labels).enumerate() {
            let y = top + 8 + GROUP * i as i32;
            row_label(
                canvas,
                y + BAR / 2,
                &cell.0.cell.method,
                label,
                left - NAMES,
            )?;
            group(canvas, &plot, cell, y)?;
        }
        let [left, top, _, bottom] = plot.bounds;
        canvas.line(&[(left, top), (left, bottom)], INK, 1)?;
        caption(canvas, view, height, &note)
    })?;
    Ok(Some(svg))
}

/// Name, RMSE and shade of the bars of a cell, top to bottom.
fn bars((shot, parts): &(Shot<'_>, &Decomposition)) -> [(&'static str, f64, f64); 4] {
    [
        ("total", shot.rel_rmse(), 1.0),
        ("model", parts.model_rel_rmse, 0.55),
        ("sampling", parts.sampling_rel_rmse, 0.3),
        ("precision", parts.precision_rel_rmse, 0.1),
    ]
}

fn group(
    canvas: &Canvas<'_>,
    plot: &Plot,
    cell: &(Shot<'_>, &Decomposition),
    top: i32,
) -> Result<()> {
    let color = ink_of(Style::of(&cell.0.cell.method));
    let [left, _, right, _] = plot.bounds;
    for (i, (name, value, shade)) in bars(cell).into_iter().enumerate() {
        let y = top + BAR * i as i32 + BAR / 2;
        canvas.text((left - 8, y), name, SMALL, MUTED, Hang::Left)?;
        let end = plot.px(value);
        let corners = [(left, y - 6), (end, y + 6)];
        canvas.rect(corners, color.mix(shade))?;
        canvas.frame(corners, color)?;
        let text = number(value);
        let width = canvas.width(&text, SMALL)?;
        if end + 8 + width < right {
            canvas.text((end + 8, y), &text, SMALL, INK, Hang::Right)?;
        } else {
            // Inside the bar, on a patch of white.
            canvas.rect([(end - 14 - width, y - 6), (end - 4, y + 6)], WHITE)?;
            canvas.text((end - 9, y), &text, SMALL, INK, Hang::Left)?;
        }
    }
    Ok(())
}
