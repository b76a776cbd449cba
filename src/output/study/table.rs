//! Fills the tables of the source with the values measured here beside the published ones.

use super::charts::relative;
use super::claims::CellLink;
use super::interval::Interval;
use super::select::{self, Records};
use crate::config::{Pick, TableRow, TableSpec};
use serde::Serialize;

/// A table of the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Name of the published table.
    pub figure: String,
    /// Heading.
    pub title: String,
    /// Experiment that the cells are from.
    pub experiment: String,
    /// Label of the series whose total time is 1, where ratios are shown.
    pub relative_to: Option<String>,
    /// A line on how to read it.
    pub note: String,
    /// Name and title of each number, one a column.
    pub metrics: Vec<(String, String)>,
    /// Rows in order.
    pub rows: Vec<CellRow>,
}

/// One row: a cell of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellRow {
    /// The cell in words.
    pub label: String,
    /// One entry for each number, in the order of [`Table::metrics`].
    pub entries: Vec<Entry>,
    /// Reference to the cell; `None` where it was not found.
    pub cell: Option<CellLink>,
    /// Reasons for missing numbers.
    pub missing: Vec<String>,
}

/// A number as published and as measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Entry {
    /// Published value, in the unit of the number's name.
    pub published: Option<f64>,
    /// Published value over the source's own unit.
    pub published_ratio: Option<f64>,
    /// Value measured here, in the unit of the number's name.
    pub here: Option<Interval>,
    /// Value measured here over the total time of [`Table::relative_to`] in the same picture, round by round where they
    /// share rounds.
    pub ratio: Option<Interval>,
}

/// Fills a table.
pub fn fill(records: &Records<'_>, spec: &TableSpec) -> Table {
    let label = |name: &String| records.label(name).to_owned();
    let metrics = spec.metrics.iter();
    Table {
        figure: spec.figure.clone(),
        title: spec.title.clone(),
        experiment: spec.experiment.clone(),
        relative_to: spec.relative_to.as_ref().map(label),
        note: spec.note.clone(),
        metrics: metrics
            .map(|m| (m.metric.clone(), m.title.clone()))
            .collect(),
        rows: spec.rows.iter().map(|r| row(records, spec, r)).collect(),
    }
}

fn row(records: &Records<'_>, spec: &TableSpec, row: &TableRow) -> CellRow {
    let pick = Pick {
        experiment: spec.experiment.clone(),
        series: row.series.clone(),
        at: row.at.clone(),
    };
    let found = records.find(&pick);
    let mut missing: Vec<String> = found.as_ref().err().cloned().into_iter().collect();
    let mut entries = Vec::new();
    for column in &spec.metrics {
        let published = row.published.get(&column.metric).copied();
        let mut entry = Entry {
            published,
            published_ratio: published.and_then(|p| Some(p / spec.unit?)),
            ..Entry::default()
        };
        // A method without a map has no map pass: the field is empty and not listed as missing.
        if let Ok(found) = &found
            && (found.numbers.memory.map_bytes > 0 || column.metric != "generate_ms")
        {
            let mut take = |value: Result<Interval, String>| match value {
                Ok(value) => Some(value),
                Err(reason) => {
                    missing.push(reason);
                    None
                }
            };
            entry.here = take(select::metric(found, &column.metric).map(|v| v.interval));
            entry.ratio = spec
                .relative_to
                .as_ref()
                .and_then(|unit| take(relative(records, found, unit, &column.metric)));
        }
        entries.push(entry);
    }
    CellRow {
        label: records.words(&pick),
        entries,
        cell: found.as_ref().ok().map(CellLink::from),
        missing,
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::FixtureReport;
    use super::*;
    use serde_json::json;

    #[test]
    fn published_and_measured_numbers_stand_side_by_side() {
        let mut made = FixtureReport::new(&["srm", "esm"]);
        let srm = made.cell("srm", json!({"steps": 10}), &[10.0, 20.0, 40.0]);
        if let Some(result) = &mut srm.result {
            result.memory.map_bytes = 0;
        }
        made.cell("esm", json!({"steps": 50}), &[5.0, 10.0, 20.0]);
        let spec: TableSpec = serde_json::from_value(json!({
            "id": "t", "figure": "Table 1", "title": "T", "experiment": "e", "relative_to": "srm", "unit": 4.0, "note": "",
            "metrics": [{"metric": "total_ms", "title": "total"}, {"metric": "generate_ms", "title": "map pass"}],
            "rows": [
                {"series": "srm", "published": {"total_ms": 4.0}},
                {"series": "esm", "at": {"steps": 50}, "published": {"total_ms": 3.0}},
                {"series": "esm", "at": {"steps": 51}, "published": {"total_ms": 3.0}}
            ]
        }))
        .unwrap();
        let table = fill(&made.records(), &spec);
        let [srm, esm, none] = &table.rows[..] else {
            panic!("three rows");
        };
        assert_eq!(srm.entries[1], Entry::default(), "no map, no map pass");
        assert!(srm.missing.is_empty(), "{:?}", srm.missing);
        let [total, pass] = esm.entries[..] else {
            panic!("two numbers");
        };
        assert_eq!(
            (total.published, total.published_ratio),
            (Some(3.0), Some(0.75))
        );
        assert_eq!(total.here.unwrap().value, 10.0);
        assert_eq!(total.ratio, Some(Interval::exact(0.5)), "round by round");
        assert_eq!(pass.ratio, Some(Interval::exact(0.25)));
        assert!(none.cell.is_none() && none.missing[0].contains("0 cells fit"));
    }
}
