//! The charts, inlined.

use super::super::charts::{Chart, WIDTH};
use super::super::view::View;
use maud::{Markup, PreEscaped, html};

/// The section: charts by case, then those of the whole report.
pub fn section(view: &View<'_>, charts: &[Chart]) -> Markup {
    html! {
        section #charts {
            h2 { "Charts" }
            @if charts.is_empty() { p.notice { "No cell has numbers to draw." } }
            @for case in &view.cases {
                @let own: Vec<&Chart> = charts.iter().filter(|c| c.case == Some(case.number)).collect();
                @if !own.is_empty() { h3 { (case.name) } (grid(&own)) }
            }
            @let whole: Vec<&Chart> = charts.iter().filter(|c| c.case.is_none()).collect();
            @if !whole.is_empty() { h3 { "All scenes and suns" } (grid(&whole)) }
        }
    }
}

fn grid(charts: &[&Chart]) -> Markup {
    html! {
        div.charts {
            @for chart in charts {
                figure.chart {
                    div.scroll tabindex="0" role="img" aria-label=(chart.title) { (PreEscaped(fluid(&chart.svg))) }
                    figcaption { a href={ "./charts/" (chart.file) } { (chart.file) } }
                }
            }
        }
    }
}

/// The SVG without its fixed size, so that it fills the room it has. Its text is already escaped.
pub fn fluid(svg: &str) -> String {
    let fixed = format!("<svg width=\"{WIDTH}\" height=\"");
    match svg
        .strip_prefix(&fixed)
        .and_then(|rest| rest.split_once("\" "))
    {
        Some((_, rest)) => format!("<svg {rest}"),
        None => svg.to_owned(),
    }
}
