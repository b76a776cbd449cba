//! Defects of the source, each with the number that shows it.

use super::claims::CellLink;
use super::select::{Found, Records};
use crate::batch::record::Report;
use crate::config::{Erratum, Evidence};
use crate::frame::{Frame, read_frame};
use crate::metrics::relative_rmse;
use crate::report::format::number;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

/// A defect and what was found of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shown {
    /// Where it stands.
    pub place: String,
    /// What is printed.
    pub printed: String,
    /// What is meant.
    pub meant: String,
    /// The number in words, or why there is none.
    pub numbers: String,
    /// Whether there is a number.
    pub measured: bool,
    /// Cells it comes from.
    pub cells: Vec<CellLink>,
}

/// Measures a defect. Reports lie in `folder`/ID.
pub fn show(records: &Records<'_>, folder: &Path, erratum: &Erratum) -> Shown {
    let found = match &erratum.evidence {
        Evidence::Number {
            published,
            unit,
            per,
            measured,
        } => records.quantity(measured).map(|(value, cells)| {
            let own = value.value / per;
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
    Shown {
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
    let factor = wrong
        .over(right)
        .map_or(String::new(), |f| format!(": {} times", number(f.value)));
    let text = format!(
        "{} {} as printed, {} as meant{factor}",
        printed.metric,
        number(wrong.value),
        number(right.value)
    );
    Ok((text, cells))
}

/// Two truths against a third, by their pictures.
fn truths<'a>(
    records: &Records<'a>,
    folder: &Path,
    experiment: &str,
    [printed, meant, limit]: [&Map<String, Value>; 3],
) -> Numbers<'a> {
    let (id, report) = records.report(experiment)?;
    let open = |set| truth(report, &folder.join(id), set);
    let (wrong, right, limit) = (open(printed)?, open(meant)?, open(limit)?);
    let error = |frame: &Frame| relative_rmse(&limit, &limit, frame).map_err(|e| e.to_string());
    let (wrong, right) = (error(&wrong)?, error(&right)?);
    let text = format!(
        "rel_rmse of the truth from its own limit {} as printed, {} as meant: {} times",
        number(wrong),
        number(right),
        number(wrong / right)
    );
    Ok((text, Vec::new()))
}

/// The truth of the view that has these scene members.
fn truth(report: &Report, folder: &Path, set: &Map<String, Value>) -> Result<Frame, String> {
    let fits = |name: &&str| {
        report.cells.iter().any(|cell| {
            cell.result.as_ref().is_some_and(|r| r.reference == **name)
                && set.iter().all(|(k, v)| cell.scene_set.get(k) == Some(v))
        })
    };
    let mut names = report.references.iter().map(|r| r.id.as_str());
    let name = names.find(fits);
    let reference = report
        .references
        .iter()
        .find(|r| Some(r.id.as_str()) == name);
    let file = reference.and_then(|r| r.files.get("exr")?.as_str());
    let file = file.ok_or_else(|| format!("there is no truth at {}", Value::from(set.clone())))?;
    let path = crate::report::files::inside(folder, file)?;
    read_frame(&path).map_err(|e| e.to_string())
}
