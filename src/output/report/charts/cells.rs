//! Charts with a point for each cell of one case: one number against another, or against a parameter.

use super::super::pareto::frontier;
use super::super::style::Style;
use super::super::view::{CellGroup, ReportView, Shot, distinct};
use super::axis::{AxisSpec, Scale};
use super::chart::{Data, Look, Plane, Point, PointSeries, dash};
use super::numbers::Number;
use crate::batch::record::Cell;
use serde_json::Value;

/// A cell's point.
struct Dot<'a> {
    shot: Shot<'a>,
    point: Point,
}

/// Scatter chart of two numbers with the Pareto frontiers of all cells and of those with a map; `None` without points.
pub fn scatter(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    [x, y]: [&Number; 2],
) -> Option<(Data, String)> {
    let shots = case.shots();
    let dots = shots.iter().filter_map(|shot| dot(*shot, x, y));
    let dots: Vec<Dot<'_>> = dots.collect();
    if dots.is_empty() {
        return None;
    }
    let mut note = format!("{}{}", (x.note)(view), (y.note)(view));
    for number in [x, y] {
        let lacking = shots.iter().filter(|shot| (number.of)(shot).is_none());
        match lacking.count() {
            0 => {}
            n => note += &format!(" Not shown, without {}: {n}.", number.without),
        }
    }
    let methods = case.methods().into_iter();
    let mut series: Vec<PointSeries> = methods.map(|method| of_method(&dots, method)).collect();
    series.extend(frontiers(view, &dots));
    let plane = Plane {
        x: (x.axis)(view),
        y: (y.axis)(view),
        series,
        levels: Vec::new(),
        places: Vec::new(),
    };
    Some((Data::Plane(plane), note))
}

fn dot<'a>(shot: Shot<'a>, x: &Number, y: &Number) -> Option<Dot<'a>> {
    let ((x, x_range), (y, y_range)) = ((x.of)(&shot)?, (y.of)(&shot)?);
    let point = Point {
        x,
        y,
        x_range,
        y_range,
        label: String::new(),
    };
    Some(Dot { shot, point })
}

fn of_method(dots: &[Dot<'_>], method: &str) -> PointSeries {
    let own = dots.iter().filter(|dot| dot.shot.cell.method == method);
    PointSeries {
        label: method.to_owned(),
        style: Style::of(method),
        look: Look::Points,
        points: own.map(|dot| dot.point.clone()).collect(),
    }
}

/// Pareto frontier of all dots, and that of dots with a map where it differs: a method without a map, of cost 0, may
/// beat all that have one, and the second frontier still shows which map is best.
fn frontiers(view: &ReportView<'_>, dots: &[Dot<'_>]) -> [PointSeries; 2] {
    let places = |with_map: bool| -> Vec<(f64, f64)> {
        let place = |dot: &Dot<'_>| match with_map && dot.shot.map_bytes() == 0 {
            true => (f64::NAN, dot.point.y),
            false => (dot.point.x, dot.point.y),
        };
        dots.iter().map(place).collect()
    };
    let best = frontier(&places(false));
    let mut with_map = frontier(&places(true));
    let costs_nothing = dots.iter().any(|dot| dot.point.x <= 0.0);
    if !costs_nothing || with_map.iter().all(|i| best.contains(i)) {
        with_map.clear();
    }
    let labelled = |i: usize| Point {
        label: view.short(dots[i].shot.cell),
        ..Point::at(dots[i].point.x, dots[i].point.y)
    };
    let series = |label: &str, look, points| PointSeries {
        label: label.to_owned(),
        style: super::chart::GREY,
        look,
        points,
    };
    let of_maps = with_map.iter().map(|&i| match best.contains(&i) {
        true => Point::at(dots[i].point.x, dots[i].point.y),
        false => labelled(i),
    });
    let of_maps = of_maps.collect();
    let of_all = best.iter().map(|&i| labelled(i)).collect();
    [
        series("Pareto frontier", Look::Frontier(true), of_all),
        series("frontier of maps alone", Look::Frontier(false), of_maps),
    ]
}

/// Parameter on the horizontal axis.
pub struct ParamAxis {
    /// Name of the parameter.
    pub param: &'static str,
    /// Title of the axis.
    pub axis: &'static str,
    /// How to read the chart.
    pub note: &'static str,
}

/// Chart of a number over a parameter, one line for each method and remaining setting; `None` when no setting was
/// measured at two values of it.
pub fn sweep(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    over: &ParamAxis,
    y: &Number,
) -> Option<(Data, String)> {
    let mut lines: Vec<(&Cell, Vec<Point>)> = Vec::new();
    for shot in case.shots() {
        let cell = shot.cell;
        let x = cell.params.get(over.param).and_then(Value::as_f64);
        let (Some(x), Some((y, y_range))) = (x, (y.of)(&shot)) else {
            continue;
        };
        let point = Point {
            y_range,
            ..Point::at(x, y)
        };
        match lines
            .iter_mut()
            .find(|(known, _)| same_but(known, cell, over.param))
        {
            Some((_, points)) => points.push(point),
            None => lines.push((cell, vec![point])),
        }
    }
    lines.retain(|(_, points)| distinct(points.iter().map(|point| point.x)).len() > 1);
    if lines.is_empty() {
        return None;
    }
    let lines = lines.into_iter().map(|(cell, mut points)| {
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let label = view.short_without(cell, &[over.param]);
        (label, cell.method.as_str(), points)
    });
    let plane = Plane {
        x: AxisSpec::new(over.axis, Scale::LogAtValues),
        y: (y.axis)(view),
        series: apart(lines),
        levels: Vec::new(),
        places: Vec::new(),
    };
    Some((Data::Plane(plane), over.note.to_owned()))
}

/// True where two cells differ at most in one parameter.
fn same_but(a: &Cell, b: &Cell, param: &str) -> bool {
    let [a_others, b_others] =
        [a, b].map(|cell| cell.params.iter().filter(|(key, _)| *key != param));
    a.method == b.method && a_others.eq(b_others)
}

/// Series of lines with label and method; lines of one method differ in their dash patterns.
pub fn apart<'a>(lines: impl Iterator<Item = (String, &'a str, Vec<Point>)>) -> Vec<PointSeries> {
    let mut methods: Vec<&str> = Vec::new();
    let line = |(label, method, points)| {
        let rank = methods.iter().filter(|known| **known == method).count();
        methods.push(method);
        PointSeries {
            label,
            style: Style::of(method),
            look: Look::Line(dash(rank)),
            points,
        }
    };
    lines.map(line).collect()
}
