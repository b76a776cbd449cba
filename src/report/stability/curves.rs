//! Curves T(d) where something breaks or rings.

use super::super::charts::WIDTH;
use super::super::charts::extremes::{Curve, draw};
use super::heat::label;
use crate::error::Result;
use crate::stability::{Case, Row, Sweep, Verdict};
use maud::{Markup, PreEscaped, html};

/// A chart and what it shows.
pub struct Chart {
    title: String,
    svg: String,
}

/// The worst curves of every method and form: one that rings, one that breaks, one with values that are not finite.
pub fn charts(sweep: &Sweep) -> Result<Vec<Chart>> {
    let mut picked: Vec<(&Case, &Row, bool, f64)> = Vec::new();
    for case in &sweep.cases {
        for row in &case.rows {
            let notable = matches!(row.flushed.verdict, Verdict::Breaks | Verdict::Rings);
            if !notable || row.setting.storage == "-" || row.curve.is_empty() {
                continue;
            }
            let holes = row.curve.iter().any(Option::is_none);
            let entry = (case, row, holes, badness(case, row));
            let key = |(_, r, h, _): &(&Case, &Row, bool, f64)| {
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
    picked
        .iter()
        .map(|(case, row, _, _)| chart(sweep, case, row))
        .collect()
}

/// How much the drawn column shows: the largest rise of a curve that rings, else mean |T − truth|, where what is not
/// finite counts 1.
fn badness(case: &Case, row: &Row) -> f64 {
    if row.flushed.verdict == Verdict::Rings {
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

fn chart(sweep: &Sweep, case: &Case, row: &Row) -> Result<Chart> {
    let what = format!("T along a column: {}", label(&row.setting));
    let of = format!("{}: {}", case.group, case.name);
    let depths = || case.depths.iter().copied();
    let mut curves = vec![Curve {
        label: "truth".to_owned(),
        method: "truth".to_owned(),
        pattern: &[],
        points: depths().zip(case.truth.iter().copied().map(Some)).collect(),
    }];
    let mut add = |row: &Row, pattern| {
        let points = row.curve.iter().map(|t| t.map(f64::from));
        curves.push(Curve {
            label: label(&row.setting),
            method: row.setting.method.clone(),
            pattern,
            points: depths().zip(points).collect(),
        });
    };
    if row.setting.form == "published" {
        let mut stable = row.setting.clone();
        stable.form = "stable".to_owned();
        if let Some(stable) = case.rows.iter().find(|other| other.setting == stable) {
            add(stable, &[2.0, 3.0]);
        }
    }
    add(row, &[8.0, 4.0]);
    let formats = "On the oracle, rounded as the storage does, denormals flushed.";
    let note = format!("{formats} Profile {}.", sweep.profile);
    let svg = draw(&what, &of, &note, &curves)?;
    Ok(Chart {
        title: format!("{what}, {of}"),
        svg,
    })
}

/// The section.
pub fn section(charts: &[Chart]) -> Markup {
    html! {
        section #curves {
            h2 { "Where something breaks or rings" }
            p { "Of each method and form the extreme that shows it most; the first light column of the case." }
            @if charts.is_empty() { p { "Nothing does." } }
            div.charts { @for chart in charts {
                figure.chart {
                    div.scroll tabindex="0" role="img" aria-label=(chart.title) { (PreEscaped(fluid(&chart.svg))) }
                }
            } }
        }
    }
}

/// The SVG without its fixed size, so that it fills the room it has.
fn fluid(svg: &str) -> String {
    let fixed = format!("<svg width=\"{WIDTH}\" height=\"");
    let rest = svg
        .strip_prefix(&fixed)
        .and_then(|rest| rest.split_once("\" "));
    rest.map_or_else(|| svg.to_owned(), |(_, rest)| format!("<svg {rest}"))
}
