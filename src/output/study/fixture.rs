//! Synthetic records for the tests of this folder.

use super::select::Records;
use crate::batch::record::{Cell, Report};
use crate::config::{Pick, Quantity, Series};
use crate::metrics::summarise;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// A report that cells are added to.
pub struct FixtureReport {
    pub reports: Vec<(String, Report)>,
    pub series: BTreeMap<String, Series>,
}

impl FixtureReport {
    /// One empty experiment `e`; each of `methods` is a series of that name.
    pub fn new(methods: &[&str]) -> Self {
        let mut report = crate::report::fixture::report();
        report.cells.clear();
        let series = |method: &&str| {
            let series = Series {
                method: (*method).to_owned(),
                at: Map::new(),
                label: None,
            };
            ((*method).to_owned(), series)
        };
        Self {
            reports: vec![("e".to_owned(), report)],
            series: methods.iter().map(series).collect(),
        }
    }

    /// Adds a cell with these total times per round, ms; the map pass takes half of each. All cells share a view.
    pub fn cell(&mut self, method: &str, params: Value, rounds: &[f64]) -> &mut Cell {
        let mut cell = crate::report::fixture::report().cells[8].clone();
        let report = &mut self.reports[0].1;
        cell.index = report.cells.len();
        cell.method = method.to_owned();
        cell.params = params.as_object().cloned().unwrap_or_default();
        if let Some(result) = &mut cell.result {
            let halves: Vec<f64> = rounds.iter().map(|t| 0.5 * t).collect();
            result.rounds_total_ms = rounds.iter().copied().map(Some).collect();
            result.rounds_generate_ms = halves.iter().copied().map(Some).collect();
            result.time_ms.total = summarise(rounds);
            result.time_ms.generate = summarise(&halves);
        }
        report.cells.push(cell);
        let last = report.cells.len() - 1;
        &mut report.cells[last]
    }

    /// The records.
    pub fn records(&self) -> Records<'_> {
        Records {
            reports: &self.reports,
            series: &self.series,
        }
    }
}

/// Pick of a series' cells in the experiment `e`.
pub fn pick(series: &str, at: Value) -> Pick {
    Pick {
        experiment: "e".to_owned(),
        series: series.to_owned(),
        at: at.as_object().cloned().unwrap_or_default(),
    }
}

/// Number `metric` of the series' cell with this many `steps`.
pub fn quantity(metric: &str, series: &str, steps: u32) -> Quantity {
    Quantity {
        metric: metric.to_owned(),
        of: pick(series, json!({"steps": steps})),
        minus: None,
    }
}
