//! Section "Which method?": the fastest setting within an error limit and the smallest error within a budget, for each
//! view and for all views.

use super::super::format::{map_size, maybe, memory_size, ms, number};
use super::super::view::{CellGroup, ReportView, Shot, distinct};
use super::{frontier, parts, reconstructions};
use crate::scene::ReconstructionInfo;
use maud::{Markup, html};
use std::cmp::Ordering;

/// Limits of the relative RMSE, one column of the first table each.
const LIMITS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.5];

/// Error, time (ms) and memory (bytes) of a setting in one view, or the worst values over all views.
struct Offer<'a> {
    shot: Shot<'a>,
    rel_rmse: f64,
    total_ms: Option<f64>,
    map_bytes: u64,
    history_bytes: u64,
}

impl<'a> Offer<'a> {
    fn new(shot: Shot<'a>) -> Self {
        Self {
            shot,
            rel_rmse: shot.rel_rmse(),
            total_ms: shot.time_ms(),
            map_bytes: shot.map_bytes(),
            history_bytes: shot.history_bytes(),
        }
    }

    /// Maximum of each number over two views; `None` for the time where it is missing in either.
    fn worse(mut self, other: &Shot<'_>) -> Self {
        self.rel_rmse = self.rel_rmse.max(other.rel_rmse());
        self.total_ms = self.total_ms.zip(other.time_ms()).map(|(a, b)| a.max(b));
        self.map_bytes = self.map_bytes.max(other.map_bytes());
        self.history_bytes = self.history_bytes.max(other.history_bytes());
        self
    }

    /// Order by time, then memory, then error, smallest first; offers without a time come last.
    fn by_cost(&self, other: &Self) -> Ordering {
        let time = |o: &Self| o.total_ms.unwrap_or(f64::INFINITY);
        let bytes = |o: &Self| o.map_bytes.saturating_add(o.history_bytes);
        time(self)
            .total_cmp(&time(other))
            .then(bytes(self).cmp(&bytes(other)))
            .then(self.rel_rmse.total_cmp(&other.rel_rmse))
    }
}

/// Settings that have numbers in every case, each with its worst numbers.
fn everywhere<'a>(cases: &[CellGroup<'a>]) -> Vec<Offer<'a>> {
    let Some((first, rest)) = cases.split_first() else {
        return Vec::new();
    };
    let rest: Vec<Vec<Shot<'a>>> = rest.iter().map(CellGroup::shots).collect();
    let same = |a: &Shot<'_>, b: &Shot<'_>| {
        a.cell.method == b.cell.method && a.cell.params == b.cell.params
    };
    let worst = |shot: Shot<'a>| {
        rest.iter().try_fold(Offer::new(shot), |offer, shots| {
            Some(offer.worse(shots.iter().find(|s| same(s, &shot))?))
        })
    };
    first.shots().into_iter().filter_map(worst).collect()
}

/// The section.
pub fn section(view: &ReportView<'_>) -> Markup {
    let timed = view
        .cases
        .iter()
        .any(|c| c.shots().iter().any(|s| s.time_ms().is_some()));
    html! {
        section #which {
            h2 { "Which method?" }
            @for info in view.reconstructions() { (reconstructed(view, info)) }
            @if timed {
                p { "For an error you can accept, the fastest setting that keeps it. " (MEANING) }
            } @else {
                p.notice { "No cell has a time." }
                p { "For an error you can accept, the setting with the smallest map that keeps it. " (MEANING) }
            }
            (by_error(view))
            (by_budget(view))
            h3 { "What nothing beats" }
            p {
                "The Pareto frontier of each scene and sun: the settings that no other setting beats in both cost and error."
            }
            @for case in &view.cases { (frontier::of_case(view, case)) }
        }
    }
}

/// Notice on the meaning of errors and times of reconstructed pictures.
fn reconstructed(view: &ReportView<'_>, info: &ReconstructionInfo) -> Markup {
    let loss = match (info.rest.exact, info.history.is_some()) {
        (true, _) => "What it loses in motion",
        (false, true) => "What it loses, at rest and in motion,",
        (false, false) => "What it loses",
    };
    html! {
        p.notice {
            "Errors and times here are those of a camera at rest"
            @if info.rest.exact { ", where " code { (info.id) } " loses nothing; its times" }
            @else { "; the times of " code { (info.id) } }
            " are those of one frame (" (info.share()) " of the pixels marched). " (loss) " stands under "
            a href={ "#" (reconstructions::ANCHOR) } { (reconstructions::heading(view)) } "."
        }
    }
}

/// Definition of the error used in this section.
const MEANING: &str = "The error is rel_rmse: the RMS difference of the sun-lit radiance from the truth over the \
    truth's own RMS; 0 is equal, 1 as wrong as no light at all.";

/// Name of the row for all views at once.
const EVERY_VIEW: &str = "every view";

fn by_error(view: &ReportView<'_>) -> Markup {
    let head = html! {
        th scope="col" { "Scene and sun" }
        @for limit in LIMITS { th scope="col" { "rel_rmse ≤ " (limit) } }
    };
    let row = |name: &str, offers: &[Offer<'_>]| {
        html! {
            tr {
                th scope="row" { (name) }
                @for limit in LIMITS { td data-label={ "rel_rmse ≤ " (limit) } { (answer(view, offers, limit)) } }
            }
        }
    };
    let body = html! {
        @for case in &view.cases {
            @let offers: Vec<Offer<'_>> = case.shots().into_iter().map(Offer::new).collect();
            (row(&case.name, &offers))
        }
        @if view.cases.len() > 1 { (row(EVERY_VIEW, &everywhere(&view.cases))) }
    };
    let caption = html! {
        "Median " (view.clock().name()) " time of " (view.timed()) ", bytes of the map" @if view.reconstructed() { " and the history" } "." (view.frames())
        @if view.cases.len() > 1 { " Last row: one setting for all views, by its worst error and time." }
    };
    parts::table(view, caption, "answers totals stacked", head, body)
}

/// Cheapest offer within the error limit, or else the smallest error of any offer.
fn answer(view: &ReportView<'_>, offers: &[Offer<'_>], limit: f64) -> Markup {
    let within = offers.iter().filter(|o| o.rel_rmse <= limit);
    let best = offers.iter().map(|o| o.rel_rmse).min_by(f64::total_cmp);
    match within.min_by(|a, b| a.by_cost(b)) {
        Some(offer) => html! {
            div.choice { (parts::method(&offer.shot.cell.method)) " " (parts::setting(view, &offer.shot)) }
            div { span.whole { (ms(offer.total_ms)) " ·" } " " span.whole { (memory_size(offer.map_bytes, offer.history_bytes)) } }
        },
        None => html! { span.na { "none measured" br; "least: " (maybe(best)) } },
    }
}

/// Form for the budget, hidden where scripts do not run. The script reads the cells from the table of all cells.
fn by_budget(view: &ReportView<'_>) -> Markup {
    let shots: Vec<Shot<'_>> = view.cases.iter().flat_map(CellGroup::shots).collect();
    let mut times: Vec<f64> = shots.iter().filter_map(Shot::time_ms).collect();
    times.sort_by(f64::total_cmp);
    let usual = times.get(times.len() / 2).map(|t| two_digits(*t));
    let mut sizes = distinct(shots.iter().map(Shot::memory_bytes));
    sizes.sort_unstable();
    let row = |name: &str, number: Option<usize>| {
        html! {
            tr data-view=[number] {
                th scope="row" { (name) }
                td.what {} td.with {} td.n.error {} td.n.ms {} td.n.bytes {}
            }
        }
    };
    let head = html! {
        th scope="col" { "Scene and sun" } th scope="col" { "Method" } th scope="col" { "Setting" }
        th.n scope="col" { "rel_rmse" } th.n scope="col" { "Time " span.unit { "ms" } } th.n scope="col" { (view.remembered()) }
    };
    let body = html! {
        @for case in &view.cases { (row(&case.name, Some(case.number))) }
        @if view.cases.len() > 1 { (row(EVERY_VIEW, None)) }
    };
    html! {
        div.budget hidden {
            h3 { "Within a budget" }
            p { "For the time and the memory you have, the setting with the smallest error." }
            p.fields {
                label { "Time at most " input name="ms" type="number" min="0" step="any" value=[usual]; " ms" }
                label {
                    (view.remembered()) " at most "
                    select name="bytes" {
                        option value="" { "any" }
                        @for size in sizes { option value=(size) { (map_size(size)) } }
                    }
                }
            }
            (parts::table(view, "An empty field is no limit.", "small totals", head, body))
        }
    }
}

/// A time rounded to two significant digits, for the input field.
fn two_digits(value: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    number((value / unit).round() * unit)
        .parse()
        .unwrap_or(value)
}
