//! Tables of the Pareto-optimal cells of each scene and sun: error against time, and error against memory.

use super::super::format::{error, ms, number};
use super::super::pareto::frontier;
use super::super::view::{CellGroup, ReportView, Shot};
use super::parts;
use crate::metrics::{Metric, metric};
use maud::{Markup, html};

/// Error numbers of a row.
const ERRORS: [&Metric; 3] = [metric("rel_rmse"), metric("leak"), metric("darken")];

/// Both tables of one case, collapsed.
pub fn of_case(view: &ReportView<'_>, case: &CellGroup<'_>) -> Markup {
    let shots = case.shots();
    html! {
        @if shots.is_empty() { p.notice { (case.name) ": every cell failed." } }
        @else {
            details {
                summary { "Frontier of " (case.name) }
                div.pair {
                    (by_time(view, &shots))
                    (by_memory(view, &shots))
                }
            }
        }
    }
}

fn by_time(view: &ReportView<'_>, shots: &[Shot<'_>]) -> Markup {
    let timed: Vec<&Shot<'_>> = shots.iter().filter(|s| s.time_ms().is_some()).collect();
    if timed.is_empty() {
        return html! { p.notice { "No cell has a time." } };
    }
    let points: Vec<_> = timed
        .iter()
        .map(|s| (s.time_ms().unwrap_or(f64::INFINITY), s.rel_rmse()))
        .collect();
    let untimed = shots.len() - timed.len();
    let caption = html! {
        "Smallest error for a given " (view.clock().name()) " time."
        @if untimed > 0 { " Without " (parts::plural(untimed, "cell")) " whose time is n/a." }
    };
    let head = html! {
        th.n scope="col" { "Time " span.unit { "ms" } br; span.unit { "median" br; "min–p95" } }
        (columns())
        th.n scope="col" { (view.remembered()) }
    };
    let body = html! {
        @for shot in frontier(&points).into_iter().map(|i| timed[i]) {
            @let total = shot.time().unwrap_or_default();
            tr {
                td.n { strong { (number(total.median)) } br; span.unit { (number(total.min)) "–" (number(total.p95)) } }
                (cells(view, shot))
                td.n { (shot.memory()) }
            }
        }
    };
    parts::table(view, caption, "small", head, body)
}

fn by_memory(view: &ReportView<'_>, shots: &[Shot<'_>]) -> Markup {
    let points: Vec<_> = shots
        .iter()
        .map(|s| (s.memory_bytes() as f64, s.rel_rmse()))
        .collect();
    let best = frontier(&points);
    let only_maps: Vec<_> = shots
        .iter()
        .zip(&points)
        .map(|(s, p)| {
            if s.map_bytes() > 0 {
                *p
            } else {
                (f64::NAN, p.1)
            }
        })
        .collect();
    let mut with_map = frontier(&only_maps);
    with_map.retain(|i| !best.contains(i));
    let caption = html! {
        "Smallest error for given memory of the map" @if view.reconstructed() { " and the history" } "."
        @if !with_map.is_empty() { " Below the line: among methods with a map." }
    };
    let head = html! {
        th.n scope="col" { (view.remembered()) }
        (columns())
        th.n scope="col" { "Time" }
    };
    let body = html! {
        @for (i, shot) in best.iter().chain(&with_map).map(|&i| &shots[i]).enumerate() {
            tr.divided[i == best.len()] {
                td.n { strong { (shot.memory()) } }
                (cells(view, shot))
                td.n { (ms(shot.time_ms())) }
            }
        }
    };
    parts::table(view, caption, "small", head, body)
}

fn columns() -> Markup {
    html! {
        th scope="col" { "Method" }
        th scope="col" { "Setting" }
        @for metric in ERRORS { th.n scope="col" { (metric.label) } }
    }
}

fn cells(view: &ReportView<'_>, shot: &Shot<'_>) -> Markup {
    html! {
        td { (parts::method(&shot.cell.method)) }
        td { (parts::setting(view, shot)) }
        @for metric in ERRORS { td.n { (error(metric, &shot.numbers.error)) } }
    }
}
