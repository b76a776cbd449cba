//! Markup shared by all pages: methods, numbers, tables, charts.

use super::super::charts::WIDTH;
use super::super::format::NONE;
use super::super::style::Style;
use maud::{Markup, PreEscaped, Render, html};
use std::fmt::Write as _;

/// A method's marker and name.
pub fn method(id: &str) -> Markup {
    html! { span.method { (swatch(id)) span { (id) } } }
}

/// A method's marker as inline SVG, the same as in the charts.
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

/// Table cell that sorts by `value`; without a finite value it reads "n/a" and sorts last.
pub fn cell(value: Option<f64>, text: impl FnOnce(f64) -> String) -> Markup {
    match value.filter(|v| v.is_finite()) {
        Some(v) => html! { td.n data-v=(v) { (text(v)) } },
        None => html! { td.n.na { (NONE) } },
    }
}

/// Heading of a sortable column with its unit; right-aligned for columns of numbers.
pub fn heading(name: &str, unit: &str, numeric: bool) -> Markup {
    html! {
        th.n[numeric] scope="col" aria-sort="none" {
            button type="button" { (name) @if !unit.is_empty() { " " span.unit { (unit) } } }
        }
    }
}

/// Table in a scrolling container, with a caption that ends with the source of its numbers.
pub fn table(
    source: impl Render,
    caption: impl Render,
    class: &str,
    head: impl Render,
    body: impl Render,
) -> Markup {
    table_of(source, caption, class, html! { tr { (head) } }, body)
}

/// [`table`] with several rows in its head.
pub fn table_of(
    source: impl Render,
    caption: impl Render,
    class: &str,
    head_rows: impl Render,
    body: impl Render,
) -> Markup {
    html! {
        figure.table {
            figcaption { (caption) " " span.where { (source) } }
            div.scroll tabindex="0" {
                table class=(class) {
                    thead { (head_rows) }
                    tbody { (body) }
                }
            }
        }
    }
}

/// Chart in a scrolling frame; `alt` is its text alternative.
pub fn chart(alt: &str, svg: &str, caption: Option<Markup>) -> Markup {
    html! {
        figure.chart {
            (picture(alt, svg))
            @if let Some(caption) = caption { figcaption { (caption) } }
        }
    }
}

/// The picture of a [`chart`] without its frame and caption.
pub fn picture(alt: &str, svg: &str) -> Markup {
    html! { div.scroll tabindex="0" role="img" aria-label=(alt) { (PreEscaped(fluid(svg))) } }
}

/// The SVG without its fixed size, so that it fills its container. Its text is already escaped.
fn fluid(svg: &str) -> String {
    let fixed = format!("<svg width=\"{WIDTH}\" height=\"");
    let rest = svg.strip_prefix(&fixed);
    match rest.and_then(|rest| rest.split_once("\" ")) {
        Some((_, rest)) => format!("<svg {rest}"),
        None => svg.to_owned(),
    }
}

/// Section with the definition of each number of the page, followed by `below`.
pub fn definitions(entries: &[(&str, &str)], below: impl Render) -> Markup {
    html! {
        section #definitions {
            h2 { "Definitions" }
            dl.pairs { @for (name, meaning) in entries { dt { (name) } dd { (meaning) } } }
            (below)
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
