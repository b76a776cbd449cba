//! Studies: reproductions of a published comparison. A study file names experiments and is checked against their
//! matrices; their records give the verdicts on its claims, its tables, errata, cost model and guide.
//!
//! ```text
//! config::Study ─► check ─► run ─► batch, one folder each ─► Records ─┬► claims ─┐
//!                                                                     ├► tables  │
//!                                                                     ├► errata  │
//!                                                                     ├► cost    ├► study.json, index.html, guide.html
//!                                                                     ├► charts  │
//!                                                                     └► guide ──┘
//! ```
//!
//! No study is named in this code: the experiments and claims of each are in `configs/studies/NAME.json`.

mod charts;
mod check;
pub mod claims;
pub mod cost_model;
pub mod errata;
#[cfg(test)]
mod fixture;
pub mod guide;
mod interval;
mod least_squares;
mod page;
mod paired;
mod run;
pub mod select;
pub mod table;

pub use interval::Interval;
pub use run::{StudyEvent, StudyProgress, run};

use crate::batch::record::{Clock, Report};
use crate::config::Study;
use crate::error::{Error, Result};
use claims::Claim;
use cost_model::CostModel;
use errata::ErratumFinding;
use guide::Answer;
use select::Records;
use serde::Serialize;
use std::path::{Path, PathBuf};
use table::Table;

/// Folder of the experiments' reports below a study's folder.
pub const EXPERIMENTS: &str = "experiments";

/// Results of a study, the content of `study.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Name of the study.
    pub study: String,
    /// Profile of the study that was run.
    pub profile: String,
    /// Adapter on which all times were measured.
    pub adapter: String,
    /// Clock of the times: `total` or `wall`.
    pub clock: String,
    /// Claims with their verdicts.
    pub claims: Vec<Claim>,
    /// Tables of the source with the values measured here.
    pub tables: Vec<Table>,
    /// Defects of the source with their numbers.
    pub errata: Vec<ErratumFinding>,
    /// Fitted time per sample; `null` where no cell has times.
    pub cost_model: Option<CostModel>,
    /// Answers of the guide.
    pub guide: Vec<Answer>,
    /// Wall-clock time of the experiments, s, summed over resumed runs.
    pub wall_s: f64,
    /// Number of cells of all experiments.
    pub cells: usize,
    /// Number of cells that failed.
    pub failed: usize,
}

/// Evaluates the study on its reports and writes `study.json`, charts, `index.html` and `guide.html` into `folder`,
/// where the reports are below [`EXPERIMENTS`]. Returns the outcome and the path of the page.
pub fn conclude(
    study: &Study,
    reports: &[(String, Report)],
    folder: &Path,
) -> Result<(Outcome, PathBuf)> {
    let records = Records {
        reports,
        series: &study.series,
    };
    let outcome = outcome(study, &records, folder);
    let json = folder.join("study.json");
    let text = serde_json::to_vec_pretty(&outcome).map_err(|e| Error::writing(&json)(e.into()))?;
    crate::report::files::write(&json, &text)?;
    let figures = charts::all(study, &records, &outcome)?;
    let files = figures.iter().map(|f| (f.file.as_str(), f.svg.as_bytes()));
    let charts = folder.join("charts");
    crate::report::files::replace_all(&charts, &[charts::FIGURE, charts::COST], files)?;
    let page = page::write(folder, study, &records, &outcome, &figures)?;
    Ok((outcome, page))
}

fn outcome(study: &Study, records: &Records<'_>, folder: &Path) -> Outcome {
    let reports = || records.reports.iter().map(|(_, report)| report);
    let first = reports().next();
    let cells = || reports().flat_map(|report| &report.cells);
    let decide = |spec| claims::decide(records, spec);
    let show = |erratum| errata::show(records, &folder.join(EXPERIMENTS), erratum);
    Outcome {
        study: study.name.clone(),
        profile: study.profile.clone(),
        adapter: first.map(adapter).unwrap_or_default(),
        clock: first.map_or(Clock::Device, Report::clock).name().to_owned(),
        claims: study.claims.iter().map(decide).collect(),
        tables: study
            .tables
            .iter()
            .map(|t| table::fill(records, t))
            .collect(),
        errata: study.errata.iter().map(show).collect(),
        cost_model: cost_model::fit(records),
        guide: study
            .guide
            .iter()
            .map(|question| guide::answer(records, question))
            .collect(),
        wall_s: reports().map(|report| report.wall.total_s).sum(),
        cells: cells().count(),
        failed: cells().filter(|cell| cell.result.is_none()).count(),
    }
}

/// Name and kind of the adapter, for the captions of tables.
fn adapter(report: &Report) -> String {
    let e = &report.environment;
    if e.is_oracle() {
        return format!("{}, {}", e.adapter, e.driver);
    }
    format!("{} ({}, {})", e.adapter, e.device_type, e.backend)
}
