//! Small pieces that every section uses.

use super::super::format::NONE;
use super::super::style::Style;
use super::super::view::{Shot, View, all_params};
use maud::{Markup, PreEscaped, Render, html};
use std::fmt::Write as _;

/// A method's marker and name.
pub fn method(id: &str) -> Markup {
    html! { span.method { (swatch(id)) span { (id) } } }
}

/// A method's marker as a tiny picture, the same as in the charts.
fn swatch(id: &str) -> PreEscaped<String> {
    let style = Style::of(id);
    let shape = match style.corners(5.2) {
        None => "<circle r=\"5.2\"/>".to_owned(),
        Some(corners) => {
            let mut points = String::new();
            for (x, y) in corners {
                let _ = write!(points, "{x:.1},{y:.1} "); // writing to a String cannot fail
            }
            format!("<polygon points=\"{}\"/>", points.trim_end())
        }
    };
    PreEscaped(format!(
        "<svg class=\"swatch\" viewBox=\"-9 -9 18 18\" width=\"18\" height=\"18\" aria-hidden=\"true\"><g fill=\"{}\" \
         stroke=\"#222\" stroke-width=\"1\">{shape}</g></svg>",
        style.hex()
    ))
}

/// The setting of a cell, every parameter on hover.
pub fn setting(view: &View<'_>, shot: &Shot<'_>) -> Markup {
    let text = view.setting(shot.cell);
    html! { span.setting title=(all_params(shot.cell)) { @if text.is_empty() { "–" } @else { (text) } } }
}

/// A cell of a table that sorts by `value`; without one it reads "n/a" and sorts last.
pub fn cell(value: Option<f64>, text: impl FnOnce(f64) -> String) -> Markup {
    match value.filter(|v| v.is_finite()) {
        Some(v) => html! { td.n data-v=(v) { (text(v)) } },
        None => html! { td.n.na { (NONE) } },
    }
}

/// A heading of a sortable column with its unit; those of numbers stand at the right, as the numbers do.
pub fn heading(name: &str, unit: &str, numeric: bool) -> Markup {
    html! {
        th.n[numeric] scope="col" aria-sort="none" {
            button type="button" { (name) @if !unit.is_empty() { " " span.unit { (unit) } } }
        }
    }
}

/// A table in a container of its own that scrolls, with a caption that names the adapter.
pub fn table(
    view: &View<'_>,
    caption: impl Render,
    class: &str,
    head: impl Render,
    body: impl Render,
) -> Markup {
    html! {
        figure.table {
            figcaption { (caption) " " span.where { "Adapter: " (view.adapter()) } }
            div.scroll tabindex="0" {
                table class=(class) {
                    thead { tr { (head) } }
                    tbody { (body) }
                }
            }
        }
    }
}

/// `1 cell`, `3 cells`.
pub fn plural(n: usize, noun: &str) -> String {
    if n == 1 {
        format!("1 {noun}")
    } else {
        format!("{n} {noun}s")
    }
}
