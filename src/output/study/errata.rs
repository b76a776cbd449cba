//! Defects of the source, each with the number that shows it.

use super::claims::CellLink;
use super::select::{Found, Records};
use crate::batch::record::{Cell, Report};
use crate::config::{Erratum, Evidence};
use crate::frame::{Frame, read_frame};
use crate::metrics::relative_rmse;
use crate::report::format::number;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

/// A defect of the source with the numbers that show it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErratumFinding {
    /// Place in the source.
    pub place: String,
    /// The printed text or formula.
    pub printed: String,
    /// The intended text or formula.
    pub meant: String,
    /// The number in words, or why there is none.
    pub numbers: String,
    /// False where the number could not be measured.
    pub measured: bool,
    /// Cells that the number comes from.
    pub cells: Vec<CellLink>,
}

/// Measures a defect. The report of experiment ID is in `folder`/ID.
pub fn show(records: &Records<'_>, folder: &Path, erratum: &Erratum) -> ErratumFinding {
    let found = match &erratum.evidence {
        Evidence::Number {
            published,
            unit,
            per,
            measured,
        } => records.quantity(measured).map(|(value, cells)| {
            let own = value.interval.value / per;
            let text = format!(
                "printed {} {unit}, measured {} {unit}: {} times as much",
                number(*published),
                number(own),
                number(published / own)
            );
            (text, cells)
        }),
        Evidence::Cells { printed, meant } => as_printed(records, printed, meant),
        Evidence::Truths {
            experiment,
            printed,
            meant,
            limit,
        } => truths(records, folder, experiment, [printed, meant, limit]),
        Evidence::Text { one, other, unit } => {
            let text = format!(
                "{} {unit} in one place, {} {unit} in the other: {} times as much",
                number(*one),
                number(*other),
                number(other / one)
            );
            Ok((text, Vec::new()))
        }
    };
    let measured = found.is_ok();
    let (numbers, cells) = found.unwrap_or_else(|reason| (format!("no number: {reason}"), vec![]));
    ErratumFinding {
        place: erratum.place.clone(),
        printed: erratum.printed.clone(),
        meant: erratum.meant.clone(),
        numbers,
        measured,
        cells: cells.iter().map(CellLink::from).collect(),
    }
}

type Numbers<'a> = Result<(String, Vec<Found<'a>>), String>;

fn as_printed<'a>(
    records: &Records<'a>,
    printed: &crate::config::Quantity,
    meant: &crate::config::Quantity,
) -> Numbers<'a> {
    let (wrong, mut cells) = records.quantity(printed)?;
    let (right, more) = records.quantity(meant)?;
    cells.extend(more);
    let (wrong, right) = (wrong.interval.value, right.interval.value);
    let text = format!("{} {}", printed.metric, comparison(wrong, right));
    Ok((text, cells))
}

/// Largest relative difference of two errors that count as equal.
const SAME: f64 = 0.05;

/// Text on two errors, as printed and as meant: their ratio, and whether the misprint increases the error.
fn comparison(wrong: f64, right: f64) -> String {
    let factor = wrong / right;
    let harm = match factor {
        f if f > 1.0 + SAME => "",
        f if f < 1.0 - SAME => "; here the misprint errs less",
        _ => "; no harm here",
    };
    format!(
        "{} as printed, {} as meant: {} times{harm}",
        number(wrong),
        number(right),
        number(factor)
    )
}

/// Errors of two truths (as printed, as meant) against a third one of more view steps, from their EXR pictures.
fn truths<'a>(
    records: &Records<'a>,
    folder: &Path,
    experiment: &str,
    [printed, meant, limit]: [&Map<String, Value>; 3],
) -> Numbers<'a> {
    let (id, report) = records.report(experiment)?;
    let open = |set| truth((id, report), &folder.join(id), set);
    let ((wrong, a), (right, b), (limit, c)) = (open(printed)?, open(meant)?, open(limit)?);
    let error = |frame: &Frame| relative_rmse(&limit, &limit, frame).map_err(|e| e.to_string());
    let text = format!(
        "rel_rmse of the truth itself from a truth of many more view steps {}",
        comparison(error(&wrong)?, error(&right)?)
    );
    Ok((text, vec![a, b, c]))
}

/// Truth picture of the view with these scene members, and the first cell of that view.
fn truth<'a>(
    (experiment, report): (&'a str, &'a Report),
    folder: &Path,
    set: &Map<String, Value>,
) -> Result<(Frame, Found<'a>), String> {
    let missing = || format!("there is no truth at {}", Value::from(set.clone()));
    let fits = |cell: &'a Cell| {
        let numbers = cell.result.as_ref()?;
        let fits = set.iter().all(|(k, v)| cell.scene_set.get(k) == Some(v));
        fits.then_some(Found {
            experiment,
            report,
            cell,
            numbers,
        })
    };
    let found = report.cells.iter().find_map(fits).ok_or_else(missing)?;
    let mut references = report.references.iter();
    let reference = references.find(|r| r.id == found.numbers.reference);
    let file = reference.and_then(|r| r.files.get("exr")?.as_str());
    let path = crate::report::files::inside(folder, file.ok_or_else(missing)?)?;
    let frame = read_frame(&path).map_err(|e| e.to_string())?;
    Ok((frame, found))
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{FixtureReport, quantity};
    use super::*;
    use serde_json::json;

    #[test]
    fn a_misprint_is_held_against_what_is_meant_and_may_do_no_harm() {
        let mut made = FixtureReport::new(&["a"]);
        for (steps, error) in [(1, 0.6), (2, 0.2), (3, 0.205)] {
            let cell = made.cell("a", json!({"steps": steps}), &[1.0]);
            if let Some(result) = &mut cell.result {
                result.error.rel_rmse = error;
            }
        }
        let said = |printed, meant| {
            let erratum = Erratum {
                place: "somewhere".to_owned(),
                printed: "a".to_owned(),
                meant: "b".to_owned(),
                evidence: Evidence::Cells {
                    printed: Box::new(quantity("rel_rmse", "a", printed)),
                    meant: Box::new(quantity("rel_rmse", "a", meant)),
                },
            };
            show(&made.records(), Path::new("nowhere"), &erratum)
        };
        let harm = said(1, 2);
        assert!(harm.measured && harm.cells.len() == 2);
        assert!(
            harm.numbers
                .ends_with("0.600 as printed, 0.200 as meant: 3.00 times"),
            "{}",
            harm.numbers
        );
        assert!(said(2, 1).numbers.ends_with("the misprint errs less"));
        assert!(said(3, 2).numbers.ends_with("no harm here"));
        assert!(!said(9, 2).measured);
    }
}
