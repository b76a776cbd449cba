//! Report with the reconstruction of each cell as one of its parameters, for charts and page.

use crate::batch::record::Report;
use serde_json::json;
use std::borrow::Cow;

/// Name of that parameter.
pub const RECONSTRUCT: &str = "reconstruct";

/// The report with [`RECONSTRUCT`] added to the parameters of cells where it is not `full`, so that it appears in the
/// names of settings; unchanged where all cells are `full`.
pub fn shown(report: &Report) -> Cow<'_, Report> {
    if report.cells.iter().all(|cell| cell.reconstruct.is_full()) {
        return Cow::Borrowed(report);
    }
    let mut shown = report.clone();
    for cell in shown.cells.iter_mut().filter(|c| !c.reconstruct.is_full()) {
        let value = json!(cell.reconstruct);
        cell.params.insert(RECONSTRUCT.to_owned(), value);
    }
    Cow::Owned(shown)
}
