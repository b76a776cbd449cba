//! Time of each cell, split into map, march and reconstruction where a device timed them.

use super::super::format::ms;
use super::super::style::Style;
use super::super::view::{Case, Shot, View};
use super::axis::Axis;
use super::canvas::{Canvas, Hang, INK, MUTED, SMALL, ink_of, sheet};
use super::plot::{Key, Plot, caption, legend, room_for_rows, row_label, title};
use crate::batch::record::Clock;
use crate::error::Result;
use plotters::style::{Color as _, WHITE};

/// Height of one row, px.
const ROW: i32 = 23;
/// Opacity of the parts of a bar that are not the march.
const MAP_SHADE: f64 = 0.25;
const RECONSTRUCT_SHADE: f64 = 0.55;
/// Rows a chart may have before only the fastest are shown.
const MOST: usize = 60;

/// Times as bars; `None` when no cell has a time.
pub fn draw(view: &View<'_>, case: &Case<'_>) -> Result<Option<String>> {
    let mut shots: Vec<Shot<'_>> = case
        .shots()
        .into_iter()
        .filter(|s| s.time_ms().is_some())
        .collect();
    if shots.is_empty() {
        return Ok(None);
    }
    let all = shots.len();
    if all > MOST {
        shots.sort_by(|a, b| {
            a.time_ms()
                .partial_cmp(&b.time_ms())
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        shots.truncate(MOST);
    }
    let note = match (all > MOST, view.frames()) {
        (false, "") => {
            "Bars and numbers: medians. Whiskers: smallest to 95th percentile.".to_owned()
        }
        (false, frames) => format!("Medians. Whiskers: min to p95.{frames}"),
        (true, "") => format!(
            "The {MOST} fastest of {all} cells, the table has the rest. Whiskers: min to 95th percentile."
        ),
        (true, frames) => format!("The {MOST} fastest of {all} cells.{frames}"),
    };
    let height = 190 + ROW * shots.len() as i32;
    let svg = sheet(height, |canvas| {
        let top = title(canvas, "Time of each cell", &case.short_name)?;
        let mut keys = match view.clock() {
            Clock::Device => vec![
                (
                    Key::Swatch(INK, MAP_SHADE),
                    "making the map (pale)".to_owned(),
                ),
                (Key::Swatch(INK, 1.0), "view march (full)".to_owned()),
            ],
            Clock::Wall => vec![(
                Key::Swatch(INK, 1.0),
                "map and view march together".to_owned(),
            )],
        };
        if shots.iter().any(|s| reconstruct_ms(s) > 0.0) {
            let key = Key::Swatch(INK, RECONSTRUCT_SHADE);
            keys.push((key, "reconstruction (half)".to_owned()));
        }
        let top = legend(canvas, top, &keys)?;
        let reach = shots
            .iter()
            .filter_map(Shot::time)
            .map(|t| t.p95.max(t.median) * 1.16);
        let axis = Axis::from_zero(&time_title(view), reach);
        let labels: Vec<String> = shots.iter().map(|s| view.short(s.cell)).collect();
        let left = room_for_rows(canvas, labels.iter().map(String::as_str))?;
        let plot = Plot::new(top, height, left, axis.clone(), axis);
        plot.draw_x(canvas)?;
        for (i, (shot, label)) in shots.iter().zip(&labels).enumerate() {
            let y = top + ROW * i as i32 + ROW / 2 + 2;
            row_label(canvas, y, &shot.cell.method, label, left)?;
            draw_row(canvas, &plot, shot, y)?;
        }
        let [left, top, _, bottom] = plot.bounds;
        canvas.line(&[(left, top), (left, bottom)], INK, 1)?;
        caption(canvas, view, height, &note)
    })?;
    Ok(Some(svg))
}

fn time_title(view: &View<'_>) -> String {
    format!("{} time of {} (ms)", view.clock().name(), view.timed())
}

/// The pass that adds what was not marched, ms; 0 where there is none or nothing but the whole was timed.
fn reconstruct_ms(shot: &Shot<'_>) -> f64 {
    match shot.clock {
        Clock::Device => shot.numbers.time_ms.reconstruct.map_or(0.0, |t| t.median),
        Clock::Wall => 0.0,
    }
}

fn draw_row(canvas: &Canvas<'_>, plot: &Plot, shot: &Shot<'_>, y: i32) -> Result<()> {
    let Some(total) = shot.time() else {
        return Ok(());
    };
    let color = ink_of(Style::of(&shot.cell.method));
    let map = match shot.clock {
        Clock::Device => shot.numbers.time_ms.generate.map_or(0.0, |t| t.median),
        Clock::Wall => 0.0,
    };
    let (start, end) = (plot.px(0.0), plot.px(total.median));
    // Medians of passes need not add up to that of the whole: the march takes what is left.
    let marched = plot.px(map).min(end);
    let added = plot.px(total.median - reconstruct_ms(shot)).max(marched);
    for (from, to, shade) in [
        (start, marched, MAP_SHADE),
        (marched, added, 1.0),
        (added, end, RECONSTRUCT_SHADE),
    ] {
        if to > from {
            canvas.rect([(from, y - 7), (to, y + 7)], color.mix(shade))?;
        }
    }
    canvas.frame([(start, y - 7), (end, y + 7)], color)?;
    let (a, b) = (plot.px(total.min), plot.px(total.p95));
    let whisker = [
        vec![(a, y), (b, y)],
        vec![(a, y - 4), (a, y + 4)],
        vec![(b, y - 4), (b, y + 4)],
    ];
    for part in &whisker {
        canvas.line(part, WHITE, 4)?;
    }
    for part in &whisker {
        canvas.line(part, INK, 1)?;
    }
    canvas.text(
        (b.max(end) + 8, y),
        &ms(Some(total.median)),
        SMALL,
        MUTED,
        Hang::Right,
    )
}
