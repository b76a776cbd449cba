//! Sections of the stability page: defects, thresholds, refused cases, environment, definitions.

use super::super::format::{NONE, number};
use super::super::shell::parts::{self, plural};
use super::device;
use super::heat::label;
use crate::stability::{SEARCHED, SearchResult, Sweep, Threshold};
use maud::{Markup, html};

/// Forms that must hold and do not; empty when all hold.
pub fn defects(sweep: &Sweep) -> Markup {
    let defects = sweep.defects();
    html! {
        @if !defects.is_empty() {
            section.failed #defects {
                h2 { (plural(defects.len(), "result")) " of forms that must hold" }
                div.scroll { table {
                    thead { tr { @for name in ["Extreme", "Setting", "Oracle", "Device"] { th scope="col" { (name) } } } }
                    tbody { @for (case, row) in defects {
                        @let picture = row.device.as_ref();
                        tr {
                            td { (case.group) ": " (case.name) }
                            td.whole { (label(&row.setting)) }
                            td.reason { (row.oracle().reason.as_deref().unwrap_or("holds")) }
                            td.reason { (picture.and_then(|p| p.reason.as_deref()).unwrap_or("holds")) }
                        }
                    } }
                } }
            }
        }
    }
}

/// Thresholds: predicted, measured on the oracle, and the result on the device.
pub fn thresholds(sweep: &Sweep) -> Markup {
    let head = html! {
        @for name in ["Form", "What happens", "Parameter", "Storage", "Denormals"] { th scope="col" { (name) } }
        @for name in ["predicted", "oracle", "device"] { th.n scope="col" { (name) } }
        th scope="col" { "Because" }
    };
    let body = html! {
        @for (i, t) in sweep.thresholds.iter().enumerate() {
            @let new = i > 0 && sweep.thresholds[i - 1].form != t.form;
            tr.divided[new] {
                th.whole scope="row" { (t.form) }
                td.reason { (t.what) }
                td.whole { (t.parameter) }
                td { (t.storage) }
                td { (t.flush.map_or("–", |flush| if flush { "flushed" } else { "kept" })) }
                td.n { (at(t.predicted, t)) }
                td.n { (at(t.measured, t)) }
                td.n { (found(t)) }
                td.long { (t.source) }
            }
        }
    };
    html! {
        section #thresholds {
            h2 { "Where the published forms end" }
            p {
                "The parameter at which it begins, found by bisection. Predictions follow from the number formats; the "
                "oracle emulates them. The device ran the same search over small pictures: WGSL lets it treat what is not "
                "finite as it likes, and its f16 stores may cut off instead of rounding to infinity."
            }
            (parts::table(format!("Device: {}", device(sweep)), "", "limits", head, body))
        }
    }
}

/// Text of a threshold with three or four decimals, by [`number`] below 1e-3; "never" where none was found.
fn at(value: Option<f64>, threshold: &Threshold) -> String {
    match value {
        None => "never".to_owned(),
        Some(v) if v.abs() < 1e-3 => number(v),
        Some(v) if threshold.parameter == "T" => format!("{v:.4}"),
        Some(v) => format!("{v:.3}"),
    }
}

fn found(threshold: &Threshold) -> String {
    match &threshold.device {
        None => NONE.to_owned(),
        Some(SearchResult::At(v)) => format!("{v:.2}"),
        Some(SearchResult::NotUpTo(limit)) => format!("not up to {}", number(*limit)),
        Some(SearchResult::Failed(words)) => words.clone(),
    }
}

/// Refused cases with their reasons.
pub fn refused(sweep: &Sweep) -> Markup {
    let cases = sweep.cases.iter().filter(|case| case.refused.is_some());
    html! {
        section #refused {
            h2 { "Refused" }
            dl.pairs { @for case in cases {
                dt { (case.group) ": " (case.name) }
                dd { (case.refused.as_deref().unwrap_or_default()) }
            } }
        }
    }
}

/// The machine and the build.
pub fn environment(sweep: &Sweep) -> Markup {
    let slowest = sweep
        .cases
        .iter()
        .max_by(|a, b| a.wall_s.total_cmp(&b.wall_s));
    html! {
        section #environment {
            h2 { "Environment" }
            dl.pairs {
                @match &sweep.environment {
                    None => { dt { "Adapter" } dd { "none: the oracle ran alone" } },
                    Some(e) => {
                        @for (name, value) in [
                            ("Adapter", &e.adapter), ("Driver", &e.driver), ("Backend", &e.backend),
                            ("Device type", &e.device_type), ("Program", &e.commit), ("Host", &e.host),
                        ] { dt { (name) } dd { (value) } }
                    }
                }
                dt { "Wall clock" }
                dd { (number(sweep.wall_s)) " s, resumed runs together"
                    @if let Some(case) = slowest { "; the slowest case, " (case.group) " " (case.name) ", " (number(case.wall_s)) " s" }
                }
            }
        }
    }
}

const DEFINITIONS: [(&str, &str); 9] = [
    (
        "T, d",
        "light transmittance along a light column, and the depth at which it is looked at: 65 depths of up to 15 columns through what the picture sees",
    ),
    (
        "truth",
        "the same column marched once in f64, 4096 midpoint steps",
    ),
    (
        "largest error",
        "largest |T − truth| over finite T; on the device largest |V − V of the oracle's truth| of a pixel",
    ),
    (
        "weighted RMSE",
        "√(Σ σT (ΔT)²/Σ σT): where light is scattered counts",
    ),
    (
        "rises",
        "how often T grows from one depth to the next by more than 10⁻⁶, and the largest growth from any depth to a deeper one",
    ),
    (
        "rings",
        "FOM's truncated series overshoots: its τ stays within 1.19 of the column's own; a march without a map takes other samples from every point",
    ),
    (
        "breaks",
        "T or a stored value NaN or infinite, T outside [0, 1] by more than 10⁻⁶, or a rise that is not documented; on the device exponent bits all ones, or V outside [0, 1] by more than 10⁻⁴",
    ),
    (
        "stable, published",
        "a stable form must hold at every extreme; a published form is the formula as printed, kept to show where it ends",
    ),
    (
        "oracle, device",
        "verdicts on the oracle are asserted, with f16 and f32 emulated and denormals kept and flushed; what a device does with values that are not finite is its own and is recorded",
    ),
];

/// Definition of each number.
pub fn definitions() -> Markup {
    let never = html! { p { "Never: not up to " (number(SEARCHED)) "." } };
    parts::definitions(&DEFINITIONS, never)
}
