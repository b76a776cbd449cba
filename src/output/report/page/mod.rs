//! `index.html`: the whole report as one self-contained page.

pub(crate) mod album;
mod choose;
mod clock;
mod errors;
mod figures;
mod frontier;
pub(crate) mod parts;
pub(crate) mod pictures;
mod reconstructions;
mod table;
mod tail;

use super::charts::Drawing;
use super::contact::Sheet;
use super::shell::{Link, Page, PageHeader, SCRIPT, page};
use super::view::{ReportView, distinct, plain};
use album::Album;
use maud::{Markup, html};
use std::path::Path;

/// The page; pictures are read from `folder` and embedded.
pub fn html(folder: &Path, view: &ReportView<'_>, charts: &[Drawing], sheets: &[Sheet]) -> String {
    let mut album = Album::new(folder);
    let name = experiment_name(view);
    page(&Page {
        title: &name,
        style: "",
        header: PageHeader {
            kicker: "occlab · how clouds shadow themselves",
            heading: &name,
            adapter: adapter(view),
            summary: summary(view),
            links: links(view),
        },
        main: html! {
            (tail::failures(view))
            (choose::section(view))
            (pictures::section(view, &mut album, sheets))
            (errors::section(view, &mut album))
            (reconstructions::section(view))
            (figures::section(view, charts))
            (table::section(view, &album))
            (clock::section(view))
            (tail::claims(view))
            (tail::references(view))
            (tail::environment(view))
            (tail::wall(view))
            (tail::definitions(view))
        },
        script: SCRIPT,
    })
}

/// The experiment's own name, if it has one.
fn experiment_name(view: &ReportView<'_>) -> String {
    match view.report.experiment.get("name") {
        Some(name) if !plain(name).trim().is_empty() => plain(name),
        _ => "Unnamed experiment".to_owned(),
    }
}

fn adapter(view: &ReportView<'_>) -> Markup {
    let environment = &view.report.environment;
    html! {
        "Measured on " strong { (environment.adapter) }
        @if environment.is_oracle() { " · " (environment.driver) }
        @else { " · " (environment.device_type) " · " (environment.backend) }
    }
}

fn summary(view: &ReportView<'_>) -> Markup {
    let cells = &view.report.cells;
    let environment = &view.report.environment;
    let failed = cells.iter().filter(|c| c.result.is_none()).count();
    let methods = distinct(cells.iter().map(|c| c.method.as_str()));
    let scenes = distinct(cells.iter().map(|c| c.scene.as_str())).len();
    let suns = distinct(cells.iter().map(|c| c.sun_elevation_deg)).len();
    html! {
        p {
            (parts::plural(cells.len(), "cell")) ": " (parts::plural(methods.len(), "method")) " on "
            (parts::plural(scenes, "scene")) " under " (parts::plural(suns, "sun elevation")) ". "
            @if failed > 0 { a.alarm href="#failed" { (parts::plural(failed, "cell")) " failed." } }
            @else { "None failed." }
        }
        ul.methods { @for method in &methods { li { (parts::method(method)) } } }
        @if environment.is_oracle() {
            p.note {
                "No adapter was used: the oracle rendered these pictures in f64 on the processor, each cell once. Stored "
                "values of maps are rounded as " code { "storage" } " says, nothing else is. Times are wall times of one run on "
                "this processor, with whatever else it was doing, and say nothing of a graphics processor; bytes of maps "
                "are what a device would allocate."
            }
        } @else if environment.device_type.eq_ignore_ascii_case("cpu") {
            p.note {
                "The times come from a software adapter. On a graphics processor the methods may rank differently; "
                "errors should differ by rounding alone, which has not been measured here."
            }
        }
    }
}

/// Navigation links to the sections of the page.
fn links(view: &ReportView<'_>) -> Vec<Link<'static>> {
    let measured = || view.report.cells.iter().filter_map(|c| c.result.as_ref());
    let decomposed = measured().any(|m| m.decomposition.is_some());
    let reconstructed = measured().any(|m| m.reconstruction.is_some());
    let sections = [
        ("which", "Which method?", true),
        ("pictures", "Pictures", true),
        ("errors", "Three errors", decomposed),
        (
            reconstructions::ANCHOR,
            reconstructions::heading(view),
            reconstructed,
        ),
        ("charts", "Charts", true),
        ("cells", "All cells", true),
        ("clock", "Clock", !view.report.clock.is_empty()),
        ("references", "Truths", true),
        ("environment", "Environment", true),
        ("definitions", "Definitions", true),
    ];
    let there = sections.into_iter().filter(|(.., there)| *there);
    there
        .map(|(id, words, _)| Link::Section(id, words))
        .collect()
}
