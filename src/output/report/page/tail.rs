//! Last sections of a report: failed cells, claims, truths, environment and inputs, wall-clock time, definitions.

use super::super::format::{NONE, bytes, count, maybe, ms, number};
use super::super::view::{ReportView, all_params, distinct, plain};
use super::parts::{self, cell};
use super::table;
use crate::batch::record::{Clock, Reference};
use maud::{Markup, html};

/// Failed cells with their reasons; empty when none failed.
pub fn failures(view: &ReportView<'_>) -> Markup {
    let failed: Vec<_> = view
        .report
        .cells
        .iter()
        .filter(|c| c.result.is_none())
        .collect();
    if failed.is_empty() {
        return html! {};
    }
    let head = html! { @for name in ["#", "Scene", "Sun", "Method", "Parameters", "Reason"] { th scope="col" { (name) } } };
    let body = html! {
        @for cell in &failed {
            tr {
                td.n { (cell.index) }
                td { (cell.scene) }
                td.n { (cell.sun_elevation_deg) "°" }
                td { (parts::method(&cell.method)) }
                td.setting.long { (all_params(cell)) }
                td.reason { (cell.failed.as_deref().unwrap_or("no reason recorded")) }
            }
        }
    };
    html! {
        section.failed #failed {
            h2 { (parts::plural(failed.len(), "cell")) " failed" }
            (parts::table(view, "They have no numbers and appear nowhere else on this page.", "small", head, body))
        }
    }
}

/// Verdicts on published claims from the records; empty where there are none, as for a batch outside a study.
pub fn claims(view: &ReportView<'_>) -> Markup {
    let claims: Vec<_> = view
        .report
        .claims
        .iter()
        .filter_map(|c| c.as_object())
        .collect();
    if claims.is_empty() {
        return html! {};
    }
    let keys = distinct(claims.iter().flat_map(|c| c.keys()));
    let head = html! { @for key in &keys { th scope="col" { (key.replace('_', " ")) } } };
    let body = html! {
        @for claim in &claims {
            tr { @for key in &keys { td.claim { (claim.get(key.as_str()).map(plain).unwrap_or_default()) } } }
        }
    };
    html! {
        section #claims {
            h2 { "Published claims" }
            (parts::table(view, "Claims and what was measured.", "small", head, body))
        }
    }
}

/// Truths: their time and sample counts, and their time over that of `srm` with 10 steps.
pub fn references(view: &ReportView<'_>) -> Markup {
    let head = html! {
        @for (name, unit) in [
            ("Scene", ""), ("Sun", "°"), ("Image", "px"), ("March", "ms"), ("Wall", "ms"), ("View samples", ""), ("Light samples", ""),
            ("Throughput", "Msamples/s"), ("Time ÷ srm, 10 steps", ""), ("View-step error", ""), ("Source", ""),
        ] { (parts::heading(name, unit, !["Scene", "Source"].contains(&name))) }
    };
    let body = html! {
        @for reference in &view.report.references {
            tr {
                td { (reference.scene) }
                td.n data-v=(reference.sun_elevation_deg) { (reference.sun_elevation_deg) }
                td.n data-v=(reference.image.width) { (reference.image.width) "×" (reference.image.height) }
                (cell(reference.march_ms, number))
                (cell(reference.wall_ms, number))
                (cell(reference.view_samples.map(|n| n as f64), |n| count(n as u64)))
                (cell(reference.light_samples.map(|n| n as f64), |n| count(n as u64)))
                (cell(throughput(reference), number))
                (cell(times_srm10(view, reference), |r| format!("{} ×", number(r))))
                (cell(reference.view_step_rel_rmse, number))
                td { @if reference.cached { "cache" } @else { "this run" } }
            }
        }
    };
    let caption = "The 1000-step truths. Times from the cache are those of the run that made the picture. View-step error: \
        rel_rmse of the scene's view steps against four times as many; truth and methods share it, so no cell shows it.";
    html! {
        section #references {
            h2 { "Truths" }
            @if view.report.references.is_empty() { p.notice { "The report has no truth." } }
            @else { (parts::table(view, caption, "sortable", head, body)) }
        }
    }
}

/// View and light samples of the truth per second, in millions.
fn throughput(reference: &Reference) -> Option<f64> {
    let samples = reference.view_samples? + reference.light_samples?;
    let time_ms = reference.march_ms.or(reference.wall_ms);
    time_ms
        .filter(|ms| *ms > 0.0)
        .map(|ms| samples as f64 / ms / 1e3)
}

/// Time of the truth over that of the first `srm` cell with 10 steps that was compared with it.
fn times_srm10(view: &ReportView<'_>, reference: &Reference) -> Option<f64> {
    let ten = |cell: &&crate::batch::record::Cell| {
        let own = cell
            .result
            .as_ref()
            .is_some_and(|r| r.reference == reference.id);
        own && cell.method == "srm"
            && cell.reconstruct.is_full()
            && cell.params.get("steps").and_then(|v| v.as_f64()) == Some(10.0)
    };
    let clock = view.clock();
    let times = &view.report.cells.iter().find(ten)?.result.as_ref()?.time_ms;
    let own_ms = clock.cost(times)?.median;
    let truth_ms = match clock {
        Clock::Device => reference.march_ms,
        Clock::Wall => reference.wall_ms,
    };
    truth_ms.filter(|_| own_ms > 0.0).map(|ms| ms / own_ms)
}

/// Adapter, driver, build, host.
pub fn environment(view: &ReportView<'_>) -> Markup {
    let e = &view.report.environment;
    let pairs = [
        ("Adapter", &e.adapter),
        ("Device type", &e.device_type),
        ("Driver", &e.driver),
        ("Backend", &e.backend),
        ("Host", &e.host),
        ("Program", &e.commit),
    ];
    html! {
        section #environment {
            h2 { "Environment" }
            dl.pairs { @for (name, value) in pairs {
                dt { (name) }
                dd { @if value.is_empty() { (NONE) } @else { (value) } }
            } }
            (inputs(view))
        }
    }
}

/// Files that the scenes read, and how to repeat the measurement; empty where the report does not contain its scenes.
fn inputs(view: &ReportView<'_>) -> Markup {
    let report = view.report;
    if report.scenes.is_empty() {
        return html! {};
    }
    html! {
        dl.pairs { @for file in &report.inputs {
            dt { "Volume" }
            dd { (file.path) " " span.unit { (bytes(file.bytes)) ", BLAKE3 " (file.blake3) } }
        } }
        p {
            "The records hold the scenes as they were measured: " code { "occlab batch FOLDER --out NEW" }
            " measures them again, here or elsewhere."
        }
    }
}

/// Breakdown of the wall-clock time.
pub fn wall(view: &ReportView<'_>) -> Markup {
    let w = &view.report.wall;
    let ratio = (w.passes_s > 0.0).then(|| (w.total_s - w.compile_s) / w.passes_s);
    let seconds = |s: f64| format!("{} s", number(s));
    let pairs = [
        (
            "Total",
            seconds(w.total_s),
            "from start to report, summed over resumed runs",
        ),
        (
            "Passes",
            seconds(w.passes_s),
            "on the device: timed and discarded runs, warming up, truths, counting, floor, flicker, view steps",
        ),
        ("Compilation", seconds(w.compile_s), "shaders and pipelines"),
        (
            "(Total − compilation) ÷ passes",
            maybe(ratio),
            "1 would mean that nothing but passes took time",
        ),
    ];
    html! {
        section #wall {
            h2 { "Wall clock" }
            dl.pairs { @for (name, value, meaning) in pairs {
                dt { (name) }
                dd { (value) " " span.unit { (meaning) } }
            } }
            @if let Some(truths) = truths_ms(view) {
                p { "The truths took " (ms(Some(truths))) " of device time, those from the cache included." }
            }
        }
    }
}

fn truths_ms(view: &ReportView<'_>) -> Option<f64> {
    let times: Vec<f64> = view
        .report
        .references
        .iter()
        .filter_map(|r| r.march_ms)
        .collect();
    (!times.is_empty()).then(|| times.iter().sum())
}

/// Definition of each number in the table of all cells.
pub fn definitions(view: &ReportView<'_>) -> Markup {
    html! {
        section #definitions {
            h2 { "Definitions" }
            dl.pairs {
                dt { "L, ΔL" }
                dd { "sun-lit linear radiance of a cloud pixel (opacity of the truth above 0.01), and its difference from the truth" }
                @for number in table::columns(view) {
                    @let unit = number.format.unit_written(number.unit);
                    dt { (number.label) @if !unit.is_empty() { " " span.unit { (unit) } } }
                    dd { (number.doc) }
                }
                dt { "Pareto frontier" }
                dd { "cells that no other cell beats in both error and cost" }
            }
        }
    }
}
