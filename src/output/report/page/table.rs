//! Sortable table of every cell and every number.

use super::super::format::written;
use super::super::view::{CellGroup, ReportView, Shot, all_params, distinct, pairs};
use super::album::Album;
use super::clock;
use super::parts::{self, cell, heading};
use crate::batch::numbers::{CellNumber, PagePlace, numbers};
use maud::{Markup, html};

/// Columns before the numbers, with their units.
const FIRST: [(&str, &str); 5] = [
    ("#", ""),
    ("Scene", ""),
    ("Sun", "°"),
    ("Method", ""),
    ("Setting", ""),
];

/// Columns that hold text.
const TEXTS: [&str; 4] = ["Scene", "Method", "Setting", "Picture"];

/// Numbers of the table; those of reconstructed pictures are left out where every cell is `full`.
pub fn columns(view: &ReportView<'_>) -> Vec<&'static CellNumber> {
    let shown = |n: &&CellNumber| {
        n.shown == PagePlace::Cells && (view.reconstructed() || !n.is_of_reconstruction())
    };
    numbers().iter().filter(shown).collect()
}

/// The section.
pub fn section(view: &ReportView<'_>, album: &Album) -> Markup {
    let columns = columns(view);
    let headings = columns.iter();
    let headings = headings.map(|n| (n.label, n.format.unit_written(n.unit)));
    let headings = FIRST.into_iter().chain(headings).chain([("Picture", "")]);
    let head =
        html! { @for (name, unit) in headings { (heading(name, unit, !TEXTS.contains(&name))) } };
    let body = html! {
        @for case in &view.cases {
            @for shot in case.shots() { (row(view, case, &shot, &columns, album)) }
        }
    };
    let caption = html! {
        "Every cell that has numbers. A heading sorts by its column. The same table for programs: "
        a href="./cells.csv" { "cells.csv" } ", " a href="./report.json" { "report.json" } "."
        (clock::sentence(view))
    };
    html! {
        section #cells {
            h2 { "All cells" }
            (parts::table(view, caption, "sortable wide", head, body))
            (fixed(view))
        }
    }
}

fn row(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    shot: &Shot<'_>,
    columns: &[&CellNumber],
    album: &Album,
) -> Markup {
    let picture = shot
        .numbers
        .files
        .get("png")
        .and_then(|v| v.as_str())
        .and_then(|n| album.link(n));
    html! {
        tr id={ "cell-" (shot.cell.index) } data-view=(case.number) data-setting=(setting_key(shot)) data-error=(shot.rel_rmse())
            data-ms=[shot.time_ms()] data-bytes=(shot.memory_bytes()) {
            td.n data-v=(shot.cell.index) { (shot.cell.index) }
            td title=(case.name) { (case.name) }
            td.n data-v=(shot.cell.sun_elevation_deg) { (shot.cell.sun_elevation_deg) }
            th scope="row" { (parts::method(&shot.cell.method)) }
            td { (parts::setting(view, shot)) }
            @for n in columns { (cell(n.value(shot.numbers), |value| written(n.format, value))) }
            td { @match picture { Some(link) => a href=(link) { "png" }, None => span.na { "missing" } } }
        }
    }
}

/// Key of method and setting, equal for its cells of every scene and sun.
fn setting_key(shot: &Shot<'_>) -> String {
    format!("{} {}", shot.cell.method, all_params(shot.cell))
}

/// Text on the parameters that all cells of a method share; the column "Setting" leaves them out.
fn fixed(view: &ReportView<'_>) -> Markup {
    let methods = distinct(view.report.cells.iter().map(|c| c.method.as_str()));
    let shared = |method: &str| {
        let cell = view.report.cells.iter().find(|c| c.method == method);
        let params = cell.into_iter().flat_map(|c| &c.params);
        let params = params.map(|(k, v)| (k.as_str(), v));
        pairs(params.filter(|(k, _)| !view.varying(method).contains(k)))
    };
    let head = html! { th scope="col" { "Method" } th scope="col" { "The same in all its cells" } };
    let body = html! {
        @for method in methods {
            @let text = shared(method);
            tr {
                td { (parts::method(method)) }
                td.setting.long { @if text.is_empty() { "–" } @else { (text) } }
            }
        }
    };
    parts::table(
        view,
        "Parameters that this experiment does not vary.",
        "small",
        head,
        body,
    )
}
