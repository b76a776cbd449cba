//! Sections of the study page as tables: claims, their evidence, errata, the cost model, definitions.

use super::super::Outcome;
use super::super::charts::Figure;
use super::super::claims::Claim;
use super::super::cost_model::{COUNTS, SharedCost};
use super::{cell_links, class, grid};
use crate::config::Study;
use crate::report::format::{number, percent, signed_percent};
use crate::report::shell::parts;
use maud::{Markup, html};

/// Section of the claims, one row for each.
pub fn claims(outcome: &Outcome) -> Markup {
    let names = ["Claim", "Published", "Verdict here", "Because"];
    let head = html! { @for name in names { th scope="col" { (name) } } };
    let body = html! { @for claim in &outcome.claims {
        tr {
            th scope="row" { a href={ "#claim-" (claim.id) } { (claim.id) } }
            td.claim data-label="Published" { (claim.says) " " span.unit { (claim.place) } }
            td data-label="Verdict" { span class=(class(claim.verdict)) { (claim.verdict.words()) } }
            td.claim data-label="Because" { (claim.because) }
        }
    } };
    let caption = "One row a claim; its id leads to its parts and their numbers.";
    let source = format!("Adapter: {}", outcome.adapter);
    html! {
        section #claims {
            h2 { "Claims put to the test" }
            (parts::table(source, caption, "verdicts stacked", head, body))
        }
    }
}

/// Section with the numbers that decided each part of each claim.
pub fn evidence(outcome: &Outcome) -> Markup {
    html! {
        section #evidence {
            h2 { "Evidence" }
            p {
                "Times as median [low, high], between repeats that hold the true median with a probability of at least 93 % (of 3 or 4 "
                "repeats 75 to 88 %; where no rounds were recorded, between minimum and 95th percentile); cells that were timed in "
                "the same rounds are compared round by round. A part holds or fails only where that "
                "whole range says so."
            }
            @for claim in &outcome.claims { (parts_of(claim)) }
        }
    }
}

fn parts_of(claim: &Claim) -> Markup {
    html! {
        article id={ "claim-" (claim.id) } {
            h3 { (claim.id) " · " (claim.says) " " span class=(class(claim.verdict)) { (claim.verdict.words()) } }
            @if claim.parts.is_empty() { p { (claim.because) } }
            ul.parts { @for part in &claim.parts {
                li {
                    span class=(class(part.finding.verdict)) { (part.finding.verdict.words()) } " "
                    strong { (part.says) } ": " (part.finding.numbers) ". "
                    (cell_links(&part.finding.cells))
                }
            } }
        }
    }
}

/// Section of the source's defects.
pub fn errata(outcome: &Outcome) -> Markup {
    html! {
        section #errata {
            h2 { "Errata of the source" }
            p { "Each misprint with the number that shows it; nothing else differs. Errors of two cells are relative to one truth; "
                "a misprint of the view march changes the truth itself." }
            @if outcome.errata.is_empty() { p { "The study lists none." } }
            @else { div.scroll tabindex="0" { table.verdicts.stacked {
                thead { tr { @for name in ["Where", "Printed", "Meant", "Measured here"] { th scope="col" { (name) } } } }
                tbody { @for shown in &outcome.errata {
                    tr {
                        th.claim scope="row" { (shown.place) }
                        td.claim data-label="Printed" { (shown.printed) }
                        td.claim data-label="Meant" { (shown.meant) }
                        td.claim.na[!shown.measured] data-label="Measured" { (shown.numbers) ". " (cell_links(&shown.cells)) }
                    }
                } }
            } } }
        }
    }
}

/// Section of the cost model: fitted prices, quality of the fit, and reasons for large errors.
pub fn cost_model(study: &Study, outcome: &Outcome, figures: &[Figure]) -> Markup {
    let Some(model) = &outcome.cost_model else {
        return html! { section #cost { h2 { "Cost model" } p.notice { "No cell has a time, so nothing is fitted." } } };
    };
    html! {
        section #cost {
            h2 { "Cost model" }
            p {
                @if !study.cost_model.says.is_empty() { (study.cost_model.says) " " }
                "Counted by the shaders of all " (model.cells.len()) " cells and fitted to their times, one price gives "
                strong { (number(model.one_price_ns)) " ns a sample" } ", R² = " strong { (format!("{:.3}", model.one_price_r2)) } ". "
                "A price for each kind of sample, fitted to each method, gives the table."
            }
            (shared(&model.shared))
            (prices(outcome))
            @for method in &model.methods { @if !method.why.is_empty() {
                p { (parts::method(&method.method)) " " (method.why.join(" ")) }
            } }
            (grid(figures.iter().filter(|figure| figure.of_costs)))
        }
    }
}

fn shared(cost: &SharedCost) -> Markup {
    let [view, light, map] = cost.samples_ns.map(number);
    let look_ups = cost.look_ups_ns.iter();
    let look_ups: Vec<String> = look_ups
        .map(|(method, ns)| format!("{} ns for {method}", number(*ns)))
        .collect();
    html! {
        p {
            "If samples cost the same whoever takes them, " strong { (view) " ns a view sample, " (light) " ns a light sample, " (map)
            " ns a map sample" } @if !look_ups.is_empty() { " and a look-up " strong { (look_ups.join(", ")) } } " fit all methods at "
            "once with R² = " strong { (format!("{:.3}", cost.r2)) } ", typical error " (percent(cost.typical)) "."
        }
    }
}

fn prices(outcome: &Outcome) -> Markup {
    let methods = outcome.cost_model.iter().flat_map(|m| &m.methods);
    let last = [
        "R²",
        "typical error",
        "worst",
        "one price: typical",
        "worst",
    ];
    let head = html! {
        th scope="col" { "Method" } th.n scope="col" { "Cells" }
        @for name in COUNTS { th.n scope="col" { "ns a " (name) } }
        @for name in last { th.n scope="col" { (name) } }
    };
    let body = html! { @for m in methods {
        tr {
            td { (parts::method(&m.method)) }
            td.n { (m.cells) }
            @for ns in m.prices_ns { td.n { (number(ns)) } }
            td.n { (format!("{:.3}", m.r2)) }
            td.n { (percent(m.typical)) }
            td.n { (signed_percent(m.worst)) }
            td.n { (percent(m.one_price_typical)) }
            td.n { (signed_percent(m.one_price_worst)) }
        }
    } };
    let caption = "Non-negative least squares of relative errors. 0: the fit gives that count no price of its own, mostly \
        because it grows together with another.";
    let source = format!("Adapter: {}, clock: {}", outcome.adapter, outcome.clock);
    parts::table(source, caption, "small", head, body)
}

/// One line for each number of this page.
const DEFINITIONS: [(&str, &str); 8] = [
    (
        "holds, does not hold",
        "the whole range of the repeats lies inside, or outside, what the claim allows",
    ),
    (
        "not decidable here",
        "the range lies across the limit, a cell failed or is missing, or no record measures it; the reason stands beside it",
    ),
    (
        "crossing",
        "an interval: the last value of the axis at which one method is surely cheaper, and the first at which it is surely dearer",
    ),
    (
        "rel_rmse",
        "√Σ(ΔL)² / √ΣL² of sun-lit radiance over cloud pixels, against the 1000-step truth",
    ),
    (
        "leak, darken",
        "sums of the positive and of the negative half of the error over ΣL; darken is given by its size",
    ),
    (
        "cloud_pixel_fraction",
        "share of pixels whose opacity in the truth exceeds 0.01",
    ),
    (
        "R²",
        "share of the variance of the times' logarithms that a model explains",
    ),
    (
        "look-up",
        "one evaluation of light through a map; a secondary march has light samples instead",
    ),
];

/// Section with the definition of each number.
pub fn definitions() -> Markup {
    parts::definitions(&DEFINITIONS, "")
}
