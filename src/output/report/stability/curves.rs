//! Charts of transmittance T(d) along columns where a method breaks or rings.

use super::super::charts::axis::AxisSpec;
use super::super::charts::chart::{
    Chart, DASHED, DOTTED, Dash, Data, Look, Plane, Point, PointSeries, SOLID,
};
use super::super::shell::parts;
use super::super::style::Style;
use super::heat::label;
use crate::error::Result;
use crate::stability::{FormVerdict, Sweep, SweepCase, SweepRow};
use maud::{Markup, html};

/// T at the upper edge of a chart.
const UPPER: f64 = 1.05;

/// A drawn chart and what it shows.
pub struct CurveDrawing {
    title: String,
    svg: String,
}

/// Charts of the worst curves of every method and form: one for each verdict (breaks, rings), apart with and without
/// values that are not finite.
pub fn charts(sweep: &Sweep) -> Result<Vec<CurveDrawing>> {
    let mut picked: Vec<(&SweepCase, &SweepRow, bool, f64)> = Vec::new();
    for case in &sweep.cases {
        for row in &case.rows {
            let notable = matches!(
                row.flushed.verdict,
                FormVerdict::Breaks | FormVerdict::Rings
            );
            if !notable || row.setting.storage == "-" || row.curve.is_empty() {
                continue;
            }
            let holes = row.curve.iter().any(Option::is_none);
            let entry = (case, row, holes, badness(case, row));
            let key = |(_, r, h, _): &(&SweepCase, &SweepRow, bool, f64)| {
                let s = &r.setting;
                (s.method.clone(), s.form.clone(), *h, r.flushed.verdict)
            };
            match picked.iter_mut().find(|p| key(p) == key(&entry)) {
                Some(known) if known.3 < entry.3 => *known = entry,
                Some(_) => {}
                None => picked.push(entry),
            }
        }
    }
    picked.retain(|(_, _, _, badness)| *badness > 1e-3);
    picked.sort_by_key(|(_, row, holes, _)| {
        let s = &row.setting;
        (
            s.method.clone(),
            s.form.clone(),
            !holes,
            row.flushed.verdict,
        )
    });
    let draw = |(case, row, _, _): &(&SweepCase, &SweepRow, bool, f64)| {
        let chart = chart(sweep, case, row);
        let title = format!("{}, {}", chart.title, chart.of);
        Ok(chart.svg()?.map(|svg| CurveDrawing { title, svg }))
    };
    picked
        .iter()
        .filter_map(|entry| draw(entry).transpose())
        .collect()
}

/// Size of the defect in the drawn column: the largest rise of T for a curve that rings, else mean |T − truth|, where a
/// value that is not finite counts 1.
fn badness(case: &SweepCase, row: &SweepRow) -> f64 {
    if row.flushed.verdict == FormVerdict::Rings {
        let mut lowest = f32::INFINITY;
        let rises = row.curve.iter().flatten().map(|t| {
            lowest = lowest.min(*t);
            t - lowest
        });
        return rises.fold(0.0, f32::max).into();
    }
    let errors = row.curve.iter().zip(&case.truth);
    let sum: f64 = errors
        .map(|(t, truth)| t.map_or(1.0, |t| (f64::from(t) - truth).abs()))
        .sum();
    sum / case.truth.len().max(1) as f64
}

fn chart(sweep: &Sweep, case: &SweepCase, row: &SweepRow) -> Chart {
    let truth = PointSeries {
        label: "truth".to_owned(),
        style: Style::of("truth"),
        look: Look::Bare(SOLID, 3),
        points: points(case, case.truth.iter().copied()),
    };
    let curve = |row: &SweepRow, dash: Dash| PointSeries {
        label: label(&row.setting),
        style: Style::of(&row.setting.method),
        look: Look::Bare(dash, 2),
        points: points(
            case,
            row.curve.iter().map(|t| t.map_or(f64::NAN, f64::from)),
        ),
    };
    let stable = stable(case, row).map(|stable| curve(stable, DOTTED));
    Chart {
        title: format!("T along a column: {}", label(&row.setting)),
        of: format!("{}: {}", case.group, case.name),
        data: Data::Plane(Plane {
            x: AxisSpec::up_to("depth, share of the column", UPPER),
            y: AxisSpec::up_to("T", UPPER),
            series: [Some(truth), stable, Some(curve(row, DASHED))]
                .into_iter()
                .flatten()
                .collect(),
            levels: Vec::new(),
            places: Vec::new(),
        }),
        source: String::new(),
        note: format!(
            "On the oracle, rounded as the storage does, denormals flushed. Profile {}.",
            sweep.profile
        ),
    }
}

fn points(case: &SweepCase, values: impl Iterator<Item = f64>) -> Vec<Point> {
    let pairs = case.depths.iter().zip(values);
    pairs.map(|(depth, t)| Point::at(*depth, t)).collect()
}

/// Row of the stable form at the same setting as a row of the published form, where there is one.
fn stable<'a>(case: &'a SweepCase, row: &SweepRow) -> Option<&'a SweepRow> {
    if row.setting.form != "published" {
        return None;
    }
    let mut stable = row.setting.clone();
    stable.form = "stable".to_owned();
    case.rows.iter().find(|other| other.setting == stable)
}

/// The section.
pub fn section(charts: &[CurveDrawing]) -> Markup {
    html! {
        section #curves {
            h2 { "Where something breaks or rings" }
            p { "Of each method and form the extreme that shows it most; the first light column of the case." }
            @if charts.is_empty() { p { "Nothing does." } }
            div.charts { @for chart in charts { (parts::chart(&chart.title, &chart.svg, None)) } }
        }
    }
}
