//! `index.html` and `guide.html` of a study, in the style of a report.

mod guide;
mod pictures;
mod published;
mod tables;

use super::charts::Figure;
use super::claims::{CellLink, Verdict};
use super::select::Records;
use super::{EXPERIMENTS, Outcome};
use crate::config::Study;
use crate::error::Result;
use crate::report::files;
use crate::report::format::{number, signed_percent};
use crate::report::shell::parts::{self, plural};
use crate::report::shell::{Link, Page, PageHeader, page};
use maud::{Markup, html};
use std::path::{Path, PathBuf};

/// Line above the heading of both pages.
const KICKER: &str = "occlab · a study done again";

/// Writes both pages; returns the path of the first.
pub fn write(
    folder: &Path,
    study: &Study,
    records: &Records<'_>,
    outcome: &Outcome,
    figures: &[Figure],
) -> Result<PathBuf> {
    let title = format!("Which method when · {}", study.title);
    let guide = page(&guide::page(&title, study, outcome));
    files::write(&folder.join("guide.html"), guide.as_bytes())?;
    let index = page(&Page {
        title: &study.title,
        style: include_str!("style.css"),
        header: PageHeader {
            kicker: KICKER,
            heading: &study.title,
            adapter: html! { "Measured on " strong { (outcome.adapter) } },
            summary: summary(study, outcome),
            links: links(),
        },
        main: html! {
            (tables::claims(outcome))
            (charts(figures))
            (published::section(outcome))
            (pictures::section(folder, study, records))
            (tables::errata(outcome))
            (tables::cost_model(study, outcome, figures))
            (tables::evidence(outcome))
            (experiments(study, records))
            (tables::definitions())
        },
        script: "",
    });
    let path = folder.join("index.html");
    files::write(&path, index.as_bytes())?;
    Ok(path)
}

fn links() -> Vec<Link<'static>> {
    let guide = html! { strong { "Which method when?" } };
    let sections = [
        ("claims", "Claims"),
        ("charts", "Charts"),
        ("tables", "Tables"),
        ("pictures", "Pictures"),
        ("errata", "Errata"),
        ("cost", "Cost model"),
        ("evidence", "Evidence"),
        ("experiments", "Experiments"),
        ("definitions", "Definitions"),
    ];
    let sections = sections.map(|(id, words)| Link::Section(id, words));
    [Link::Page("./guide.html", guide)]
        .into_iter()
        .chain(sections)
        .collect()
}

fn summary(study: &Study, outcome: &Outcome) -> Markup {
    let count = |verdict| {
        outcome
            .claims
            .iter()
            .filter(|c| c.verdict == verdict)
            .count()
    };
    html! {
        p { "Source: " (study.source) }
        p { "Profile " strong { (outcome.profile) } ": " (study.about) }
        p {
            (plural(outcome.cells, "cell")) " in " (plural(study.experiments.len(), "experiment")) ", "
            (number(outcome.wall_s)) " s. "
            @if outcome.failed > 0 { span.alarm { (plural(outcome.failed, "cell")) " failed; what needs them is not decidable here." } }
            @else { "No cell failed." }
        }
        p.tally {
            @for (verdict, words) in [(Verdict::Holds, "hold"), (Verdict::Fails, "do not hold"), (Verdict::Undecidable, "not decidable here")] {
                span class=(class(verdict)) { (count(verdict)) " " (words) }
            }
        }
        p.note { "Verdicts and times are those of this adapter. " (study.note) }
    }
}

/// CSS class of a verdict.
fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "verdict holds",
        Verdict::Fails => "verdict fails",
        Verdict::Undecidable => "verdict open",
    }
}

/// Path of an experiment's page.
fn report_link(experiment: &str) -> String {
    format!("./{EXPERIMENTS}/{experiment}/index.html")
}

/// Largest number of cells that are linked one by one.
const MOST_LINKS: usize = 12;

/// Links to cells, grouped by experiment.
fn cell_links(cells: &[CellLink]) -> Markup {
    let mut seen: Vec<&CellLink> = Vec::new();
    for cell in cells {
        if !seen.contains(&cell) {
            seen.push(cell);
        }
    }
    let mut experiment = "";
    let mut out = html! {};
    for cell in seen.iter().take(MOST_LINKS) {
        let first = cell.experiment != experiment;
        experiment = &cell.experiment;
        out = html! {
            (out)
            @if first { " " a href=(report_link(experiment)) { (experiment) } }
            " " a href={ (report_link(experiment)) "#cell-" (cell.index) } { (cell.index) }
        };
    }
    let more = seen.len().saturating_sub(MOST_LINKS);
    html! {
        @if !seen.is_empty() { span.cells { "cells" (out) @if more > 0 { " and " (more) " more" } } }
    }
}

fn charts(figures: &[Figure]) -> Markup {
    html! {
        section #charts {
            h2 { "Charts" }
            p {
                "Each stands for a figure or table of the source. Filled markers are measured here, bars are the ranges that hold the "
                "true median of the repeats; hollow markers are values that the source's text gives."
            }
            (grid(figures.iter().filter(|figure| !figure.of_costs)))
        }
    }
}

fn grid<'a>(figures: impl Iterator<Item = &'a Figure>) -> Markup {
    html! {
        div.charts {
            @for figure in figures {
                figure.chart {
                    @if figure.svg.is_empty() { p.notice { (figure.title) ": nothing to draw." } }
                    @else { (parts::picture(&figure.title, &figure.svg)) }
                    @for reason in &figure.missing { p.notice { "Missing: " (reason) "." } }
                    figcaption {
                        (figure.figure) " · " a href={ "./charts/" (figure.file) } { (figure.file) }
                        @if !figure.experiment.is_empty() {
                            " · " a href=(report_link(&figure.experiment)) { "report of `" (figure.experiment) "`" }
                        }
                    }
                }
            }
        }
    }
}

fn experiments(study: &Study, records: &Records<'_>) -> Markup {
    html! {
        section #experiments {
            h2 { "Experiments" }
            p {
                "Each has a report of its own, with every cell, picture and number. Clock drift: change of the time of a fixed piece "
                "of arithmetic, between the rounds, against its time before them."
            }
            div.scroll tabindex="0" { table {
                thead { tr {
                    th scope="col" { "Experiment" } th scope="col" { "What it measures" }
                    th.n scope="col" { "Cells" } th.n scope="col" { "Failed" } th.n scope="col" { "Runs" } th.n scope="col" { "Wall" }
                    th.n scope="col" { "Clock drift" }
                } }
                tbody { @for (entry, (id, report)) in study.experiments.iter().zip(records.reports) {
                    tr {
                        td.whole { a href=(report_link(id)) { (id) } }
                        td.long { (entry.title) }
                        td.n { (report.cells.len()) }
                        td.n { (report.cells.iter().filter(|c| c.result.is_none()).count()) }
                        td.n { (entry.experiment.runs) }
                        td.n { (number(report.wall.total_s)) " s" }
                        td.n { @match report.clock_drift() {
                            Some([least, most]) => { (signed_percent(least)) " to " (signed_percent(most)) },
                            None => "n/a",
                        } }
                    }
                } }
            } }
            p { "Everything on this page for programs: " a href="./study.json" { "study.json" } "." }
        }
    }
}
