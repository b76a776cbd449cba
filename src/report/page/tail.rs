//! What failed, what it was measured against, where and how long, and what the numbers mean.

use super::super::format::{NONE, bytes, count, maybe, ms, number};
use super::super::view::{View, all_params, distinct, plain};
use super::parts::{self, cell};
use crate::batch::record::{Clock, Reference};
use maud::{Markup, html};

/// Failed cells with their reasons; nothing when none failed.
pub fn failures(view: &View<'_>) -> Markup {
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

/// Verdicts on published claims, as the records give them; nothing for a plain batch.
pub fn claims(view: &View<'_>) -> Markup {
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

/// The truths: what they cost and how much dearer they are than ten steps.
pub fn references(view: &View<'_>) -> Markup {
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

/// Million density samples a second.
fn throughput(reference: &Reference) -> Option<f64> {
    let samples = reference.view_samples? + reference.light_samples?;
    let time_ms = reference.march_ms.or(reference.wall_ms);
    time_ms
        .filter(|ms| *ms > 0.0)
        .map(|ms| samples as f64 / ms / 1e3)
}

/// Time of the truth over that of the first `srm` cell with 10 steps that was compared with it.
fn times_srm10(view: &View<'_>, reference: &Reference) -> Option<f64> {
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
pub fn environment(view: &View<'_>) -> Markup {
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

/// The files that the scenes read, and how the report is measured again; nothing where it does not hold its scenes.
fn inputs(view: &View<'_>) -> Markup {
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

/// Where the wall-clock time went.
pub fn wall(view: &View<'_>) -> Markup {
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

fn truths_ms(view: &View<'_>) -> Option<f64> {
    let times: Vec<f64> = view
        .report
        .references
        .iter()
        .filter_map(|r| r.march_ms)
        .collect();
    (!times.is_empty()).then(|| times.iter().sum())
}

/// One line for each number.
const DEFINITIONS: [(&str, &str); 23] = [
    (
        "L, ΔL",
        "sun-lit linear radiance of a cloud pixel (opacity of the truth above 0.01), and its difference from the truth",
    ),
    (
        "rel_rmse",
        "√Σ(ΔL)² / √ΣL² over RGB and cloud pixels; 1 = as large as the picture itself",
    ),
    (
        "floor_rel_rmse",
        "rel_rmse of the uncompressed column at the same steps and texels: what marching alone costs",
    ),
    (
        "bias",
        "ΣΔL / ΣL, in %; near zero it can hide leak and darken of equal size",
    ),
    (
        "leak",
        "Σmax(ΔL, 0) / ΣL, in %: light where there should be shadow",
    ),
    (
        "darken",
        "Σmin(ΔL, 0) / ΣL, in %, never positive: shadow where there should be light",
    ),
    (
        "p99_abs, max_abs",
        "99th percentile and largest |ΔL|, in units of the truth's mean L",
    ),
    (
        "T RMSE",
        "transmittance_rmse: RMSE of the light transmittance, weighted by σT along the view ray; 0 to 1",
    ),
    (
        "edge bias",
        "ΣΔL / ΣL over edge pixels, where the truth's opacity is at most 0.9, in %; n/a where it has none",
    ),
    (
        "FLIP",
        "perceived difference (LDR, 67 pixels a degree), 0 to 1: mean and 99th percentile",
    ),
    (
        "PSNR",
        "peak signal-to-noise ratio after one tone map fixed from the truth, peak 1, in dB; n/a when equal",
    ),
    (
        "SSIM",
        "structural similarity of the tone-mapped luma; 1 = equal",
    ),
    (
        "flicker",
        "RMS frame-to-frame change of ΔL in units of mean L, over 16 frames of a pan of one pixel a frame, and of a sun that rises by 1°; the pan carries even a steady error along, the sun does not; n/a where the experiment asks for none",
    ),
    (
        "not finite",
        "channels of the picture that are NaN or infinite; 0 is right",
    ),
    (
        "total, map pass, march",
        "median device time of one picture and of its passes over the rounds, in ms; a round's time is the median of frames that were handed over together; n/a without timestamps, and where these are invalid",
    ),
    (
        "min, p95, CV, n",
        "of the rounds' total times: smallest, 95th percentile (ms), standard deviation over mean (%), rounds; single frames scatter more",
    ),
    (
        "wall",
        "submission to completion of the frames of a round seen from the CPU, divided by their number, median, in ms; it stands for the total where no cell has one",
    ),
    (
        "map",
        "bytes of the map's textures as allocated; 0 for methods without a map",
    ),
    (
        "payload",
        "values × bytes a value × texels: what the encoding needs before formats round it up",
    ),
    (
        "allocator",
        "growth that the graphics allocator reports, in bytes; n/a where it does not",
    ),
    (
        "samples",
        "density samples by view rays, by light rays and by the map pass, counted in an untimed run",
    ),
    (
        "fallback",
        "share of light look-ups outside the map that were marched instead, in %",
    ),
    (
        "Pareto frontier",
        "cells that no other cell beats in both error and cost",
    ),
];

/// What each number means, with its unit.
pub fn definitions() -> Markup {
    html! {
        section #definitions {
            h2 { "Definitions" }
            dl.pairs { @for (name, meaning) in DEFINITIONS { dt { (name) } dd { (meaning) } } }
        }
    }
}
