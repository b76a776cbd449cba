//! `guide.html`: which method when.

use super::super::Outcome;
use super::cell_links;
use crate::config::Study;
use maud::{Markup, html};

/// The page's body.
pub fn body(study: &Study, outcome: &Outcome) -> Markup {
    html! {
        header {
            p.kicker { "occlab · a study done again" }
            h1 { "Which method when?" }
            p.adapter { "Holds for " strong { (outcome.adapter) } ", profile " (outcome.profile) }
            p { (study.about) }
            p.note {
                "Every sentence is made of the records and links to its cells. Sentences about time hold for this adapter alone; those "
                "about errors and memory hold for these scenes and settings on any adapter, but for rounding. “Not told apart” "
                "means that the repeats overlap."
            }
            nav { a href="./index.html" { "The study" } }
        }
        main {
            @for answer in &outcome.guide {
                section {
                    h2 { (answer.title) }
                    p.unit { "By " (answer.words) }
                    ul.parts { @for sentence in &answer.sentences { li { (sentence.text) " " (cell_links(&sentence.cells)) } } }
                }
            }
            @if outcome.guide.is_empty() { p { "The study asks no questions." } }
        }
    }
}
