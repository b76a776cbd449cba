//! `index.html`: the whole report as one page that needs no network.

pub(crate) mod album;
mod choose;
mod clock;
mod errors;
pub(crate) mod figures;
mod frontier;
pub(crate) mod parts;
pub(crate) mod pictures;
mod table;
mod tail;
mod temporal;

use super::charts::Chart;
use super::contact::Sheet;
use super::format::shorten;
use super::view::{View, distinct, plain};
use album::Album;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::path::Path;

/// The page; pictures are read from `folder` and embedded.
pub fn html(folder: &Path, view: &View<'_>, charts: &[Chart], sheets: &[Sheet]) -> String {
    let mut album = Album::new(folder);
    let name = experiment_name(view);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (shorten(&name, 80)) " · occlab" }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                (headline(view, &name))
                main {
                    (tail::failures(view))
                    (choose::section(view))
                    (pictures::section(view, &mut album, sheets))
                    (errors::section(view, &mut album))
                    (temporal::section(view))
                    (figures::section(view, charts))
                    (table::section(view, &album))
                    (clock::section(view))
                    (tail::claims(view))
                    (tail::references(view))
                    (tail::environment(view))
                    (tail::wall(view))
                    (tail::definitions(view))
                }
                script { (PreEscaped(include_str!("script.js"))) }
            }
        }
    };
    page.into_string()
}

/// The experiment's own name, if it has one.
fn experiment_name(view: &View<'_>) -> String {
    match view.report.experiment.get("name") {
        Some(name) if !plain(name).trim().is_empty() => plain(name),
        _ => "Unnamed experiment".to_owned(),
    }
}

fn headline(view: &View<'_>, name: &str) -> Markup {
    let cells = &view.report.cells;
    let environment = &view.report.environment;
    let failed = cells.iter().filter(|c| c.result.is_none()).count();
    let methods = distinct(cells.iter().map(|c| c.method.as_str()));
    let scenes = distinct(cells.iter().map(|c| c.scene.as_str())).len();
    let suns = distinct(cells.iter().map(|c| c.sun_elevation_deg)).len();
    let mut measured = cells.iter().filter_map(|c| c.result.as_ref());
    let decomposed = measured.any(|m| m.decomposition.is_some());
    let mut measured = cells.iter().filter_map(|c| c.result.as_ref());
    let temporal = measured.any(|m| m.reconstruction.is_some());
    html! {
        header {
            p.kicker { "occlab · how clouds shadow themselves" }
            h1 { (name) }
            p.adapter {
                "Measured on " strong { (environment.adapter) }
                @if environment.is_oracle() { " · " (environment.driver) }
                @else { " · " (environment.device_type) " · " (environment.backend) }
            }
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
            nav {
                @for (anchor, text) in [
                    ("which", "Which method?"), ("pictures", "Pictures"), ("errors", "Three errors"), ("temporal", "Temporal integration"),
                    ("charts", "Charts"),
                    ("cells", "All cells"), ("clock", "Clock"), ("references", "Truths"), ("environment", "Environment"), ("definitions", "Definitions"),
                ] {
                    @let there = match anchor {
                        "errors" => decomposed,
                        "temporal" => temporal,
                        "clock" => !view.report.clock.is_empty(),
                        _ => true,
                    };
                    @if there { a href={ "#" (anchor) } { (text) } }
                }
            }
        }
    }
}
