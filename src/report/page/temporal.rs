//! Temporal integration: what a frame costs beside a full picture, and what it leaves of the picture on a pan.

use super::super::format::{bytes, number, percent};
use super::super::view::{Case, Shot, View};
use super::parts::{self, cell};
use crate::batch::record::Reconstruction;
use maud::{Markup, html};

/// The section; nothing where every cell is `full`.
pub fn section(view: &View<'_>) -> Markup {
    if view.cases.iter().all(|case| cells(case).is_empty()) {
        return html! {};
    }
    html! {
        section #temporal {
            h2 { "Temporal integration" }
            p {
                "A frame marches one pixel of every 2 × 2 block; the others come from the picture before, reprojected by "
                "the mean depth of what is seen. A camera at rest sees the full picture after four frames. Ghosting is "
                "the relative RMSE of each frame of a pan against the full render of that frame by the same method. "
                "Truth and other methods play no part in it, and the map is made anew in every frame."
            }
            @for case in &view.cases {
                @if !cells(case).is_empty() { h3 { (case.name) } (table(view, case)) }
            }
        }
    }
}

fn cells<'a>(case: &Case<'a>) -> Vec<(Shot<'a>, &'a Reconstruction)> {
    let parts = |shot: Shot<'a>| Some((shot, shot.numbers.reconstruction.as_ref()?));
    case.shots().into_iter().filter_map(parts).collect()
}

/// Time of the cell that differs in nothing but marching every pixel, ms.
fn full_ms(case: &Case<'_>, shot: &Shot<'_>) -> Option<f64> {
    let mut params = shot.cell.params.clone();
    params.remove("reconstruct");
    let same = |s: &Shot<'_>| {
        s.cell.reconstruct.is_full() && s.cell.method == shot.cell.method && s.cell.params == params
    };
    case.shots().iter().find(|s| same(s))?.time_ms()
}

fn table(view: &View<'_>, case: &Case<'_>) -> Markup {
    let head = html! {
        th scope="col" { "Method" }
        th scope="col" { "Setting" }
        @for name in [
            "Full ms", "Frame ms", "Frame ÷ full", "March ms", "Reconstruct ms", "At rest", "First step", "Last frame",
            "Largest", "History",
        ] { th.n scope="col" { (name) } }
    };
    let body = html! {
        @for (shot, r) in cells(case) {
            @let full = full_ms(case, &shot);
            @let own = shot.time_ms();
            @let curve = &r.ghosting_rel_rmse;
            @let times = &shot.numbers.time_ms;
            tr {
                td { (parts::method(&shot.cell.method)) }
                td { (parts::setting(view, &shot)) }
                (cell(full, number))
                (cell(own, number))
                (cell(own.zip(full).map(|(a, b)| a / b), percent))
                (cell(times.march.map(|t| t.median), number))
                (cell(times.reconstruct.map(|t| t.median), number))
                (cell(Some(r.full_rel_rmse), number))
                (cell(curve.get(1).copied(), number))
                (cell(curve.last().copied(), number))
                (cell(curve.iter().copied().reduce(f64::max), number))
                (cell(Some(r.history_bytes as f64), |_| bytes(r.history_bytes)))
            }
        }
    };
    let caption = "Median times of a full picture, of a frame and of its passes; relative RMSE at rest and on the pan; \
        bytes of the two pictures that are remembered.";
    parts::table(view, caption, "small", head, body)
}
