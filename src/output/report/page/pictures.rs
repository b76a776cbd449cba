//! Section of pictures: the truth beside the best setting of every method, and a chooser that compares any cell with
//! the truth.

use super::super::contact::Sheet;
use super::super::format::{error, ms, number};
use super::super::view::{CellGroup, ReportView, Shot};
use super::album::{Album, PagePicture};
use super::parts;
use crate::frame::FALSE_COLOUR_STOPS;
use crate::metrics::{Metric, metric};
use maud::{Markup, html};

/// Largest number of cards in a row on a wide screen; the cards are spread evenly over the rows.
const MOST_COLUMNS: usize = 6;

/// The section, one sheet for each case.
pub fn section(view: &ReportView<'_>, album: &mut Album, sheets: &[Sheet]) -> Markup {
    html! {
        section #pictures {
            h2 { "Pictures" }
            p {
                "The truth, then the setting of each method with the smallest error. Below each picture its signed "
                "difference from the truth; one colour scale serves all differences of a scene. "
                "Measured on " (view.adapter()) "."
            }
            @for case in &view.cases {
                (sheet(view, case, album, sheets.iter().find(|s| s.case == case.number)))
            }
        }
    }
}

fn sheet(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    album: &mut Album,
    file: Option<&Sheet>,
) -> Markup {
    let best: Vec<(&str, Option<Shot<'_>>)> = case
        .methods()
        .into_iter()
        .map(|m| (m, case.by_error(m).first().copied()))
        .collect();
    let cards = best.len() + 1;
    let columns = cards.div_ceil(cards.div_ceil(MOST_COLUMNS));
    html! {
        article.case data-case=(case.number) {
            h3 { (case.name) }
            div.sheet style={ "--columns:" (columns) } {
                (truth(case, album))
                @for (method, shot) in &best {
                    @match shot {
                        Some(shot) => (card(view, case, shot, album)),
                        None => figure { p.notice { (parts::method(method)) " has no picture: all its cells failed." } },
                    }
                }
            }
            (compare(view, case, &best, album))
            @if let Some(file) = file {
                p.unit { "Truth and methods as one picture: " a href={ "./charts/" (file.file) } { (file.file) } }
            }
        }
    }
}

fn truth(case: &CellGroup<'_>, album: &mut Album) -> Markup {
    let picture = match case.reference {
        Some(reference) => album.show(&reference.files, "png"),
        None => PagePicture::Missing("the report has no truth for this scene and sun".to_owned()),
    };
    html! {
        figure.truth {
            (image(&picture, &format!("truth of {}", case.name), "truth"))
            figcaption {
                p { (parts::method("truth")) }
                dl.numbers {
                    @let times = case.reference.map(|r| (r.march_ms, r.wall_ms)).unwrap_or_default();
                    @match times {
                        (None, Some(wall_ms)) => { dt { "wall" } dd { (ms(Some(wall_ms))) } }
                        (march_ms, _) => { dt { "march" } dd { (ms(march_ms)) } }
                    }
                    @if case.reference.is_some_and(|r| r.cached) { dt { "source" } dd { "cache" } }
                }
                (color_bar(case))
            }
        }
    }
}

/// Colour bar of the differences; its ends are the record's `diff_scale`, where there is one.
fn color_bar(case: &CellGroup<'_>) -> Markup {
    let scale = case.diff_scale();
    let end = |sign: &str, word: &str| match scale {
        Some(s) => format!("{sign}{s}"),
        None => word.to_owned(),
    };
    html! {
        div.colorbar {
            p { "difference" @if scale.is_some() { ", ΔL / mean L" } }
            div.bar role="img" aria-label="blue: darker than the truth, white: equal, red: brighter" style=(gradient()) {}
            div.ends { span { (end("−", "darker")) } span { "0" } span { (end("+", "brighter")) } }
        }
    }
}

/// CSS gradient of the false colours used in the difference pictures.
fn gradient() -> String {
    let stop = |(_, [r, g, b]): &(f32, [u8; 3])| format!("rgb({r} {g} {b})");
    let stops: Vec<String> = FALSE_COLOUR_STOPS.iter().map(stop).collect();
    format!("background:linear-gradient(90deg,{})", stops.join(","))
}

fn card(view: &ReportView<'_>, case: &CellGroup<'_>, shot: &Shot<'_>, album: &mut Album) -> Markup {
    let cell = shot.cell;
    let files = &shot.numbers.files;
    let name = format!("{} of {}", view.short(cell), case.name);
    html! {
        figure data-cell=(cell.index) {
            (image(&album.show(files, "png"), &name, "picture"))
            figcaption {
                p { (parts::method(&cell.method)) " " (parts::setting(view, shot)) }
                (numbers(shot))
            }
            (image(&album.show(files, "diff_png"), &format!("difference of {name}"), "diff"))
        }
    }
}

/// Error numbers shown on a card.
const CARD: [&Metric; 3] = [metric("rel_rmse"), metric("leak"), metric("darken")];

fn numbers(shot: &Shot<'_>) -> Markup {
    html! {
        dl.numbers {
            @for metric in CARD { dt { (metric.key) } dd { (error(metric, &shot.numbers.error)) } }
            dt { "time" } dd { (ms(shot.time_ms())) }
            dt { "map" } dd { (shot.memory()) }
        }
    }
}

/// A picture, or a notice with the reason in its place.
pub fn image(picture: &PagePicture, name: &str, class: &str) -> Markup {
    match picture {
        PagePicture::Embedded { uri, link, size } => html! {
            a.frame href=(link) {
                img class=(class) src=(uri) width=(size.0) height=(size.1) alt=(name) loading="lazy";
            }
        },
        PagePicture::Linked { link } => html! {
            a.frame href=(link) { img class=(class) src=(link) alt=(name) loading="lazy"; }
        },
        PagePicture::Missing(reason) => html! {
            div.notice.missing role="img" aria-label=(name) { strong { "Picture missing. " } (reason) "." }
        },
    }
}

/// Chooser of a cell to compare, hidden where scripts do not run. Cells with a card on the sheet reuse its pictures.
fn compare(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    best: &[(&str, Option<Shot<'_>>)],
    album: &mut Album,
) -> Markup {
    let on_sheet = |s: &Shot<'_>| {
        best.iter()
            .any(|(_, b)| b.as_ref().is_some_and(|b| b.cell.index == s.cell.index))
    };
    let shots = case.shots();
    if shots.is_empty() {
        return html! {};
    }
    html! {
        details.compare hidden {
            summary { "Compare any cell with the truth" }
            label {
                "Cell: "
                select {
                    @for shot in &shots {
                        option value=(shot.cell.index) {
                            (view.short(shot.cell)) " · rel_rmse " (number(shot.rel_rmse()))
                        }
                    }
                }
            }
            div.stage {
                figure { img.left alt="truth"; figcaption { "truth" } }
                figure { img.right alt="chosen cell"; figcaption.chosen {} }
                figure { img.delta alt="difference"; figcaption { (color_bar(case)) } }
            }
            @for shot in &shots {
                @let files = &shot.numbers.files;
                div.stored hidden data-cell=(shot.cell.index) data-title=(view.short(shot.cell)) {
                    @if !on_sheet(shot) {
                        (stored(&album.show_if_room(files, "png"), "picture"))
                        (stored(&album.show_if_room(files, "diff_png"), "diff"))
                    }
                    (numbers(shot))
                }
            }
        }
    }
}

/// A picture stored for the chooser, decoded only when it is chosen.
fn stored(picture: &PagePicture, class: &str) -> Markup {
    match picture {
        PagePicture::Embedded { uri, .. } => html! { span class=(class) data-src=(uri) {} },
        PagePicture::Linked { link } => html! { span class=(class) data-src=(link) {} },
        PagePicture::Missing(reason) => html! { span class=(class) data-missing=(reason) {} },
    }
}
