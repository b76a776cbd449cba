//! Reports: writes `report.json`, `cells.csv`, charts, contact sheets and the page from the records of a batch.
//!
//! [`write()`] needs nothing but the records and the pictures that they name, so a folder can be rebuilt from
//! `report.json` at any time, byte for byte the same:
//!
//! ```text
//! Report ─► records::settle ─► report.json
//!                  │─► csv    ─► cells.csv
//!                  └─► view   ─► charts  ─► charts/*.svg ─┐
//!                        ├──────► contact ─► charts/*.png ─┤
//!                        └──────► page   ◄─────────────────┘─► shell ─► index.html (one file, no network)
//! ```
//!
//! plotters is used only in this module, maud only here and in the pages of `study`. The pictures that the records name
//! are read from inside the folder and never written.

pub(crate) mod charts;
mod contact;
mod csv;
pub(crate) mod fields;
pub(crate) mod files;
pub mod format;
pub(crate) mod page;
mod pareto;
mod records;
pub(crate) mod shell;
mod shown;
mod stability;
pub mod style;
pub(crate) mod view;

#[cfg(test)]
mod complete_tests;
#[cfg(test)]
pub(crate) mod fixture;
#[cfg(test)]
mod temporal_tests;
#[cfg(test)]
mod tests;

use crate::batch::record::Report;
use crate::error::{Error, Result};
use crate::probe::Probe;
use std::path::{Path, PathBuf};

pub use pareto::frontier;
pub use stability::write as write_stability;
pub use style::{Marker, Style};

/// Writes `report.json`, `cells.csv`, `charts/*.svg`, the contact sheets `charts/methods-*.png` and `index.html` into
/// `folder`; returns the path of the page.
///
/// Each file is replaced atomically, so a reader never sees a partly written one. Charts and sheets of an earlier
/// report for which the records no longer have data are removed.
pub fn write(folder: &Path, report: &Report) -> Result<PathBuf> {
    let report = records::settle(report, folder)?;
    let json = folder.join("report.json");
    files::write(&json, records::text(&report, &json)?.as_bytes())?;
    files::write(&folder.join("cells.csv"), csv::cells(&report)?.as_bytes())?;
    let shown = shown::shown(&report);
    let view = view::ReportView::new(&shown);
    let charts = charts::all(&view)?;
    let sheets = contact::all(folder, &view)?;
    let figures = charts
        .iter()
        .map(|c| (c.file.as_str(), c.svg.as_bytes()))
        .chain(sheets.iter().map(|s| (s.file.as_str(), s.png.as_slice())));
    let kinds: Vec<&str> = charts::kinds().chain([contact::KIND]).collect();
    files::replace_all(&folder.join("charts"), &kinds, figures)?;
    let page = folder.join("index.html");
    files::write(
        &page,
        page::html(folder, &view, &charts, &sheets).as_bytes(),
    )?;
    Ok(page)
}

/// Writes the chart of `probe` to `svg` and its table beside it as `.csv`; see [`Probe`]. `of` names scene and column,
/// `seen_m` is the depth of the pixel's point in the column, m, if a pixel was asked for.
pub fn write_probe(svg: &Path, probe: &Probe, of: &str, seen_m: Option<f64>) -> Result<()> {
    files::write(&svg.with_extension("csv"), probe.csv().as_bytes())?;
    let chart = charts::probe::chart(probe, of, seen_m).svg()?;
    let chart = chart.ok_or_else(|| Error::defect("probe", "the column has no depths"))?;
    files::write(svg, chart.as_bytes())
}
