//! `cells.csv`: one row for each cell, every scalar of the record under its dotted name.

use super::fields;
use crate::batch::numbers::OF_RECONSTRUCTIONS;
use crate::batch::record::Report;
use crate::error::{Error, Result};
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// The table as text. Columns: the cell's key, `params.*` and `scene_set.*` as the union over all cells, `failed`, the
/// measurements, those of a reconstruction where a cell has them, `files.*`. A missing value is an empty field.
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
    let mut out = named(&["index", "id", "scene", "scene_id"]);
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
    OF_RECONSTRUCTIONS
        .iter()
        .for_each(|start| out.extend(union(start)));
    let mut rest = union("");
    rest.retain(|name| !out.contains(name) && !name.starts_with("files."));
    out.extend(rest);
    out.extend(union("files."));
    out
}

/// Names of all measurements but those of reconstructions, which have columns only where a cell has them.
fn measurements() -> impl Iterator<Item = String> {
    let of_reconstruction = |name: &str| {
        OF_RECONSTRUCTIONS
            .iter()
            .any(|start| name.starts_with(start))
    };
    let scalars = fields::measured().iter().filter(|field| field.scalar);
    scalars
        .map(|field| field.name.clone())
        .filter(move |name| !of_reconstruction(name))
}
