//! Curves of one quantity over another with the spread of their points, beside points that others published.

use super::super::style::Style;
use super::axis::Axis;
use super::canvas::{MUTED, ink_of, sheet};
use super::plot::{Key, Plot, foot, legend, title};
use crate::error::Result;

/// A measured or published point; `low` and `high` are equal to `y` where no spread is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Horizontal value.
    pub x: f64,
    /// Vertical value.
    pub y: f64,
    /// Smallest plausible y.
    pub low: f64,
    /// Largest plausible y.
    pub high: f64,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Filled markers on a solid line.
    Solid,
    /// Filled markers on a dashed line.
    Dashed,
    /// Filled markers alone.
    Points,
    /// Hollow markers on a dotted line: published.
    Published,
}

/// How a vertical axis is spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spread {
    /// From 0.
    Linear,
    /// Logarithmic.
    Log,
    /// Logarithmic, in binary units of bytes.
    Bytes,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Words of the legend.
    pub label: String,
    /// Method whose colour and marker it has.
    pub method: String,
    /// How it is drawn.
    pub look: Look,
    /// Its points, by growing x.
    pub points: Vec<Point>,
}

/// A whole chart.
#[derive(Clone, Debug)]
pub struct Curves {
    /// What it shows.
    pub title: String,
    /// Of what, a line below the title.
    pub of: String,
    /// Title of the horizontal axis and whether it is logarithmic; then curves get a tick at each value.
    pub x: (String, bool),
    /// Title of the vertical axis and how it is spread.
    pub y: (String, Spread),
    /// Curves in the order of the legend.
    pub curves: Vec<Curve>,
    /// Values of y with a line across.
    pub levels: Vec<f64>,
    /// Where the numbers come from.
    pub source: String,
    /// How to read it.
    pub note: String,
}

const HEIGHT: i32 = 470;
const DASHED: &[f64] = &[7.0, 4.0];
const DOTTED: &[f64] = &[2.0, 4.0];

/// The chart as SVG; `None` without a point.
pub fn draw(chart: &Curves) -> Result<Option<String>> {
    let points = || chart.curves.iter().flat_map(|curve| &curve.points);
    if points().next().is_none() {
        return Ok(None);
    }
    let height = HEIGHT + 11 * i32::try_from(chart.curves.len()).unwrap_or(0).min(30);
    let svg = sheet(height, |canvas| {
        let top = title(canvas, &chart.title, &chart.of)?;
        let keys: Vec<_> = chart
            .curves
            .iter()
            .filter(|curve| !curve.points.is_empty())
            .map(|curve| (key(curve), curve.label.clone()))
            .collect();
        let top = legend(canvas, top, &keys)?;
        let loose = chart.curves.iter().all(|curve| curve.look == Look::Points);
        let x = x_axis(&chart.x, loose, points().map(|p| p.x));
        let ends = points()
            .flat_map(|p| [p.low, p.high])
            .chain(chart.levels.clone());
        let y = y_axis(&chart.y, ends);
        let plot = Plot::new(top, height, 84, x, y);
        plot.draw(canvas)?;
        let [left, _, right, _] = plot.bounds;
        for level in &chart.levels {
            let row = plot.py(*level);
            canvas.dashed(&[(left, row), (right, row)], MUTED, 1, DASHED)?;
        }
        for curve in &chart.curves {
            let style = Style::of(&curve.method);
            let path: Vec<_> = curve
                .points
                .iter()
                .map(|p| (plot.px(p.x), plot.py(p.y)))
                .collect();
            match curve.look {
                Look::Points => {}
                Look::Solid => canvas.line(&path, ink_of(style), 2)?,
                Look::Dashed => canvas.dashed(&path, ink_of(style), 2, DASHED)?,
                Look::Published => canvas.dashed(&path, ink_of(style), 1, DOTTED)?,
            }
            for (point, at) in curve.points.iter().zip(&path) {
                if point.high > point.low {
                    let ends = [(at.0, plot.py(point.low)), (at.0, plot.py(point.high))];
                    canvas.line(&ends, ink_of(style), 1)?;
                }
                canvas.marker(*at, 4.0, style, curve.look == Look::Published)?;
            }
        }
        foot(canvas, &chart.source, height, &chart.note)
    })?;
    Ok(Some(svg))
}

fn x_axis(
    (title, log): &(String, bool),
    loose: bool,
    values: impl Iterator<Item = f64> + Clone,
) -> Axis {
    match (log, loose) {
        (true, false) => Axis::log_at(title, values),
        (true, true) => Axis::log(title, "0", values),
        (false, _) => Axis::from_zero(title, values),
    }
}

fn y_axis((title, spread): &(String, Spread), values: impl Iterator<Item = f64> + Clone) -> Axis {
    match spread {
        Spread::Linear => Axis::from_zero(title, values),
        Spread::Log => Axis::log(title, "0", values),
        Spread::Bytes => Axis::bytes(title, "0", values),
    }
}

fn key(curve: &Curve) -> Key {
    let style = Style::of(&curve.method);
    match curve.look {
        Look::Solid => Key::Line(style, &[]),
        Look::Dashed => Key::Line(style, DASHED),
        Look::Points => Key::Marker(style),
        Look::Published => Key::Hollow(style),
    }
}
