//! Tables of the source beside what was measured here.

use super::super::Outcome;
use super::super::interval::Interval;
use super::super::table::{Entry, Table};
use super::cell_links;
use crate::report::format::{bytes, number};
use maud::{Markup, html};

/// The section; nothing where the study names no table.
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

fn one(table: &Table, outcome: &Outcome) -> Markup {
    let columns = |title: &str| -> Vec<String> {
        let mut columns = vec![format!("{title}, published"), format!("{title}, here")];
        if let Some(unit) = &table.relative_to {
            columns.push(format!("÷ {unit}, published"));
            columns.push(format!("÷ {unit}, here"));
        }
        columns
    };
    html! {
        figure.table {
            figcaption {
                (table.figure) " · " (table.title) ". " (table.note) " "
                span.where { "Adapter: " (outcome.adapter) }
            }
            div.scroll tabindex="0" { table.small {
                thead { tr {
                    th scope="col" { "Setting" }
                    @for (_, title) in &table.metrics { @for name in columns(title) { th.n scope="col" { (name) } } }
                    th scope="col" { "Cell" }
                } }
                tbody { @for row in &table.rows {
                    tr {
                        th scope="row" { (row.label) }
                        @for (entry, (metric, _)) in row.entries.iter().zip(&table.metrics) {
                            (entry_of(entry, metric, table.relative_to.is_some()))
                        }
                        td {
                            @if let Some(cell) = &row.cell { (cell_links(std::slice::from_ref(cell))) }
                            @for reason in &row.missing { " " span.na { (reason) } }
                        }
                    }
                } }
            } }
        }
    }
}

fn entry_of(entry: &Entry, metric: &str, ratios: bool) -> Markup {
    let plain = |value: f64| match metric {
        m if m.ends_with("_bytes") => bytes(value as u64),
        m if m.ends_with("_ms") => format!("{} ms", number(value)),
        _ => number(value),
    };
    let field = |text: Option<String>| html! { td.n { (text.unwrap_or_default()) } };
    html! {
        (field(entry.published.map(plain)))
        (field(entry.here.map(|v: Interval| plain(v.value))))
        @if ratios {
            (field(entry.published_ratio.map(number)))
            (field(entry.ratio.map(|v| v.to_string())))
        }
    }
}
