//! Section of the study page with pictures: every setting of the chosen experiments beside its truth, with error
//! numbers and the signed difference.

use super::super::EXPERIMENTS;
use super::super::select::Records;
use super::report_link;
use crate::config::Study;
use crate::metrics::{Metric, metric};
use crate::report::format::error;
use crate::report::page::album::{Album, PagePicture};
use crate::report::page::parts;
use crate::report::page::pictures::image;
use crate::report::view::{CellGroup, ReportView, Shot};
use maud::{Markup, html};
use serde_json::{Map, Value};
use std::path::Path;

/// Cards beside each other on a wide screen.
const COLUMNS: usize = 5;

/// Error numbers of a card with their names on it.
const CARD: [(&str, &Metric); 4] = [
    ("rel_rmse", metric("rel_rmse")),
    ("leak", metric("leak")),
    ("darken", metric("darken")),
    ("FLIP", metric("flip_mean")),
];

/// The section; empty where the study shows no pictures.
pub fn section(folder: &Path, study: &Study, records: &Records<'_>) -> Markup {
    let mut album = Album::new(folder);
    let shown = study.pictures.iter();
    let reports: Vec<_> = shown.filter_map(|id| records.report(id).ok()).collect();
    html! {
        @if !reports.is_empty() {
            section #pictures {
                h2 { "Pictures" }
                p {
                    "The truth, then every setting; below each picture its signed difference from the truth, blue where it is darker "
                    "and red where it is brighter, on one scale."
                }
                @for (id, report) in reports {
                    @let view = ReportView::new(report);
                    @for case in &view.cases {
                        article {
                            h3 { (case.name) " · " a href=(report_link(id)) { "report of `" (id) "`" } }
                            div.sheet style={ "--columns:" (COLUMNS) } {
                                (truth(id, case, &mut album))
                                @for shot in case.shots() { (card(id, &view, &shot, &mut album)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Files of a record with their paths relative to the study's folder.
fn files_below(experiment: &str, files: &Map<String, Value>) -> Map<String, Value> {
    let below = |(key, value): (&String, &Value)| {
        let path = format!("{EXPERIMENTS}/{experiment}/{}", value.as_str()?);
        Some((key.clone(), path.into()))
    };
    files.iter().filter_map(below).collect()
}

fn truth(experiment: &str, case: &CellGroup<'_>, album: &mut Album) -> Markup {
    let picture = match case.reference {
        Some(reference) => album.show(&files_below(experiment, &reference.files), "png"),
        None => PagePicture::Missing("the report has no truth".to_owned()),
    };
    html! {
        figure.truth {
            (image(&picture, &format!("truth of {}", case.name), "truth"))
            figcaption { p { (parts::method("truth")) } }
        }
    }
}

fn card(experiment: &str, view: &ReportView<'_>, shot: &Shot<'_>, album: &mut Album) -> Markup {
    let files = files_below(experiment, &shot.numbers.files);
    let name = view.short(shot.cell);
    html! {
        figure {
            (image(&album.show(&files, "png"), &name, "picture"))
            figcaption {
                p { (parts::method(&shot.cell.method)) " " (parts::setting(view, shot)) }
                dl.numbers {
                    @for (name, metric) in CARD { dt { (name) } dd { (error(metric, &shot.numbers.error)) } }
                    dt { "cell" } dd { a href={ (report_link(experiment)) "#cell-" (shot.cell.index) } { (shot.cell.index) } }
                }
            }
            (image(&album.show(&files, "diff_png"), &format!("difference of {name}"), "diff"))
        }
    }
}
