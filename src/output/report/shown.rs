//! The records as charts and page show them.

use crate::batch::record::Report;
use serde_json::json;
use std::borrow::Cow;

/// Name under which it stands there.
pub const RECONSTRUCT: &str = "reconstruct";

/// The report with [`RECONSTRUCT`] among the parameters of cells where it is not `full`: so it stands wherever settings are
/// told apart, and nowhere when no cell has it.
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
