//! Small pieces that every section of a report uses.

pub use super::super::shell::parts::{cell, heading, method, plural};

use super::super::shell;
use super::super::view::{ReportView, Shot, all_params};
use maud::{Markup, Render, html};

/// The setting of a cell, every parameter on hover.
pub fn setting(view: &ReportView<'_>, shot: &Shot<'_>) -> Markup {
    let text = view.setting(shot.cell);
    html! { span.setting title=(all_params(shot.cell)) { @if text.is_empty() { "–" } @else { (text) } } }
}

/// A table in a container of its own that scrolls, with a caption that names the adapter.
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
