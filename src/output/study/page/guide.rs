//! `guide.html`: which method to use for which error, budget or axis value.

use super::super::Outcome;
use super::{KICKER, cell_links};
use crate::config::Study;
use crate::report::shell::{Link, Page, PageHeader};
use maud::html;

/// The page.
pub fn page<'a>(title: &'a str, study: &Study, outcome: &Outcome) -> Page<'a> {
    Page {
        title,
        style: include_str!("style.css"),
        header: PageHeader {
            kicker: KICKER,
            heading: "Which method when?",
            adapter: html! { "Holds for " strong { (outcome.adapter) } ", profile " (outcome.profile) },
            summary: html! {
                p { (study.about) }
                p.note {
                    "Every sentence is made of the records and links to its cells. Sentences about time hold for this adapter alone; those "
                    "about errors and memory hold for these scenes and settings on any adapter, but for rounding. “Not told apart” "
                    "means that the repeats overlap."
                }
            },
            links: vec![Link::Page("./index.html", html! { "The study" })],
        },
        main: html! {
            @for answer in &outcome.guide {
                section {
                    h2 { (answer.title) }
                    p.unit { "By " (answer.words) }
                    ul.parts { @for sentence in &answer.sentences { li { (sentence.text) " " (cell_links(&sentence.cells)) } } }
                }
            }
            @if outcome.guide.is_empty() { p { "The study asks no questions." } }
        },
        script: "",
    }
}
