//! Section on the stability of the adapter's clock during the measurement, by which the times are to be judged.

use super::super::format::{number, percent, signed_percent};
use super::super::view::{ReportView, distinct};
use super::parts::{self, cell, heading};
use crate::batch::clock::ClockRecord;
use crate::batch::record::{Measured, Reference};
use crate::gpu::{Clocks, Extent};
use crate::metrics::{Thirds, summarise, thirds};
use maud::{Markup, html};

/// Columns of the values that an NVIDIA device reports.
const DEVICE_COLUMNS: [(&str, &str); 4] = [
    ("SM clock", "MHz"),
    ("Memory clock", "MHz"),
    ("Power", "W"),
    ("Limited by", ""),
];

/// Drift of the clock probe over all blocks in one sentence, for the captions of tables of times; empty where the clock
/// was not probed.
pub fn sentence(view: &ReportView<'_>) -> Markup {
    let unsettled = view.report.clock.iter().filter(|r| !r.settled).count();
    html! {
        @if let Some([least, most]) = view.report.clock_drift() {
            " Between the rounds, the " a href="#clock" { "clock probe" } " changed by "
            (signed_percent(least)) " to " (signed_percent(most))
            @if unsettled > 0 { "; it had not settled before " (parts::plural(unsettled, "block")) }
            "."
        }
    }
}

/// The section; empty where the clock was not probed.
pub fn section(view: &ReportView<'_>) -> Markup {
    let cells = |record: &&ClockRecord| !measured(view, record).is_empty();
    let records: Vec<&ClockRecord> = view.report.clock.iter().filter(cells).collect();
    if records.is_empty() {
        return html! {};
    }
    let device = records.iter().any(|record| record.clocks.is_some());
    let columns = [
        ("Scene", ""),
        ("Sun", "°"),
        ("Image", "px"),
        ("Cells", ""),
        ("Frames in flight", ""),
        ("Warm-up", "s"),
        ("Settled", ""),
        ("Probe", "ms"),
        ("Drift", "%"),
        ("First to last third", "%"),
        ("Thirds agree", "cells"),
        ("Busy, least", "%"),
    ];
    let columns = columns
        .into_iter()
        .chain(DEVICE_COLUMNS.into_iter().filter(|_| device));
    let texts = ["Scene", "Settled", "Thirds agree", "Limited by"];
    let head =
        html! { @for (name, unit) in columns { (heading(name, unit, !texts.contains(&name))) } };
    let body = html! { @for record in &records { (row(view, record, device)) } };
    let caption = "One row a block: cells that were timed in the same rounds. The probe is a fixed piece of arithmetic; its drift \
        is the change of its time before, between and after the rounds against the time at which it had settled. First to last \
        third: median change of the cells' times from the first third of the rounds to the last; they agree where that is no more \
        than twice the median deviation within a third (9 rounds and more). Busy: share of the wall time of a cell's frames in which \
        its passes ran; where it is small the queue ran empty, and the clock may have fallen.";
    html! {
        section #clock {
            h2 { "Clock" }
            (parts::table(view, caption, "sortable", head, body))
        }
    }
}

fn row(view: &ReportView<'_>, record: &ClockRecord, device: bool) -> Markup {
    let measured = measured(view, record);
    let reference: Option<&Reference> =
        (view.report.references.iter()).find(|r| r.id == record.reference);
    let frames = distinct(measured.iter().map(|m| m.frames_in_flight));
    let few = frames.iter().min().copied().unwrap_or_default();
    let many = frames.iter().max().copied().unwrap_or_default();
    let drift = record.drift();
    let thirds: Vec<Thirds> = measured.iter().filter_map(|m| rounds_thirds(m)).collect();
    let changes: Vec<f64> = thirds.iter().map(|t| t.change).collect();
    let agreeing = thirds.iter().filter(|t| t.agree).count();
    let busy = measured.iter().filter_map(|m| busy(m)).reduce(f64::min);
    html! {
        tr {
            td { (reference.map_or("?", |r| r.scene.as_str())) }
            (cell(reference.map(|r| r.sun_elevation_deg), |sun| sun.to_string()))
            td.n { @if let Some(r) = reference { (r.image.width) "×" (r.image.height) } }
            td.n data-v=(measured.len()) { (measured.len()) }
            td.n data-v=(few) { (few) @if many != few { "–" (many) } }
            (cell(Some(record.warm_up_s), number))
            td { @if record.settled { "yes" } @else { strong { "no" } } }
            (cell(Some(record.settled_ms), number))
            (cell(drift.map(|[least, most]| most.max(-least)), |_| drift_text(drift)))
            (cell(summarise(&changes).map(|stats| stats.median), signed_percent))
            td { @if thirds.is_empty() { "n/a" } @else { (agreeing) " of " (thirds.len()) } }
            (cell(busy, percent))
            @if device { (device_cells(record.clocks.as_ref())) }
        }
    }
}

fn drift_text(drift: Option<[f64; 2]>) -> String {
    drift.map_or_else(String::new, |[least, most]| {
        format!("{} … {}", signed_percent(least), signed_percent(most))
    })
}

fn device_cells(clocks: Option<&Clocks>) -> Markup {
    let extents = |of: fn(&Clocks) -> Option<Extent>| clocks.and_then(of);
    let reasons = clocks.map(|clocks| {
        let names = clocks.throttle_reasons.iter().map(|r| r.replace('_', " "));
        names.collect::<Vec<_>>().join(", ")
    });
    html! {
        @for extent in [extents(|c| c.sm_mhz), extents(|c| c.memory_mhz), extents(|c| c.power_w)] {
            @match extent {
                Some(e) => td.n data-v=(e.median) {
                    (number(e.median))
                    @if e.min < e.max { " (" (number(e.min)) "–" (number(e.max)) ")" }
                },
                None => td.n.na { "n/a" },
            }
        }
        td { @match reasons.as_deref() { None => "n/a", Some("") => "nothing", Some(names) => (names) } }
    }
}

/// Numbers of the cells of a block.
fn measured<'a>(view: &ReportView<'a>, record: &ClockRecord) -> Vec<&'a Measured> {
    let numbers = view.report.cells.iter().filter_map(|c| c.result.as_ref());
    numbers
        .filter(|m| m.reference == record.reference && m.block == record.block)
        .collect()
}

/// Median device time over median wall-clock time: the share in which passes ran.
fn busy(measured: &Measured) -> Option<f64> {
    let times = &measured.time_ms;
    Some(times.total?.median / times.wall?.median)
}

/// First and last third of the rounds' times; `None` where there are too few or a round has no time.
fn rounds_thirds(measured: &Measured) -> Option<Thirds> {
    let times: Option<Vec<f64>> = measured.rounds_total_ms.iter().copied().collect();
    thirds(&times?)
}
