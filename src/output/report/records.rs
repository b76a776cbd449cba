//! Records as pretty JSON that reads back as exactly the records it was written from.

use super::fields;
use crate::batch::record::{Cell, Measured, Report};
use crate::error::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// Most re-reads by [`settle`]: the reader may round a number in its last digit; one re-read is nearly always enough.
const READS: usize = 8;

/// The report as it reads back from its file: cells with numbers that JSON cannot hold become failed cells, and every
/// number is the one read from the file. Charts and page therefore do not change when they are rebuilt from it.
pub fn settle(report: &Report, folder: &Path) -> Result<Report> {
    let path = folder.join("report.json");
    let mut settled = report.clone();
    settled.cells.iter_mut().for_each(fail_non_finite);
    let mut before = text(&settled, &path)?;
    for _ in 0..READS {
        settled = serde_json::from_str(&before).map_err(|e| unreadable(&path, &e))?;
        let after = text(&settled, &path)?;
        if after == before {
            break;
        }
        before = after;
    }
    Ok(settled)
}

/// Pretty JSON with a final newline.
pub fn text(report: &Report, path: &Path) -> Result<String> {
    let mut text = serde_json::to_string_pretty(report).map_err(|e| unreadable(path, &e))?;
    text.push('\n');
    Ok(text)
}

fn unreadable(path: &Path, problem: &serde_json::Error) -> Error {
    Error::defect(
        path.display().to_string(),
        format!("the records cannot be written as JSON: {problem}"),
    )
}

/// Marks a cell as failed where a required number is NaN or infinite, which JSON writes as `null`.
fn fail_non_finite(cell: &mut Cell) {
    let Some(measured) = &cell.result else { return };
    let Ok(value) = serde_json::to_value(measured) else {
        return;
    };
    if serde_json::from_value::<Measured>(value.clone()).is_ok() {
        return;
    }
    let mut names = Vec::new();
    nulls(&value, "", &mut names);
    let count = measured.error.nonfinite;
    cell.failed = Some(format!(
        "numbers that are not finite: {} ({count} channels of the picture are NaN or infinite)",
        names.join(", ")
    ));
    cell.result = None;
}

/// True for a field that may be `null`, so that its `null` is not an error.
fn optional(name: &str) -> bool {
    let mut fields = fields::measured().iter();
    fields.any(|field| field.optional && field.name == name)
}

fn nulls(value: &Value, name: &str, out: &mut Vec<String>) {
    let join = |key: &str| {
        if name.is_empty() {
            key.to_owned()
        } else {
            format!("{name}.{key}")
        }
    };
    match value {
        Value::Null if !optional(name) => out.push(name.to_owned()),
        Value::Object(map) => map.iter().for_each(|(k, v)| nulls(v, &join(k), out)),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .for_each(|(i, v)| nulls(v, &join(&i.to_string()), out)),
        _ => {}
    }
}
