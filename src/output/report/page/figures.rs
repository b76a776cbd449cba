//! Section with the charts as inline SVG.

use super::super::charts::Drawing;
use super::super::shell::parts;
use super::super::view::ReportView;
use maud::{Markup, html};

/// The section: charts by case, then those of the whole report.
pub fn section(view: &ReportView<'_>, charts: &[Drawing]) -> Markup {
    html! {
        section #charts {
            h2 { "Charts" }
            @if charts.is_empty() { p.notice { "No cell has numbers to draw." } }
            @for case in &view.cases {
                @let own: Vec<&Drawing> = charts.iter().filter(|c| c.case == Some(case.number)).collect();
                @if !own.is_empty() { h3 { (case.name) } (grid(&own)) }
            }
            @let whole: Vec<&Drawing> = charts.iter().filter(|c| c.case.is_none()).collect();
            @if !whole.is_empty() { h3 { "All scenes and suns" } (grid(&whole)) }
        }
    }
}

fn grid(charts: &[&Drawing]) -> Markup {
    html! {
        div.charts {
            @for chart in charts {
                @let link = html! { a href={ "./charts/" (chart.file) } { (chart.file) } };
                (parts::chart(&chart.title, &chart.svg, Some(link)))
            }
        }
    }
}
