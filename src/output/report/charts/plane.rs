//! Draws a chart with two axes: fills first, then lines, ranges, markers and labels, so that no line covers a marker.

use super::super::style::{Marker, Style};
use super::canvas::{Canvas, GRID, Hang, INK, MUTED, Px, SMALL, ink_of};
use super::chart::{DASHED, DOTTED, Dash, Look, Plane, Point, PointSeries, SOLID};
use super::labels::Placer;
use super::plot::{FRONTIER_DASH, Key, Plot};
use crate::error::Result;
use plotters::style::Color as _;

/// Height of every plot, px.
pub const HEIGHT: i32 = 320;
/// Width of the vertical axis with its labels, px.
const LEFT: i32 = 84;
/// Height of a strip under the upper edge, px.
const STRIP: i32 = 7;
/// Opacity of a strip ([`PALE`]) and of the bar of a range ([`RANGE`]).
const PALE: f64 = 0.5;
const RANGE: f64 = 0.75;
/// Widest label, px.
const WIDEST: i32 = 220;
/// Style of marks for values that are not finite.
const NOT_FINITE: Style = Style {
    rgb: (0xa3, 0x21, 0x0f),
    marker: Marker::Cross,
};

impl Plane {
    /// True where a series has points.
    pub(super) fn has_points(&self) -> bool {
        self.series.iter().any(|series| !series.points.is_empty())
    }

    fn points(&self) -> impl Iterator<Item = &Point> {
        self.series.iter().flat_map(|series| &series.points)
    }
}

/// Entries of the legend without duplicates.
pub fn keys(plane: &Plane) -> Vec<(Key, String)> {
    let mut keys: Vec<(Key, String)> = Vec::new();
    for series in &plane.series {
        let known = keys.iter().any(|(_, text)| *text == series.label);
        if !known && !series.label.is_empty() && !series.points.is_empty() {
            keys.push((key(series), series.label.clone()));
        }
    }
    let places = plane.places.iter();
    keys.extend(places.map(|(_, text)| (Key::Thin(DOTTED, false), text.clone())));
    if plane.points().any(|point| !point.y.is_finite()) {
        keys.push((Key::Marker(NOT_FINITE), "not finite".to_owned()));
    }
    keys
}

fn key(series: &PointSeries) -> Key {
    let style = series.style;
    match series.look {
        Look::Line(dash) => Key::Line(style, dash, true),
        Look::Sparse(..) => Key::Line(style, SOLID, true),
        Look::Bare(dash, _) => Key::Line(style, dash, false),
        Look::Points => Key::Marker(style),
        Look::Hollow | Look::Published => Key::Hollow(style),
        Look::Frontier(true) => Key::Thin(FRONTIER_DASH, true),
        Look::Frontier(false) => Key::Thin(DOTTED, false),
        Look::Columns => Key::Swatch(GRID, 1.0),
        Look::Strip => Key::Swatch(ink_of(style), PALE),
    }
}

/// The plot from `top` to the foot of a sheet of this `height`.
pub fn draw(canvas: &Canvas<'_>, plane: &Plane, top: i32, height: i32) -> Result<()> {
    let xs = plane
        .points()
        .flat_map(|p| p.x_range.into_iter().flatten().chain([p.x]));
    let ys = plane
        .points()
        .flat_map(|p| p.y_range.into_iter().flatten().chain([p.y]))
        .chain(plane.levels.iter().copied());
    let (xs, ys): (Vec<f64>, Vec<f64>) = (xs.collect(), ys.collect());
    let plot = Plot::new(top, height, LEFT, plane.x.over(&xs), plane.y.over(&ys));
    plot.draw(canvas)?;
    let each = |draw: fn(&Canvas<'_>, &Plot, &PointSeries) -> Result<()>| {
        let mut series = plane.series.iter();
        series.try_for_each(|series| draw(canvas, &plot, series))
    };
    each(fills)?;
    rules(canvas, &plot, plane)?;
    each(lines)?;
    each(ranges)?;
    each(marks)?;
    labels(canvas, &plot, plane)
}

/// Draws columns from the foot and strips under the upper edge.
fn fills(canvas: &Canvas<'_>, plot: &Plot, series: &PointSeries) -> Result<()> {
    let [_, top, _, bottom] = plot.bounds;
    for point in &series.points {
        let [from, to] = point.x_range.unwrap_or([point.x; 2]).map(|x| plot.px(x));
        match series.look {
            Look::Columns => canvas.rect([(from, plot.py(point.y)), (to, bottom)], GRID)?,
            Look::Strip => {
                let color = ink_of(series.style).mix(PALE);
                canvas.rect([(from, top + 1), (to, top + STRIP)], color)?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// Draws lines at values of one axis.
fn rules(canvas: &Canvas<'_>, plot: &Plot, plane: &Plane) -> Result<()> {
    let [left, top, right, bottom] = plot.bounds;
    for level in &plane.levels {
        let y = plot.py(*level);
        canvas.dashed(&[(left, y), (right, y)], MUTED, 1, DASHED)?;
    }
    for (place, _) in &plane.places {
        let x = plot.px(*place);
        canvas.dashed(&[(x, top), (x, bottom)], MUTED, 1, DOTTED)?;
    }
    Ok(())
}

fn at(plot: &Plot, point: &Point) -> Px {
    (plot.px(point.x), plot.py(point.y))
}

fn lines(canvas: &Canvas<'_>, plot: &Plot, series: &PointSeries) -> Result<()> {
    let ink = ink_of(series.style);
    let (color, width, dash): (_, _, Dash) = match series.look {
        Look::Line(dash) => (ink, 2, dash),
        Look::Sparse(..) => (ink, 2, SOLID),
        Look::Bare(dash, width) => (ink, width, dash),
        Look::Published => (ink, 1, DOTTED),
        Look::Frontier(true) => (MUTED, 1, FRONTIER_DASH),
        Look::Frontier(false) => (MUTED, 1, DOTTED),
        Look::Points | Look::Hollow | Look::Columns | Look::Strip => return Ok(()),
    };
    paths(plot, series)
        .iter()
        .try_for_each(|path| canvas.dashed(path, color, width, dash))
}

/// The line of a series, split where a value is not finite.
fn paths(plot: &Plot, series: &PointSeries) -> Vec<Vec<Px>> {
    if let Look::Frontier(_) = series.look {
        return vec![stairs(plot, &series.points)];
    }
    let pieces = series.points.split(|point| !point.y.is_finite());
    let path = |piece: &[Point]| piece.iter().map(|point| at(plot, point)).collect();
    pieces.filter(|piece| !piece.is_empty()).map(path).collect()
}

/// Staircase of a frontier: at each x the smallest y of all points up to it.
fn stairs(plot: &Plot, points: &[Point]) -> Vec<Px> {
    let mut path: Vec<Px> = Vec::new();
    for at in points.iter().map(|point| at(plot, point)) {
        path.extend(path.last().map(|last| (at.0, last.1)));
        path.push(at);
    }
    path.extend(path.last().map(|last| (plot.bounds[2], last.1)));
    path
}

/// Draws bars with ends from the lower to the upper end of each range.
fn ranges(canvas: &Canvas<'_>, plot: &Plot, series: &PointSeries) -> Result<()> {
    if matches!(series.look, Look::Columns | Look::Strip) {
        return Ok(());
    }
    let color = ink_of(series.style).mix(RANGE);
    for point in series.points.iter().filter(|point| point.y.is_finite()) {
        let (x, y) = at(plot, point);
        if let Some([a, b]) = point.x_range.map(|range| range.map(|x| plot.px(x))) {
            canvas.line(&[(a, y), (b, y)], color, 2)?;
            canvas.line(&[(a, y - 4), (a, y + 4)], color, 2)?;
            canvas.line(&[(b, y - 4), (b, y + 4)], color, 2)?;
        }
        if let Some([a, b]) = point.y_range.map(|range| range.map(|y| plot.py(y))) {
            canvas.line(&[(x, a), (x, b)], color, 2)?;
            canvas.line(&[(x - 4, a), (x + 4, a)], color, 2)?;
            canvas.line(&[(x - 4, b), (x + 4, b)], color, 2)?;
        }
    }
    Ok(())
}

fn marks(canvas: &Canvas<'_>, plot: &Plot, series: &PointSeries) -> Result<()> {
    let (first, step) = match series.look {
        Look::Sparse(first, step) => (first, step.max(1)),
        _ => (0, 1),
    };
    for (i, point) in series.points.iter().enumerate() {
        if !point.y.is_finite() {
            let edge = (plot.px(point.x), plot.bounds[1] + STRIP);
            canvas.marker(edge, 3.0, NOT_FINITE, false)?;
            continue;
        }
        let (place, style) = (at(plot, point), series.style);
        match series.look {
            Look::Line(_) => canvas.marker(place, 4.0, style, false)?,
            Look::Sparse(..) if i >= first && (i - first) % step == 0 => {
                canvas.marker(place, 4.0, style, false)?;
            }
            Look::Points => canvas.marker(place, 5.0, style, false)?,
            Look::Hollow => canvas.marker(place, 5.0, style, true)?,
            Look::Published => canvas.marker(place, 4.0, style, true)?,
            Look::Frontier(true) => canvas.ring(place, 9, INK, 2)?,
            _ => {}
        }
    }
    Ok(())
}

/// Draws labels beside points so that they cover no points and, where possible, no lines.
fn labels(canvas: &Canvas<'_>, plot: &Plot, plane: &Plane) -> Result<()> {
    if plane.points().all(|point| point.label.is_empty()) {
        return Ok(());
    }
    let mut placer = Placer::new(plot.bounds);
    placer.avoid_line(&plot.break_line());
    for series in &plane.series {
        let radius = match series.look {
            Look::Frontier(true) => 10,
            Look::Points | Look::Hollow => 7,
            _ => 0,
        };
        for point in series.points.iter().filter(|_| radius > 0) {
            let (x, y) = at(plot, point);
            placer.keep_free((x, y), radius);
            let range = point.x_range.map(|range| range.map(|x| (plot.px(x), y)));
            range.iter().for_each(|ends| placer.avoid_line(ends));
            let range = point.y_range.map(|range| range.map(|y| (x, plot.py(y))));
            range.iter().for_each(|ends| placer.avoid_line(ends));
        }
        if !matches!(
            series.look,
            Look::Points | Look::Hollow | Look::Columns | Look::Strip
        ) {
            let paths = paths(plot, series);
            paths.iter().for_each(|path| placer.avoid_line(path));
        }
    }
    for point in plane.points().filter(|point| !point.label.is_empty()) {
        let place = at(plot, point);
        let text = canvas.fit(&point.label, SMALL, WIDEST)?;
        let Some(placed) = placer.place(place, canvas.width(&text, SMALL)?) else {
            continue;
        };
        if placed.leader {
            canvas.line(&[place, placed.near], MUTED, 1)?;
        }
        canvas.text(placed.text, &text, SMALL, INK, Hang::Right)?;
    }
    Ok(())
}
