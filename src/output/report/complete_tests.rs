//! Tests that csv, page and charts show every number that a record holds.

use super::fixture::report;
use super::*;
use crate::batch::numbers::{PagePlace, numbers as rows, study_names};
use crate::batch::record::{Cell, Ghosting, ReconstructionNumbers};
use crate::reconstruct::find;
use crate::scene::CameraTrack;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A record without absent members, generated from its JSON schema.
fn full() -> Cell {
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    let schema = settings.into_generator().into_root_schema_for::<Cell>();
    let mut count = 0.0;
    let mut value = instance(schema.as_value(), &mut count);
    // The schema does not list the keys of maps.
    let ghosting = json!({"step_deg": 0.25, "step_m": 12.5, "rel_rmse": [0.0, 0.5]});
    value["result"]["reconstruction"]["ghosting"] = json!({"pan": ghosting});
    serde_json::from_value(value).expect("the schema describes the record")
}

/// An instance of a schema in which all numbers differ.
fn instance(schema: &Value, count: &mut f64) -> Value {
    let choices = ["anyOf", "oneOf"]
        .iter()
        .filter_map(|k| schema[*k].as_array());
    if let Some(choice) = choices.flatten().find(|choice| choice["type"] != "null") {
        return instance(choice, count);
    }
    if let Some(word) = schema["enum"].as_array().and_then(|words| words.first()) {
        return word.clone();
    }
    if !schema["const"].is_null() {
        return schema["const"].clone();
    }
    let kinds = match &schema["type"] {
        Value::Array(kinds) => kinds.clone(),
        one => vec![one.clone()],
    };
    *count += 1.0;
    match kinds
        .iter()
        .find_map(|k| k.as_str().filter(|k| *k != "null"))
    {
        Some("number") => json!(*count + 0.5),
        Some("integer") => json!(*count as u64),
        Some("boolean") => json!(true),
        Some("array") => json!([]),
        Some("object") => {
            let properties = schema["properties"].as_object().into_iter().flatten();
            properties
                .map(|(name, member)| (name.clone(), instance(member, count)))
                .collect()
        }
        _ => json!(format!("text {count}")),
    }
}

/// Numbers by their dotted names, without those in lists, which have one entry for each repeat and no column.
fn numbers(value: &Value, name: &str, out: &mut Vec<(String, f64)>) {
    match value {
        Value::Object(members) => members.iter().for_each(|(key, member)| {
            let name = match name {
                "" | "result" => key.clone(),
                name => format!("{name}.{key}"),
            };
            numbers(member, &name, out);
        }),
        Value::Number(number) => out.push((name.to_owned(), number.as_f64().expect("number"))),
        _ => {}
    }
}

#[test]
fn every_number_of_a_full_record_has_its_column() {
    let cell = full();
    let mut expected = Vec::new();
    numbers(&json!(cell), "", &mut expected);
    assert!(expected.len() > 60, "{expected:?}");
    let table = csv::cells(&Report {
        cells: vec![cell],
        ..report()
    });
    let table = table.expect("table");
    let mut reader = ::csv::Reader::from_reader(table.as_bytes());
    let names = reader.headers().expect("headers").clone();
    let row = reader.records().next().expect("row").expect("row");
    for (name, number) in expected {
        let column = names.iter().position(|n| n == name);
        let column = column.unwrap_or_else(|| panic!("`{name}` has no column"));
        assert_eq!(row[column].parse(), Ok(number), "{name}");
    }
}

#[test]
fn every_number_has_its_column_where_no_cell_has_it() {
    let of = |cells| {
        let table = csv::cells(&Report { cells, ..report() }).expect("table");
        let names = ::csv::Reader::from_reader(table.as_bytes())
            .headers()
            .cloned();
        names.expect("headers")
    };
    let (none, full) = (of(Vec::new()), of(vec![full()]));
    let of_reconstruction = ["reconstruct", "time_ms.reconstruct.", "files."];
    for name in full
        .iter()
        .filter(|n| !of_reconstruction.iter().any(|t| n.starts_with(t)))
    {
        assert!(none.iter().any(|n| n == name), "{name}");
    }
}

#[test]
fn every_number_of_a_full_record_has_its_row_and_every_row_its_number() {
    let measured = full().result.expect("numbers");
    let mut expected = Vec::new();
    numbers(&json!(measured), "", &mut expected);
    // The keys are camera tracks of the experiment; their numbers are drawn as curves.
    expected.retain(|(name, _)| !name.starts_with("reconstruction.ghosting."));
    for (name, value) in &expected {
        let row = rows().iter().find(|row| row.path == name);
        let row = row.unwrap_or_else(|| panic!("`{name}` has no row"));
        assert_eq!(row.value(&measured), Some(*value), "{name}");
    }
    for row in rows() {
        let known = expected.iter().any(|(name, _)| name == row.path);
        assert!(known, "`{}` is not in the record", row.path);
        assert!(!row.label.is_empty() && row.doc.len() > 20, "{row:?}");
    }
    assert_eq!(rows().len(), expected.len());
}

#[test]
fn every_number_reaches_the_page_or_is_kept_from_it_on_purpose() {
    let dir = tempfile::tempdir().expect("folder");
    let mut report = report();
    let cell = Cell { index: 0, ..full() };
    report.cells.truncate(1);
    report.cells[0].result = cell.result;
    report.cells[0].reconstruct = find("temporal_2x2").expect("registered").info();
    let page = write(dir.path(), &report).expect("report");
    let page = std::fs::read_to_string(page).expect("page");
    let text = |text: &str| maud::html! { (text) }.into_string();
    let measured = report.cells[0].result.as_ref().expect("numbers");
    for row in rows() {
        let heading = format!(">{}", text(row.label));
        let value = row
            .value(measured)
            .map(|value| format::written(row.format, value));
        let value = format!(">{}</td>", value.expect("a full record"));
        match row.shown {
            PagePlace::Cells => {
                assert!(page.contains(&heading) && page.contains(&value), "{row:?}");
                assert!(page.contains(&text(row.doc)), "{row:?} is not defined");
            }
            PagePlace::Decomposition | PagePlace::Reconstruction => {
                assert!(page.contains(&heading) && page.contains(&value), "{row:?}");
            }
            PagePlace::Clock | PagePlace::Nowhere => {}
        }
    }
}

#[test]
fn numbers_that_the_readme_names_exist() {
    let readme = include_str!("../../../README.md");
    let section = readme.split("## What the numbers mean").nth(1);
    let section = section.and_then(|rest| rest.split("\n## ").next());
    let bold = section.expect("the section").split("**").skip(1).step_by(2);
    let names: Vec<&str> = bold.filter(|name| name.contains('_')).collect();
    assert!(names.len() >= 5, "{names:?}");
    for name in names {
        assert!(study_names().any(|known| known == name), "{name}");
    }
}

#[test]
fn what_a_record_may_lack_is_not_named_as_a_failure() {
    let dir = tempfile::tempdir().expect("folder");
    let mut cell = full();
    let lacking = json!(cell.result);
    let mut lacking = lacking.clone();
    for field in fields::measured().iter().filter(|field| field.optional) {
        let place = format!("/{}", field.name.replace('.', "/"));
        if let Some(member) = lacking.pointer_mut(&place) {
            *member = Value::Null;
        }
    }
    cell.result = serde_json::from_value(lacking).expect("all of it is optional");
    let result = cell.result.as_mut().expect("numbers");
    result.error.rel_rmse = f64::NAN;
    let settled = records::settle(
        &Report {
            cells: vec![cell],
            ..report()
        },
        dir.path(),
    );
    let failed = settled.expect("settled").cells[0]
        .failed
        .clone()
        .expect("failed");
    let named = failed
        .split(": ")
        .nth(1)
        .and_then(|rest| rest.split(" (").next());
    assert_eq!(named, Some("error.rel_rmse"), "{failed}");
}

/// A report with a chart of every kind.
fn drawn() -> Report {
    let mut report = report();
    for (i, cell) in report.cells.iter_mut().enumerate().take(2) {
        cell.params.insert("step_m".to_owned(), json!(5 * (i + 1)));
        cell.params.remove("steps");
        let curve = |step_deg, step_m| Ghosting {
            step_deg,
            step_m,
            rel_rmse: vec![0.0, 0.125],
        };
        let numbers = cell.result.as_mut().expect("numbers");
        numbers.reconstruction = Some(ReconstructionNumbers {
            ghosting: BTreeMap::from([
                (CameraTrack::Pan, curve(Some(0.25), None)),
                (CameraTrack::Dolly, curve(None, Some(12.5))),
            ]),
            ..ReconstructionNumbers::default()
        });
    }
    report
}

#[test]
fn a_chart_of_any_kind_goes_when_its_records_do() {
    let dir = tempfile::tempdir().expect("folder");
    let report = drawn();
    super::fixture::paint(dir.path(), &report, usize::MAX);
    write(dir.path(), &report).expect("report");
    let names = || -> Vec<String> {
        let entries = std::fs::read_dir(dir.path().join("charts")).expect("charts");
        let name = |e: std::fs::DirEntry| e.file_name().to_string_lossy().into_owned();
        entries.flatten().map(name).collect()
    };
    let kinds: Vec<&str> = charts::kinds().chain([contact::KIND]).collect();
    for kind in &kinds {
        assert!(
            names().iter().any(|n| n.starts_with(kind)),
            "no chart is {kind}"
        );
    }
    let own = dir.path().join("charts/mine.svg");
    std::fs::write(&own, "somebody's own").expect("file");
    let empty = Report {
        cells: Vec::new(),
        references: Vec::new(),
        ..report
    };
    write(dir.path(), &empty).expect("report");
    assert_eq!(
        names(),
        ["mine.svg"],
        "stale charts, or somebody's own gone"
    );
}
