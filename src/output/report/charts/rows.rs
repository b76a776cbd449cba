//! Draws a chart of rows: marker and label at the left, bars over one axis at the right.

use super::WIDTH;
use super::axis::Scale;
use super::canvas::{Canvas, GRID, Hang, INK, MUTED, Px, SMALL, ink_of};
use super::chart::{Bar, ChartRow, Rows, Shape};
use super::plot::{MARGIN, Plot};
use crate::error::Result;
use plotters::style::{Color as _, WHITE};

/// Height of one bar with its gap, px.
const BAR: i32 = 17;
/// Half the height of a bar's fill, px.
const HALF: i32 = 7;
/// Gap between rows of one bar and between rows of several, px.
const GAPS: [i32; 2] = [6, 16];
/// Gap below the last row, px.
const LAST: i32 = 8;
/// Width of the marker before the label of a row, px.
const LEAD: i32 = 18;
/// Width of the names of bars, px.
const NAMES: i32 = 74;
/// Factor on the values of a linear axis: it ends at 1.16 instead of 1.05 times the largest, for the numbers at the
/// bars' ends.
const BEYOND: f64 = 1.16 / 1.05;

/// Height of all rows, px.
pub fn height(data: &Rows) -> i32 {
    data.rows.iter().map(row_height).sum::<i32>() + LAST
}

fn row_height(row: &ChartRow) -> i32 {
    let bars = i32::try_from(row.bars.len()).unwrap_or(1);
    BAR * bars + GAPS[usize::from(bars > 1)]
}

/// The rows from `top` to the foot of a sheet of this `height`.
pub fn draw(canvas: &Canvas<'_>, data: &Rows, top: i32, height: i32) -> Result<()> {
    let bars = || data.rows.iter().flat_map(|row| &row.bars);
    let room = match data.axis.scale {
        Scale::Linear => BEYOND,
        _ => 1.0,
    };
    let values: Vec<f64> = bars().flat_map(|bar| bar.shape.values()).collect();
    let reach: Vec<f64> = values.iter().map(|value| value * room).collect();
    let axis = data.axis.over(&reach);
    let names = match bars().all(|bar| bar.name.is_empty()) {
        true => 0,
        false => NAMES,
    };
    let labels = label_room(canvas, &data.rows)?;
    let plot = Plot::new(top, height, labels + names, axis.clone(), axis);
    plot.draw_x(canvas)?;
    let mut y = top + GAPS[0] / 2 + BAR / 2;
    for row in &data.rows {
        label(canvas, y, row, labels)?;
        for (i, bar) in row.bars.iter().enumerate() {
            draw_bar(canvas, &plot, row, bar, y + BAR * i as i32)?;
        }
        y += row_height(row);
    }
    let [left, top, _, bottom] = plot.bounds;
    canvas.line(&[(left, top), (left, bottom)], INK, 1)
}

/// Width of the labels at the left, px, at most a third of the sheet.
fn label_room(canvas: &Canvas<'_>, rows: &[ChartRow]) -> Result<i32> {
    let mut widest = 0;
    for row in rows {
        widest = widest.max(canvas.width(&row.label, SMALL)?);
    }
    Ok((MARGIN + LEAD + widest + 12).min(WIDTH / 3))
}

fn label(canvas: &Canvas<'_>, y: i32, row: &ChartRow, room: i32) -> Result<()> {
    canvas.marker((MARGIN + 6, y), 4.5, row.style, false)?;
    let label = canvas.fit(&row.label, SMALL, room - MARGIN - LEAD - 10)?;
    canvas.text((MARGIN + LEAD, y), &label, SMALL, INK, Hang::Right)
}

fn draw_bar(canvas: &Canvas<'_>, plot: &Plot, row: &ChartRow, bar: &Bar, y: i32) -> Result<()> {
    let left = plot.bounds[0];
    if !bar.name.is_empty() {
        canvas.text((left - 8, y), bar.name, SMALL, MUTED, Hang::Left)?;
    }
    match &bar.shape {
        Shape::Parts(parts, range) => {
            let range = range.map(|range| range.map(|value| plot.px(value)));
            let end = draw_parts(canvas, plot, row, parts, y)?;
            if let Some([from, to]) = range {
                whisker(canvas, [from, to], y)?;
            }
            number_after(
                canvas,
                plot,
                (range.map_or(end, |r| r[1].max(end)), y),
                &bar.text,
            )
        }
        Shape::Pair(hollow, filled) => {
            let (hollow, filled) = (plot.px(*hollow), plot.px(*filled));
            canvas.line(&[(left, y), (plot.bounds[2], y)], GRID, 1)?;
            canvas.line(&[(hollow, y), (filled, y)], MUTED, 2)?;
            canvas.marker((filled, y), 5.0, row.style, false)?;
            if hollow != filled {
                canvas.marker((hollow, y), 5.0, row.style, true)?;
            }
            let ends = [hollow.min(filled) - 4, hollow.max(filled) + 4];
            number_beside(canvas, plot, ends, y, &bar.text)
        }
    }
}

/// Draws the parts of a bar from the left axis on; returns the column where they end, px.
fn draw_parts(
    canvas: &Canvas<'_>,
    plot: &Plot,
    row: &ChartRow,
    parts: &[(f64, f64)],
    y: i32,
) -> Result<i32> {
    let color = ink_of(row.style);
    let start = plot.bounds[0];
    let mut from = start;
    for (end, shade) in parts {
        let to = plot.px(*end).max(from);
        if to > from {
            canvas.rect([(from, y - HALF), (to, y + HALF)], color.mix(*shade))?;
        }
        from = to;
    }
    canvas.frame([(start, y - HALF), (from, y + HALF)], color)?;
    Ok(from)
}

/// Draws the range of the total, dark with a white rim so that it is visible on any colour.
fn whisker(canvas: &Canvas<'_>, [a, b]: [i32; 2], y: i32) -> Result<()> {
    let lines = [
        [(a, y), (b, y)],
        [(a, y - 4), (a, y + 4)],
        [(b, y - 4), (b, y + 4)],
    ];
    lines
        .iter()
        .try_for_each(|line| canvas.line(line, WHITE, 4))?;
    lines.iter().try_for_each(|line| canvas.line(line, INK, 1))
}

/// Draws the number right of a bar, or inside it on white where there is no room.
fn number_after(canvas: &Canvas<'_>, plot: &Plot, (end, y): Px, text: &str) -> Result<()> {
    let width = canvas.width(text, SMALL)?;
    if end + 8 + width < plot.bounds[2] {
        return canvas.text((end + 8, y), text, SMALL, INK, Hang::Right);
    }
    canvas.rect([(end - 14 - width, y - 6), (end - 4, y + 6)], WHITE)?;
    canvas.text((end - 9, y), text, SMALL, INK, Hang::Left)
}

/// Draws the number right of the span between two ends, or left of it where there is no room.
fn number_beside(
    canvas: &Canvas<'_>,
    plot: &Plot,
    [from, to]: [i32; 2],
    y: i32,
    text: &str,
) -> Result<()> {
    let width = canvas.width(text, SMALL)?;
    let right = to + 8;
    let x = match right + width < plot.bounds[2] {
        true => right,
        false => (from - 8 - width).max(plot.bounds[0] + 4),
    };
    canvas.text((x, y), text, SMALL, INK, Hang::Right)
}
