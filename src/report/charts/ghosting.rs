//! Ghosting: what temporal integration adds to the error of each frame of a pan.

use super::super::style::Style;
use super::super::view::{Case, Shot, View};
use super::axis::Axis;
use super::canvas::{ink_of, sheet};
use super::plot::{Key, Plot, caption, legend, title};
use crate::batch::record::Reconstruction;
use crate::error::Result;

/// Heading of the chart.
pub const TITLE: &str = "Ghosting on a pan of one pixel a frame";

/// How the lines of one method are told apart.
const PATTERNS: [&[f64]; 4] = [&[], &[7.0, 4.0], &[2.0, 3.0], &[10.0, 3.0, 2.0, 3.0]];

/// A cell with its curve, and how its line looks.
struct Line<'a> {
    shot: Shot<'a>,
    curve: &'a [f64],
    style: Style,
    pattern: &'static [f64],
}

/// The chart; `None` when no cell was put together from several frames.
pub fn draw(view: &View<'_>, case: &Case<'_>) -> Result<Option<String>> {
    let mut lines: Vec<Line<'_>> = Vec::new();
    for shot in case.shots() {
        if let Some(Reconstruction {
            ghosting_rel_rmse, ..
        }) = &shot.numbers.reconstruction
        {
            let method = &shot.cell.method;
            let rank = lines.iter().filter(|l| l.shot.cell.method == *method);
            lines.push(Line {
                shot,
                curve: ghosting_rel_rmse,
                pattern: PATTERNS[rank.count() % PATTERNS.len()],
                style: Style::of(method),
            });
        }
    }
    if lines.is_empty() {
        return Ok(None);
    }
    let height = 480 + 16 * i32::try_from(lines.len() / 3).unwrap_or(0).min(30);
    let svg = sheet(height, |canvas| {
        let top = title(canvas, TITLE, &case.short_name)?;
        let key = |l: &Line<'_>| {
            let label = view.short_without(l.shot.cell, &["reconstruct"]);
            (Key::Line(l.style, l.pattern), label)
        };
        let top = legend(canvas, top, &lines.iter().map(key).collect::<Vec<_>>())?;
        let last = lines
            .iter()
            .map(|l| l.curve.len().saturating_sub(1))
            .max()
            .unwrap_or(0);
        let x = Axis::from_zero("frame (0: at rest)", [last as f64].into_iter());
        let y = Axis::from_zero(
            "relative RMSE against the full render",
            lines.iter().flat_map(|l| l.curve.iter().copied()),
        );
        let plot = Plot::new(top, height, 84, x, y);
        plot.draw(canvas)?;
        for line in &lines {
            let values = line.curve.iter().enumerate();
            let path: Vec<_> = values
                .map(|(frame, value)| (plot.px(frame as f64), plot.py(*value)))
                .collect();
            canvas.dashed(&path, ink_of(line.style), 2, line.pattern)?;
            path.iter()
                .try_for_each(|at| canvas.marker(*at, 4.0, line.style, false))?;
        }
        let note = "Each frame against the full render of the same frame by the same method: reconstruction alone.";
        caption(canvas, view, height, note)
    })?;
    Ok(Some(svg))
}
