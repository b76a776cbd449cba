//! Memory: what the values need against what the textures take.

use super::super::format::bytes;
use super::super::style::Style;
use super::super::view::{Shot, View, distinct, plain};
use super::WIDTH;
use super::axis::Axis;
use super::canvas::{Canvas, GRID, Hang, INK, MUTED, SMALL, sheet};
use super::plot::{Key, Plot, caption, legend, room_for_rows, row_label, title};
use crate::cost::Memory;
use crate::error::Result;

/// Title of the chart; memory depends on neither scene nor sun.
pub const TITLE: &str = "Memory of the maps: all scenes and suns";
const WHAT: &str = "Memory of the maps";
const WHERE: &str = "all scenes and suns";

const ROW: i32 = 24;
/// Rows beyond this are left to the table.
const MOST: usize = 60;

/// One method at one resolution and storage.
struct Row<'a> {
    method: &'a str,
    label: String,
    memory: Memory,
}

/// Payload against map bytes; `None` when no method has a map.
pub fn draw(view: &View<'_>) -> Result<Option<String>> {
    let rows = rows(view);
    if rows
        .iter()
        .all(|r| r.memory.map_bytes == 0 && r.memory.payload_bytes == 0)
    {
        return Ok(None);
    }
    let height = 192 + ROW * rows.len() as i32;
    let svg = sheet(height, |canvas| {
        let top = title(canvas, WHAT, WHERE)?;
        let grey = Style {
            rgb: (0x55, 0x55, 0x55),
            marker: super::super::style::Marker::Circle,
        };
        let keys = [
            (
                Key::Hollow(grey),
                "hollow: payload (values × bytes × texels)".to_owned(),
            ),
            (
                Key::Marker(grey),
                "filled: textures as allocated".to_owned(),
            ),
        ];
        let top = legend(canvas, top, &keys)?;
        let reach = rows
            .iter()
            .flat_map(|r| [r.memory.payload_bytes as f64, r.memory.map_bytes as f64]);
        let axis = Axis::bytes(
            "memory (bytes, log)",
            "0 (no map)",
            reach.collect::<Vec<_>>().into_iter(),
        );
        let left = room_for_rows(canvas, rows.iter().map(|r| r.label.as_str()))?;
        let plot = Plot::new(top, height, left, axis.clone(), axis);
        plot.draw_x(canvas)?;
        for (i, row) in rows.iter().enumerate() {
            draw_row(canvas, &plot, row, top + ROW * i as i32 + ROW / 2)?;
        }
        let [left, top, right, bottom] = plot.bounds;
        canvas.frame([(left, top), (right, bottom)], INK)?;
        caption(
            canvas,
            view,
            height,
            "Each method once for every resolution, storage and size that was measured.",
        )
    })?;
    Ok(Some(svg))
}

fn draw_row(canvas: &Canvas<'_>, plot: &Plot, row: &Row<'_>, y: i32) -> Result<()> {
    let style = Style::of(row.method);
    let (payload, map) = (row.memory.payload_bytes, row.memory.map_bytes);
    let (a, b) = (plot.px(payload as f64), plot.px(map as f64));
    canvas.line(&[(plot.bounds[0], y), (plot.bounds[2], y)], GRID, 1)?;
    row_label(canvas, y, row.method, &row.label, plot.bounds[0])?;
    canvas.line(&[(a, y), (b, y)], MUTED, 2)?;
    canvas.marker((b, y), 5.0, style, false)?;
    if a != b {
        canvas.marker((a, y), 5.0, style, true)?;
    }
    let text = if payload == map {
        bytes(map)
    } else {
        format!("{} → {}", bytes(payload), bytes(map))
    };
    let width = canvas.width(&text, SMALL)?;
    let (right, left) = (a.max(b) + 12, a.min(b) - 12 - width);
    let at = if right + width < WIDTH - 28 {
        right
    } else {
        left.max(plot.bounds[0] + 4)
    };
    canvas.text((at, y), &text, SMALL, MUTED, Hang::Right)
}

fn rows<'a>(view: &View<'a>) -> Vec<Row<'a>> {
    let mut out: Vec<(Row<'a>, Shot<'a>)> = Vec::new();
    for shot in view.cases.iter().flat_map(super::super::view::Case::shots) {
        let memory = Memory {
            allocator_bytes: None,
            ..shot.numbers.memory
        };
        let label = label(&shot);
        let same = |(r, _): &(Row<'_>, Shot<'_>)| r.label == label && r.memory == memory;
        if !out.iter().any(same) {
            out.push((
                Row {
                    method: &shot.cell.method,
                    label,
                    memory,
                },
                shot,
            ));
        }
    }
    let methods = distinct(out.iter().map(|(r, _)| r.method));
    out.sort_by_key(|(r, _)| {
        (
            methods.iter().position(|m| *m == r.method),
            r.memory.map_bytes,
            r.memory.payload_bytes,
        )
    });
    let clashes: Vec<bool> = out
        .iter()
        .map(|(r, _)| out.iter().filter(|(o, _)| o.label == r.label).count() > 1)
        .collect();
    out.truncate(MOST);
    let name = |((mut row, shot), clash): ((Row<'a>, Shot<'a>), bool)| {
        if clash {
            row.label = view.short_without(shot.cell, &["steps"]);
        }
        row
    };
    out.into_iter().zip(clashes).map(name).collect()
}

fn label(shot: &Shot<'_>) -> String {
    let cell = shot.cell;
    let resolution = cell
        .params
        .get("resolution")
        .map(|v| format!(" {}²", plain(v)))
        .unwrap_or_default();
    let storage = cell
        .params
        .get("storage")
        .map(|v| format!(" {}", plain(v)))
        .unwrap_or_default();
    format!("{}{resolution}{storage}", cell.method)
}
