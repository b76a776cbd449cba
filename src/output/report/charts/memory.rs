//! Chart of map memory: bytes of the stored values (payload) against bytes of the allocated textures.

use super::super::format::bytes;
use super::super::style::Style;
use super::super::view::{CellGroup, ReportView, Shot, distinct, plain};
use super::axis::{AxisSpec, Scale};
use super::chart::{self, Bar, Data, GREY, Rows, Shape};
use super::plot::Key;
use crate::cost::Memory;

/// Largest number of rows; further ones are only in the table.
const MOST: usize = 60;

/// One method at one resolution and storage.
struct MemoryBar<'a> {
    method: &'a str,
    label: String,
    memory: Memory,
}

/// Payload against map bytes; `None` when no method has a map.
pub fn data(view: &ReportView<'_>) -> Option<(Data, String)> {
    let rows = rows(view);
    let no_map = |row: &MemoryBar<'_>| row.memory.map_bytes == 0 && row.memory.payload_bytes == 0;
    if rows.iter().all(no_map) {
        return None;
    }
    let keys = [
        (
            Key::Hollow(GREY),
            "hollow: payload (values × bytes × texels)",
        ),
        (Key::Marker(GREY), "filled: textures as allocated"),
    ];
    let rows = Rows {
        axis: AxisSpec {
            zero: "0 (no map)",
            ..AxisSpec::new("memory (bytes, log)", Scale::Bytes)
        },
        keys: keys.map(|(key, text)| (key, text.to_owned())).into(),
        rows: rows.into_iter().map(drawn).collect(),
    };
    let note = "Each method once for every resolution, storage and size that was measured.";
    Some((Data::Rows(rows), note.to_owned()))
}

fn drawn(row: MemoryBar<'_>) -> chart::ChartRow {
    let (payload, map) = (row.memory.payload_bytes, row.memory.map_bytes);
    let text = match payload == map {
        true => bytes(map),
        false => format!("{} → {}", bytes(payload), bytes(map)),
    };
    chart::ChartRow {
        style: Style::of(row.method),
        bars: vec![Bar {
            name: "",
            shape: Shape::Pair(payload as f64, map as f64),
            text,
        }],
        label: row.label,
    }
}

fn rows<'a>(view: &ReportView<'a>) -> Vec<MemoryBar<'a>> {
    let mut out: Vec<(MemoryBar<'a>, Shot<'a>)> = Vec::new();
    for shot in view.cases.iter().flat_map(CellGroup::shots) {
        let memory = Memory {
            allocator_bytes: None,
            ..shot.numbers.memory
        };
        let label = label(&shot);
        let same = |(r, _): &(MemoryBar<'_>, Shot<'_>)| r.label == label && r.memory == memory;
        if !out.iter().any(same) {
            out.push((
                MemoryBar {
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
    let name = |((mut row, shot), clash): ((MemoryBar<'a>, Shot<'a>), bool)| {
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
