//! Every cell and every number, sortable.

use super::super::format::{bytes, count, number, percent, signed_percent};
use super::super::view::{Case, Shot, View, all_params, distinct, pairs};
use super::album::Album;
use super::clock;
use super::parts::{self, cell, heading};
use crate::metrics::ErrorNumbers;
use maud::{Markup, html};

/// Columns with their units, in order.
const COLUMNS: [(&str, &str); 40] = [
    ("#", ""),
    ("Scene", ""),
    ("Sun", "°"),
    ("Method", ""),
    ("Setting", ""),
    ("rel_rmse", ""),
    ("floor_rel_rmse", ""),
    ("Bias", "%"),
    ("Leak", "%"),
    ("Darken", "%"),
    ("p99_abs", "mean L"),
    ("max_abs", "mean L"),
    ("T RMSE", ""),
    ("Edge bias", "%"),
    ("FLIP mean", ""),
    ("FLIP p99", ""),
    ("PSNR", "dB"),
    ("SSIM", ""),
    ("Flicker, pan", "mean L"),
    ("Flicker, sun", "mean L"),
    ("Not finite", "channels"),
    ("Total", "ms"),
    ("min", "ms"),
    ("p95", "ms"),
    ("CV", "%"),
    ("n", ""),
    ("Map pass", "ms"),
    ("March", "ms"),
    ("Reconstruct", "ms"),
    ("Wall", "ms"),
    ("Wall n", ""),
    ("Map", "bytes"),
    ("History", "bytes"),
    ("Payload", "bytes"),
    ("Allocator", "bytes"),
    ("View samples", ""),
    ("Light samples", ""),
    ("Map samples", ""),
    ("Fallback", "%"),
    ("Picture", ""),
];

/// Columns of temporal integration, left out where every cell is `full`.
const TEMPORAL: [&str; 2] = ["Reconstruct", "History"];

/// Columns without numbers.
const TEXTS: [&str; 4] = ["Scene", "Method", "Setting", "Picture"];

/// The section.
pub fn section(view: &View<'_>, album: &Album) -> Markup {
    let shown = |name: &str| view.temporal() || !TEMPORAL.contains(&name);
    let columns = COLUMNS.into_iter().filter(|(name, _)| shown(name));
    let head =
        html! { @for (name, unit) in columns { (heading(name, unit, !TEXTS.contains(&name))) } };
    let body = html! {
        @for case in &view.cases {
            @for shot in case.shots() { (row(view, case, &shot, album)) }
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

fn row(view: &View<'_>, case: &Case<'_>, shot: &Shot<'_>, album: &Album) -> Markup {
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
            (errors(shot))
            (times(view, shot))
            (costs(view, shot))
            td { @match picture { Some(link) => a href=(link) { "png" }, None => span.na { "missing" } } }
        }
    }
}

/// The same for the cells of one method at one setting, whatever their scene and sun.
fn setting_key(shot: &Shot<'_>) -> String {
    format!("{} {}", shot.cell.method, all_params(shot.cell))
}

fn errors(shot: &Shot<'_>) -> Markup {
    // Taken apart without a rest, so that the compiler tells which number has no column.
    let ErrorNumbers {
        rel_rmse,
        bias,
        leak,
        darken,
        p99_abs,
        max_abs,
        transmittance_rmse,
        edge_bias,
        floor_rel_rmse,
        flicker,
        flicker_sun,
        flip_mean,
        flip_p99,
        psnr_db,
        ssim,
        nonfinite,
    } = shot.numbers.error;
    html! {
        (cell(Some(rel_rmse), number))
        (cell(floor_rel_rmse, number))
        (cell(Some(bias), signed_percent))
        (cell(Some(leak), signed_percent))
        (cell(Some(darken), signed_percent))
        (cell(Some(p99_abs), number))
        (cell(Some(max_abs), number))
        (cell(Some(transmittance_rmse), number))
        (cell(edge_bias, signed_percent))
        (cell(Some(flip_mean), number))
        (cell(Some(flip_p99), number))
        (cell(psnr_db, number))
        (cell(Some(ssim), number))
        (cell(flicker, number))
        (cell(flicker_sun, number))
        (cell(Some(nonfinite as f64), |_| nonfinite.to_string()))
    }
}

fn times(view: &View<'_>, shot: &Shot<'_>) -> Markup {
    let t = &shot.numbers.time_ms;
    html! {
        (cell(t.total.map(|s| s.median), number))
        (cell(t.total.map(|s| s.min), number))
        (cell(t.total.map(|s| s.p95), number))
        (cell(t.total.map(|s| s.cv), percent))
        (cell(t.total.map(|s| s.n as f64), |n| n.to_string()))
        (cell(t.generate.map(|s| s.median), number))
        (cell(t.march.map(|s| s.median), number))
        @if view.temporal() { (cell(t.reconstruct.map(|s| s.median), number)) }
        (cell(t.wall.map(|s| s.median), number))
        (cell(t.wall.map(|s| s.n as f64), |n| n.to_string()))
    }
}

fn costs(view: &View<'_>, shot: &Shot<'_>) -> Markup {
    let (m, s) = (&shot.numbers.memory, &shot.numbers.samples);
    html! {
        (cell(Some(m.map_bytes as f64), |_| bytes(m.map_bytes)))
        @if view.temporal() { (cell(Some(shot.history_bytes() as f64), |_| bytes(shot.history_bytes()))) }
        @for value in [Some(m.payload_bytes), m.allocator_bytes] {
            (cell(value.map(|v| v as f64), |_| bytes(value.unwrap_or_default())))
        }
        @for value in [s.view, s.light, s.map] { (cell(Some(value as f64), |_| count(value))) }
        (cell(Some(shot.numbers.fallback_fraction), percent))
    }
}

/// Parameters that all cells of a method share, which the column "Setting" leaves out.
fn fixed(view: &View<'_>) -> Markup {
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
