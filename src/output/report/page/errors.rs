//! Section with the three error terms of decomposed cells: signed difference pictures side by side, on one scale.

use super::super::format::{number, written};
use super::super::view::{CellGroup, ReportView, Shot};
use super::album::Album;
use super::parts;
use super::pictures::image;
use crate::batch::numbers::{CellNumber, PagePlace, numbers};
use crate::batch::record::Decomposition;
use maud::{Markup, html};

/// The section; empty where no cell was decomposed.
pub fn section(view: &ReportView<'_>, album: &mut Album) -> Markup {
    let decomposed = |case: &&CellGroup<'_>| !cells(case).is_empty();
    let cases: Vec<&CellGroup<'_>> = view.cases.iter().filter(decomposed).collect();
    if cases.is_empty() {
        return html! {};
    }
    html! {
        section #errors {
            h2 { "Three errors" }
            p {
                "Each difference from the truth is the sum of three signed pictures: " strong { "model" } ", what the "
                "encoding cannot say (f64, ample steps and texels, minus the f64 truth); " strong { "sampling" } ", what the "
                "cell's own steps and texels add (f64); " strong { "precision" } ", the cell's picture minus the f64 one at "
                "its settings: stored values, f32 arithmetic, and the device's filtering of noise beyond what the f64 "
                "picture emulates. The pictures add up, their RMSEs do not. All have the scale of the difference pictures."
            }
            @for case in cases {
                article {
                    h3 { (case.name) }
                    @for (shot, decomposition) in cells(case) { (row(view, case, &shot, decomposition, album)) }
                    (table(view, case))
                }
            }
        }
    }
}

fn cells<'a>(case: &CellGroup<'a>) -> Vec<(Shot<'a>, &'a Decomposition)> {
    let parts = |shot: Shot<'a>| Some((shot, shot.numbers.decomposition.as_ref()?));
    case.shots().into_iter().filter_map(parts).collect()
}

fn row(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    shot: &Shot<'_>,
    parts_of: &Decomposition,
    album: &mut Album,
) -> Markup {
    let pictures = [
        ("difference", "diff_png", shot.rel_rmse()),
        ("model", "model_png", parts_of.model_rel_rmse),
        ("sampling", "sampling_png", parts_of.sampling_rel_rmse),
        ("precision", "precision_png", parts_of.precision_rel_rmse),
    ];
    html! {
        p { (parts::method(&shot.cell.method)) " " (parts::setting(view, shot)) }
        div.sheet style="--columns:4" {
            @for (name, key, rmse) in pictures {
                @let alt = format!("{name} of {} of {}", view.short(shot.cell), case.name);
                figure {
                    (image(&album.show_if_room(&shot.numbers.files, key), &alt, "diff"))
                    figcaption { p { (name) " " strong { (number(rmse)) } } }
                }
            }
        }
    }
}

/// The numbers of a decomposition.
fn columns() -> impl Iterator<Item = &'static CellNumber> {
    let numbers = numbers().iter();
    numbers.filter(|number| number.shown == PagePlace::Decomposition)
}

fn table(view: &ReportView<'_>, case: &CellGroup<'_>) -> Markup {
    let head = html! {
        th scope="col" { "Method" }
        th scope="col" { "Setting" }
        th.n scope="col" { "Total" }
        @for column in columns() { th.n scope="col" { (column.label) } }
        th scope="col" { "Noise filter" }
    };
    let body = html! {
        @for (shot, decomposition) in cells(case) {
            tr {
                td { (parts::method(&shot.cell.method)) }
                td { (parts::setting(view, &shot)) }
                (parts::cell(Some(shot.rel_rmse()), number))
                @for column in columns() {
                    (parts::cell(column.value(shot.numbers), |value| written(column.format, value)))
                }
                td { (decomposition.noise_filter.as_deref().unwrap_or("no noise")) }
            }
        }
    };
    let caption = "RMS over that of the truth. Of it storage: what rounding of stored map values does alone. Truths: the f64 truth minus the one that cells are compared with; the three \
        pictures add up to the difference but for this.";
    parts::table(view, caption, "small", head, body)
}
