//! Markup shared by the sections of a report: cells of tables, headings, settings, tables.

pub use super::super::shell::parts::{cell, heading, method, plural};

use super::super::shell;
use super::super::view::{ReportView, Shot, all_params};
use maud::{Markup, Render, html};

/// Setting of a cell, with all its parameters in the tooltip.
pub fn setting(view: &ReportView<'_>, shot: &Shot<'_>) -> Markup {
    let text = view.setting(shot.cell);
    html! { span.setting title=(all_params(shot.cell)) { @if text.is_empty() { "–" } @else { (text) } } }
}

/// Table in a scrolling container, with a caption that names the adapter.
pub fn table(
    view: &ReportView<'_>,
    caption: impl Render,
    class: &str,
    head: impl Render,
    body: impl Render,
) -> Markup {
    let adapter = format!("Adapter: {}", view.adapter());
    shell::parts::table(adapter, caption, class, head, body)
}
