//! Error against the number or the length of steps, one line for each method and remaining setting.

use super::super::style::Style;
use super::super::view::{Case, View, distinct};
use super::axis::Axis;
use super::canvas::{ink_of, sheet};
use super::plot::{ERROR_TITLE, Key, Plot, caption, legend, title};
use crate::error::Result;

/// What is on the horizontal axis.
pub struct Sweep {
    param: &'static str,
    /// Heading of the chart.
    pub title: &'static str,
    axis: &'static str,
    note: &'static str,
}

/// Error against the number of steps of the light or map march.
pub const COUNT: Sweep = Sweep {
    param: "steps",
    title: "Error against steps",
    axis: "steps of the light or map march (log)",
    note: "Each line: one method at one setting of everything but its steps.",
};
/// Error against the length of steps: how far the truth has converged.
pub const LENGTH: Sweep = Sweep {
    param: "step_m",
    title: "Error against step length",
    axis: "step of the light march (m, log)",
    note: "Each line: one method at one setting of everything but its step. The truth's own step has no error.",
};

/// Cells that differ in nothing but what is swept.
struct Line<'a> {
    method: &'a str,
    label: String,
    points: Vec<(f64, f64)>,
}

/// How the lines of one method are told apart.
const PATTERNS: [&[f64]; 5] = [
    &[],
    &[7.0, 4.0],
    &[2.0, 3.0],
    &[10.0, 3.0, 2.0, 3.0],
    &[14.0, 5.0],
];

/// The chart; `None` when no setting was measured at two values of the sweep.
pub fn draw(view: &View<'_>, case: &Case<'_>, sweep: &Sweep) -> Result<Option<String>> {
    let lines = lines(view, case, sweep.param);
    if lines.is_empty() {
        return Ok(None);
    }
    let rank = |i: usize| {
        lines[..i]
            .iter()
            .filter(|l| l.method == lines[i].method)
            .count()
    };
    let styled: Vec<(&Line<'_>, Style, &'static [f64])> = lines
        .iter()
        .enumerate()
        .map(|(i, l)| (l, Style::of(l.method), PATTERNS[rank(i) % PATTERNS.len()]))
        .collect();
    let rows = i32::try_from(lines.len() / 2).unwrap_or(0).min(30);
    let height = 500 + 16 * rows;
    let svg = sheet(height, |canvas| {
        let top = title(canvas, sweep.title, &case.short_name)?;
        let keys: Vec<_> = styled
            .iter()
            .map(|(l, s, p)| (Key::Line(*s, p), l.label.clone()))
            .collect();
        let top = legend(canvas, top, &keys)?;
        let all = || lines.iter().flat_map(|l| l.points.iter());
        let x = Axis::log_at(sweep.axis, all().map(|p| p.0));
        let y = Axis::log(ERROR_TITLE, "0", all().map(|p| p.1));
        let plot = Plot::new(top, height, 84, x, y);
        plot.draw(canvas)?;
        for (line, style, pattern) in &styled {
            let path: Vec<_> = line
                .points
                .iter()
                .map(|p| (plot.px(p.0), plot.py(p.1)))
                .collect();
            canvas.dashed(&path, ink_of(*style), 2, pattern)?;
            path.iter()
                .try_for_each(|at| canvas.marker(*at, 4.0, *style, false))?;
        }
        caption(canvas, view, height, sweep.note)
    })?;
    Ok(Some(svg))
}

fn lines<'a>(view: &View<'_>, case: &Case<'a>, param: &'static str) -> Vec<Line<'a>> {
    let mut groups: Vec<(Vec<(&String, &serde_json::Value)>, Line<'a>)> = Vec::new();
    for shot in case.shots() {
        let cell = shot.cell;
        let Some(value) = cell.params.get(param).and_then(serde_json::Value::as_f64) else {
            continue;
        };
        let key: Vec<_> = cell.params.iter().filter(|(k, _)| *k != param).collect();
        let point = (value, shot.rel_rmse());
        match groups
            .iter_mut()
            .find(|(k, l)| l.method == cell.method && *k == key)
        {
            Some((_, line)) => line.points.push(point),
            None => {
                let label = view.short_without(cell, &[param]);
                groups.push((
                    key,
                    Line {
                        method: &cell.method,
                        label,
                        points: vec![point],
                    },
                ));
            }
        }
    }
    let mut lines: Vec<Line<'a>> = groups.into_iter().map(|(_, line)| line).collect();
    lines
        .iter_mut()
        .for_each(|l| l.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    lines.retain(|l| distinct(l.points.iter().map(|p| p.0)).len() > 1);
    lines
}
