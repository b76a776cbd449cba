//! Records → csv, charts, page.
//!
//! [`write`] rebuilds a report folder from its records alone, so a folder can be remade from `report.json` at any time
//! and comes out byte for byte the same:
//!
//! ```text
//! Report ─► records::settle ─► report.json
//!                  │─► csv    ─► cells.csv
//!                  └─► view   ─► charts ─► charts/*.svg ─┐
//!                        └──────► page  ◄────────────────┘─► index.html (one file, no network)
//! ```
//!
//! Nothing outside this module names plotters or maud. Pictures are only read: they are the files that the records
//! name, inside the folder.

mod charts;
mod csv;
mod files;
mod format;
mod page;
mod pareto;
mod records;
mod style;
mod view;

#[cfg(test)]
mod fixture;
#[cfg(test)]
mod tests;

use crate::batch::record::Report;
use crate::error::Result;
use std::path::{Path, PathBuf};

pub use pareto::frontier;
pub use style::{Marker, Style};

/// Writes `report.json`, `cells.csv`, `charts/*.svg` and `index.html` into `folder`; returns the path of the page.
///
/// Each file is replaced in one step, so a reader never sees half of one. Charts of an earlier report that the records
/// no longer support are removed.
pub fn write(folder: &Path, report: &Report) -> Result<PathBuf> {
    let report = records::settle(report, folder)?;
    write_settled_json(folder, &report)?;
    files::write(&folder.join("cells.csv"), csv::cells(&report)?.as_bytes())?;
    let view = view::View::new(&report);
    let charts = charts::all(&view)?;
    charts::write(&folder.join("charts"), &charts)?;
    let page = folder.join("index.html");
    files::write(&page, page::html(folder, &view, &charts).as_bytes())?;
    Ok(page)
}

/// Writes `report.json` alone: what a batch does after each cell.
///
/// A cell whose numbers are not finite (JSON has none such) is written as a failed cell that names them, so that the
/// file can always be read again.
pub fn write_json(folder: &Path, report: &Report) -> Result<PathBuf> {
    write_settled_json(folder, &records::settle(report, folder)?)
}

fn write_settled_json(folder: &Path, report: &Report) -> Result<PathBuf> {
    let path = folder.join("report.json");
    files::write(&path, records::text(report, &path)?.as_bytes())?;
    Ok(path)
}
