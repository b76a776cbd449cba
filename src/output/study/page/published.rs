//! Section of the study page: tables of the source beside the values measured here.

use super::super::Outcome;
use super::super::table::{Entry, Table};
use super::cell_links;
use crate::report::format::{bytes, number};
use crate::report::shell::parts;
use maud::{Markup, html};

/// The section; empty where the study names no table.
pub fn section(outcome: &Outcome) -> Markup {
    html! {
        @if !outcome.tables.is_empty() {
            section #tables {
                h2 { "Tables" }
                @for table in &outcome.tables { (one(table, outcome)) }
            }
        }
    }
}

/// Fields shown for the number in this column; those of published values only where a row has one.
fn fields(table: &Table, column: usize) -> Vec<&'static str> {
    let entries = || table.rows.iter().map(|row| &row.entries[column]);
    let mut fields = Vec::new();
    if entries().any(|e| e.published.is_some()) {
        fields.push("published");
    }
    fields.push("here");
    if entries().any(|e| e.published_ratio.is_some()) {
        fields.push("÷, published");
    }
    if table.relative_to.is_some() {
        fields.push("÷, here");
    }
    fields
}

fn one(table: &Table, outcome: &Outcome) -> Markup {
    let columns: Vec<Vec<&str>> = (0..table.metrics.len()).map(|i| fields(table, i)).collect();
    let caption = html! {
        (table.figure) " · " (table.title) ". " (table.note)
        @if let Some(unit) = &table.relative_to { " ÷: over the total of " (unit) " in the same picture." }
    };
    let head = html! {
        tr {
            th scope="col" rowspan="2" { "Setting" }
            @for ((_, title), fields) in table.metrics.iter().zip(&columns) {
                th.n scope="colgroup" colspan=(fields.len()) { (title) }
            }
            th scope="col" rowspan="2" { "Cell" }
        }
        tr { @for name in columns.iter().flatten() { th.n scope="col" { (name) } } }
    };
    let body = html! { @for row in &table.rows {
        tr {
            th scope="row" { (row.label) }
            @for ((entry, (metric, _)), fields) in row.entries.iter().zip(&table.metrics).zip(&columns) {
                @for field in fields { td.n { (text(entry, metric, field)) } }
            }
            td.whole {
                @if let Some(cell) = &row.cell { (cell_links(std::slice::from_ref(cell))) }
                @for reason in &row.missing { " " span.na { (reason) } }
            }
        }
    } };
    let source = format!("Adapter: {}", outcome.adapter);
    parts::table_of(source, caption, "small", head, body)
}

fn text(entry: &Entry, metric: &str, field: &str) -> String {
    let plain = |value: f64| match metric {
        m if m.ends_with("_bytes") => bytes(value as u64),
        m if m.ends_with("_ms") => format!("{} ms", number(value)),
        _ => number(value),
    };
    let text = match field {
        "published" => entry.published.map(plain),
        "here" => entry.here.map(|v| plain(v.value)),
        "÷, published" => entry.published_ratio.map(number),
        _ => entry.ratio.map(|v| v.to_string()),
    };
    text.unwrap_or_default()
}
