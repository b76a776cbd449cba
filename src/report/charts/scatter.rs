//! Error against time and error against memory, with the Pareto frontier.

use super::super::pareto::frontier;
use super::super::style::Style;
use super::super::view::{Case, Shot, View};
use super::axis::Axis;
use super::canvas::{Canvas, Hang, INK, MUTED, Px, SMALL, ink_of, sheet};
use super::labels::Placer;
use super::plot::{ERROR_TITLE, FRONTIER_DASH, Key, MAP_DASH, Plot, caption, legend, title};
use crate::error::Result;
use plotters::style::Color as _;

const HEIGHT: i32 = 520;

/// One cell in a scatter chart.
struct Dot<'a> {
    method: &'a str,
    label: String,
    x: f64,
    spread: Option<(f64, f64)>,
    y: f64,
    has_map: bool,
}

/// Error against time; `None` when no cell has a time.
pub fn error_time(view: &View<'_>, case: &Case<'_>) -> Result<Option<String>> {
    let dot = |s: &Shot<'_>| {
        let time = s.time()?;
        Some((time.median, Some((time.min, time.p95))))
    };
    let dots = dots(view, case, dot);
    if dots.is_empty() {
        return Ok(None);
    }
    let reach = dots
        .iter()
        .flat_map(|d| [Some(d.x), d.spread.map(|s| s.0), d.spread.map(|s| s.1)])
        .flatten();
    let axis = Axis::log(
        &format!(
            "{} time of {} (ms, median, log)",
            view.clock().name(),
            view.timed()
        ),
        "0",
        reach.filter(|v| *v > 0.0),
    );
    let untimed = case.shots().len() - dots.len();
    let mut note = match view.frames() {
        "" => "Points: medians. Horizontal bars: smallest to 95th percentile.".to_owned(),
        frames => format!("Medians. Bars: min to p95.{frames}"),
    };
    if untimed > 0 {
        note += &format!(" Not shown, without timestamps: {untimed}.");
    }
    draw(view, case, "Error against time", axis, &dots, &note).map(Some)
}

/// Error against the bytes of the map and the history; `None` when no cell has numbers.
pub fn error_bytes(view: &View<'_>, case: &Case<'_>) -> Result<Option<String>> {
    let dots = dots(view, case, |s| Some((s.memory_bytes() as f64, None)));
    if dots.is_empty() {
        return Ok(None);
    }
    let (what, zero, note) = if view.temporal() {
        (
            "textures of the map as allocated and history (bytes, log)",
            "0 (neither)",
            "Full pictures without a map stand at 0. Circled: no other cell has both less memory and less error.",
        )
    } else {
        (
            "textures of the map as allocated (bytes, log)",
            "0 (no map)",
            "Methods without a map stand at 0. Circled: no other cell has both less memory and less error.",
        )
    };
    let axis = Axis::bytes(what, zero, dots.iter().map(|d| d.x));
    draw(view, case, "Error against memory", axis, &dots, note).map(Some)
}

type Cost = (f64, Option<(f64, f64)>);

fn dots<'a>(
    view: &View<'_>,
    case: &Case<'a>,
    cost: impl Fn(&Shot<'_>) -> Option<Cost>,
) -> Vec<Dot<'a>> {
    let dot = |s: Shot<'a>| {
        let (x, spread) = cost(&s)?;
        let y = s.rel_rmse();
        Some(Dot {
            method: &s.cell.method,
            label: view.short(s.cell),
            x,
            spread,
            y,
            has_map: s.map_bytes() > 0,
        })
    };
    case.shots().into_iter().filter_map(dot).collect()
}

fn draw(
    view: &View<'_>,
    case: &Case<'_>,
    what: &str,
    x: Axis,
    dots: &[Dot<'_>],
    note: &str,
) -> Result<String> {
    let best = frontier(&dots.iter().map(|d| (d.x, d.y)).collect::<Vec<_>>());
    let with_map = with_map(dots, &best);
    sheet(HEIGHT, |canvas| {
        let top = title(canvas, what, &case.short_name)?;
        let mut keys: Vec<(Key, String)> = case
            .methods()
            .into_iter()
            .filter(|m| dots.iter().any(|d| d.method == *m))
            .map(|m| (Key::Marker(Style::of(m)), m.to_owned()))
            .collect();
        keys.push((Key::Frontier, "Pareto frontier".to_owned()));
        if !with_map.is_empty() {
            keys.push((Key::MapFrontier, "frontier of maps alone".to_owned()));
        }
        let top = legend(canvas, top, &keys)?;
        let y = Axis::log(ERROR_TITLE, "0", dots.iter().map(|d| d.y));
        let plot = Plot::new(top, HEIGHT, 84, x, y);
        plot.draw(canvas)?;
        let lines = [stairs(&plot, dots, &best), stairs(&plot, dots, &with_map)];
        canvas.dashed(&lines[0], MUTED, 1, FRONTIER_DASH)?;
        canvas.dashed(&lines[1], MUTED, 1, MAP_DASH)?;
        draw_dots(canvas, &plot, dots)?;
        draw_labels(canvas, &plot, dots, &best, &with_map, &lines)?;
        caption(canvas, view, HEIGHT, note)
    })
}

/// A staircase: at each cost, the smallest error that can be had for it.
fn stairs(plot: &Plot, dots: &[Dot<'_>], best: &[usize]) -> Vec<Px> {
    let mut path: Vec<Px> = Vec::new();
    for &i in best {
        let at = (plot.px(dots[i].x), plot.py(dots[i].y));
        path.extend(path.last().map(|last| (at.0, last.1)));
        path.push(at);
    }
    path.extend(path.last().map(|last| (plot.bounds[2], last.1)));
    path
}

/// The frontier of the dots with a map, where it is not part of the whole frontier already: a method without a map
/// may beat all that have one, and the reader still wants to know which map is best.
fn with_map(dots: &[Dot<'_>], best: &[usize]) -> Vec<usize> {
    if dots.iter().all(|d| d.x > 0.0) {
        return Vec::new();
    }
    let apart = |d: &Dot<'_>| {
        if d.has_map {
            (d.x, d.y)
        } else {
            (f64::NAN, d.y)
        }
    };
    let own = frontier(&dots.iter().map(apart).collect::<Vec<_>>());
    if own.iter().all(|i| best.contains(i)) {
        Vec::new()
    } else {
        own
    }
}

fn draw_dots(canvas: &Canvas<'_>, plot: &Plot, dots: &[Dot<'_>]) -> Result<()> {
    for dot in dots {
        let y = plot.py(dot.y);
        if let Some((min, p95)) = dot.spread.filter(|s| s.0 > 0.0) {
            let (a, b) = (plot.px(min), plot.px(p95));
            let color = ink_of(Style::of(dot.method)).mix(0.75);
            canvas.line(&[(a, y), (b, y)], color, 2)?;
            canvas.line(&[(a, y - 4), (a, y + 4)], color, 2)?;
            canvas.line(&[(b, y - 4), (b, y + 4)], color, 2)?;
        }
    }
    dots.iter().try_for_each(|d| {
        canvas.marker(
            (plot.px(d.x), plot.py(d.y)),
            5.0,
            Style::of(d.method),
            false,
        )
    })
}

fn draw_labels(
    canvas: &Canvas<'_>,
    plot: &Plot,
    dots: &[Dot<'_>],
    best: &[usize],
    with_map: &[usize],
    lines: &[Vec<Px>],
) -> Result<()> {
    let at = |i: usize| (plot.px(dots[i].x), plot.py(dots[i].y));
    let mut placer = Placer::new(plot.bounds);
    (0..dots.len()).for_each(|i| placer.keep_free(at(i), if best.contains(&i) { 10 } else { 7 }));
    for dot in dots {
        let (min, p95) = dot.spread.unwrap_or((dot.x, dot.x));
        placer.avoid_line(&[
            (plot.px(min), plot.py(dot.y)),
            (plot.px(p95), plot.py(dot.y)),
        ]);
    }
    placer.avoid_line(&plot.break_line());
    lines.iter().for_each(|line| placer.avoid_line(line));
    best.iter()
        .try_for_each(|&i| canvas.ring(at(i), 9, INK, 2))?;
    for &i in best
        .iter()
        .chain(with_map.iter().filter(|i| !best.contains(i)))
    {
        let text = canvas.fit(&dots[i].label, SMALL, 220)?;
        let Some(place) = placer.place(at(i), canvas.width(&text, SMALL)?) else {
            continue;
        };
        if place.leader {
            canvas.line(&[at(i), place.near], MUTED, 1)?;
        }
        canvas.text(place.text, &text, SMALL, INK, Hang::Right)?;
    }
    Ok(())
}
