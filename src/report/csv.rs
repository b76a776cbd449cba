//! `cells.csv`: one row a cell, every scalar of the record under its dotted name.

use crate::batch::record::{Decomposition, Measured, Report, Times};
use crate::error::{Error, Result};
use crate::metrics::{ErrorNumbers, Stats};
use crate::raymarch::{Memory, Samples};
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// The table as text. Columns: the cell's key, `params.*` and `scene_set.*` as the union over all cells, `failed`, the
/// measurements, those of temporal integration where a cell has them, `files.*`. A value that a cell does not have is empty.
pub fn cells(report: &Report) -> Result<String> {
    let rows: Vec<BTreeMap<String, String>> = report.cells.iter().map(row).collect();
    let columns = columns(&rows);
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    writer.write_record(&columns).map_err(|e| defect(&e))?;
    for row in &rows {
        let fields = columns
            .iter()
            .map(|c| row.get(c).map_or("", String::as_str));
        writer.write_record(fields).map_err(|e| defect(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| defect(&e))?;
    String::from_utf8(bytes).map_err(|e| defect(&e))
}

fn defect(problem: &dyn std::fmt::Display) -> Error {
    Error::defect("cells.csv", problem)
}

/// One cell as column → text; the measurements stand at the top level, as in the specification of the record.
fn row(cell: &impl Serialize) -> BTreeMap<String, String> {
    let mut out = BTreeMap::new();
    if let Ok(Value::Object(mut cell)) = serde_json::to_value(cell) {
        let measured = cell.remove("result");
        flatten("", &cell, &mut |name, text| {
            out.insert(name, text);
        });
        if let Some(Value::Object(measured)) = measured {
            flatten("", &measured, &mut |name, text| {
                out.insert(name, text);
            });
        }
    }
    out
}

fn flatten(prefix: &str, map: &Map<String, Value>, put: &mut dyn FnMut(String, String)) {
    for (key, value) in map {
        let name = format!("{prefix}{key}");
        match value {
            Value::Object(inner) => flatten(&format!("{name}."), inner, put),
            Value::Null | Value::Array(_) => {}
            Value::String(text) => put(name, text.clone()),
            other => put(name, other.to_string()),
        }
    }
}

/// Every column, in the order of the record; measurements that no cell has keep their column.
fn columns(rows: &[BTreeMap<String, String>]) -> Vec<String> {
    let union = |prefix: &'static str| {
        let mut names: Vec<String> = rows
            .iter()
            .flat_map(|r| r.keys())
            .filter(|k| k.starts_with(prefix))
            .cloned()
            .collect();
        names.sort();
        names.dedup();
        names
    };
    let named = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    let mut out = named(&["index", "id", "scene"]);
    out.extend(union("scene_set."));
    out.extend(named(&["sun_elevation_deg", "method"]));
    out.extend(union("params."));
    out.extend(
        union("reconstruct")
            .into_iter()
            .filter(|name| name == "reconstruct"),
    );
    out.extend(named(&["backend", "image.width", "image.height", "failed"]));
    out.extend(measurements());
    out.extend(union("time_ms.reconstruct."));
    out.extend(union("reconstruction."));
    out.extend(union("files."));
    out
}

/// Names of all measurements, taken from a record in which nothing is absent.
fn measurements() -> Vec<String> {
    let stats = Some(Stats::default());
    let full = Measured {
        reference: String::new(),
        cloud_pixel_fraction: 0.0,
        fallback_fraction: 0.0,
        memory: Memory {
            allocator_bytes: Some(0),
            ..Memory::default()
        },
        time_ms: Times {
            generate: stats,
            march: stats,
            reconstruct: None,
            total: stats,
            wall: stats,
        },
        frames_in_flight: 1,
        rounds_total_ms: Vec::new(),
        rounds_generate_ms: Vec::new(),
        block: 0,
        samples: Samples::default(),
        look_ups: 0,
        error: ErrorNumbers {
            floor_rel_rmse: Some(0.0),
            flicker: Some(0.0),
            flicker_sun: Some(0.0),
            psnr_db: Some(0.0),
            ..ErrorNumbers::default()
        },
        decomposition: Some(Decomposition {
            ample_steps: Some(0),
            ample_resolution: Some(0),
            noise_filter: Some(String::new()),
            ..Decomposition::default()
        }),
        reconstruction: None,
        notes: Vec::new(),
        files: Map::new(),
    };
    let mut names = Vec::new();
    if let Ok(Value::Object(map)) = serde_json::to_value(full) {
        flatten("", &map, &mut |name, _| names.push(name));
    }
    names
}
