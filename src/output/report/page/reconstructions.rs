//! Section on reconstructed pictures: time of one frame against a full picture, and error against the full render with
//! the camera at rest and in motion.

use super::super::charts::ghosting::motion;
use super::super::format::{bytes, number, percent};
use super::super::view::{CellGroup, ReportView, Shot, distinct};
use super::parts::{self, cell};
use crate::batch::record::{Ghosting, ReconstructionNumbers};
use crate::metrics::summarise;
use crate::scene::{CameraTrack, ReconstructionInfo, RestInfo};
use maud::{Markup, html};

/// Id of the section.
pub const ANCHOR: &str = "reconstruction";

/// Heading of the section: the name of the reconstruction where the report has only one.
pub fn heading(view: &ReportView<'_>) -> &'static str {
    match view.reconstructions() {
        [only] => only.title,
        _ => "Reconstruction",
    }
}

/// Sentences on how a frame is rendered and when a camera at rest converges.
fn frame(info: &ReconstructionInfo) -> String {
    let RestInfo { frames, exact } = info.rest;
    let rest = match exact {
        true => "A camera at rest sees the full picture after",
        false => "The picture of a camera at rest changes no more after",
    };
    let frames = match frames {
        1 => "one frame".to_owned(),
        4 => "four frames".to_owned(),
        n => format!("{n} frames"),
    };
    let words = info.frame;
    format!("{words} {rest} {frames}; times are those of a camera at rest.")
}

/// The section; empty where every cell is `full`.
pub fn section(view: &ReportView<'_>) -> Markup {
    if view.cases.iter().all(|case| cells(case).is_empty()) {
        return html! {};
    }
    let several = view.reconstructions().len() > 1;
    html! {
        section id=(ANCHOR) {
            h2 { (heading(view)) }
            p {
                @for info in view.reconstructions() {
                    @if several { code { (info.id) } ": " }
                    (frame(info)) " "
                }
                "Ghosting is the relative RMSE of each frame of a moving camera against the full render "
                "of that frame by the same method, over pixels where either shows cloud. Truth and other methods play no "
                "part in it, and the map is made anew in every frame."
            }
            @for case in &view.cases {
                @let (cells, curves) = (cells(case), curves(case));
                @if !cells.is_empty() { h3 { (case.name) } (costs(view, case, &cells)) }
                @if !curves.is_empty() { (ghosting(view, &curves)) }
            }
        }
    }
}

fn cells<'a>(case: &CellGroup<'a>) -> Vec<(Shot<'a>, &'a ReconstructionNumbers)> {
    let parts = |shot: Shot<'a>| Some((shot, shot.numbers.reconstruction.as_ref()?));
    case.shots().into_iter().filter_map(parts).collect()
}

/// Ghosting curves of the case, grouped by camera track.
fn curves<'a>(case: &CellGroup<'a>) -> Vec<(Shot<'a>, CameraTrack, &'a Ghosting)> {
    let of = |track| {
        let curve = move |(shot, parts): (Shot<'a>, &'a ReconstructionNumbers)| {
            Some((shot, track, parts.ghosting.get(&track)?))
        };
        cells(case).into_iter().filter_map(curve)
    };
    CameraTrack::ALL.into_iter().flat_map(of).collect()
}

/// The cell with the same method and parameters that marches every pixel.
fn full<'a>(case: &CellGroup<'a>, shot: &Shot<'_>) -> Option<Shot<'a>> {
    let mut params = shot.cell.params.clone();
    params.remove("reconstruct");
    let same = |s: &Shot<'_>| {
        s.cell.reconstruct.is_full() && s.cell.method == shot.cell.method && s.cell.params == params
    };
    case.shots().into_iter().find(same)
}

/// Time of a frame over that of a full picture: median of the ratios in each round, or the ratio of the medians where
/// rounds are not recorded or differ in number.
fn ratio(frame: &Shot<'_>, full: &Shot<'_>) -> Option<f64> {
    let rounds = [frame, full].map(|shot| &shot.numbers.rounds_total_ms);
    let pairs = rounds[0].iter().zip(rounds[1]);
    let ratios = pairs.filter_map(|(a, b)| Some((*a)? / (*b)?));
    let ratios: Vec<f64> = ratios.filter(|r| r.is_finite()).collect();
    match summarise(&ratios) {
        Some(stats) if rounds[0].len() == rounds[1].len() => Some(stats.median),
        _ => Some(frame.time_ms()? / full.time_ms()?),
    }
}

fn costs(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    cells: &[(Shot<'_>, &ReconstructionNumbers)],
) -> Markup {
    let head = html! {
        th scope="col" { "Method" }
        th scope="col" { "Setting" }
        @for name in [
            "Full ms", "Frame ms", "Frame ÷ full", "March ms", "Reconstruct ms", "Error at rest", "History",
        ] { th.n scope="col" { (name) } }
    };
    let body = html! {
        @for (shot, parts) in cells {
            @let full = full(case, shot);
            @let times = &shot.numbers.time_ms;
            tr {
                td { (parts::method(&shot.cell.method)) }
                td { (parts::setting(view, shot)) }
                (cell(full.and_then(|full| full.time_ms()), number))
                (cell(shot.time_ms(), number))
                (cell(full.and_then(|full| ratio(shot, &full)), percent))
                (cell(times.march.map(|t| t.median), number))
                (cell(times.reconstruct.map(|t| t.median), number))
                (cell(Some(parts.full_rel_rmse), number))
                (cell(Some(parts.history_bytes as f64), |_| bytes(parts.history_bytes)))
            }
        }
    };
    let infos = distinct(cells.iter().map(|(shot, _)| shot.cell.reconstruct));
    let caption = html! {
        "Median times of a full picture, of one frame (" (shares(&infos)) " of the pixels marched) and of its passes, camera at "
        "rest; the ratio is the median of those inside rounds. Relative RMSE against the full render; bytes of " (history(&infos))
        "." (super::clock::sentence(view))
    };
    parts::table(view, caption, "small", head, body)
}

/// Text on the share of pixels that a frame marches.
fn shares(infos: &[&ReconstructionInfo]) -> String {
    distinct(infos.iter().map(|info| info.share())).join(" or ")
}

/// Text on the contents of the history.
fn history(infos: &[&ReconstructionInfo]) -> String {
    let histories = infos.iter().filter_map(|info| info.history);
    match distinct(histories.map(|history| history.what)).as_slice() {
        [] => "what is remembered: none".to_owned(),
        all => all.join(" or "),
    }
}

fn ghosting(view: &ReportView<'_>, curves: &[(Shot<'_>, CameraTrack, &Ghosting)]) -> Markup {
    let head = html! {
        th scope="col" { "Movement" }
        th scope="col" { "Method" }
        th scope="col" { "Setting" }
        @for name in ["First step", "Last frame", "Largest"] { th.n scope="col" { (name) } }
    };
    let body = html! {
        @for (shot, track, curve) in curves {
            @let errors = &curve.rel_rmse;
            tr {
                td title=(motion(curve)) { (track.name()) }
                td { (parts::method(&shot.cell.method)) }
                td { (parts::setting(view, shot)) }
                (cell(errors.get(1).copied(), number))
                (cell(errors.last().copied(), number))
                (cell(errors.iter().copied().reduce(f64::max), number))
            }
        }
    };
    let steps = CameraTrack::ALL.into_iter().filter_map(|track| {
        let (.., curve) = curves.iter().find(|(_, t, _)| *t == track)?;
        Some(format!("{}: {}", track.name(), motion(curve)))
    });
    let steps: Vec<String> = steps.collect();
    let caption = format!("Ghosting, relative RMSE. {}", steps.join(" "));
    parts::table(view, caption, "small", head, body)
}
