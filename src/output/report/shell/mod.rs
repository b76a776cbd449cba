//! Frame of every page: head, style, script, header with the adapter's line, navigation. Reports of batches, studies
//! with their guides, and stability sweeps supply the body. A page is one self-contained file.

pub mod parts;

use super::format::shorten;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Script for the pages of a report: sorts tables, answers the budget form, compares pictures.
pub const SCRIPT: &str = include_str!("script.js");

/// One page.
pub struct Page<'a> {
    /// Title of the window.
    pub title: &'a str,
    /// CSS rules in addition to those that all pages share.
    pub style: &'a str,
    /// Header above the sections.
    pub header: PageHeader<'a>,
    /// The sections.
    pub main: Markup,
    /// [`SCRIPT`], or empty.
    pub script: &'a str,
}

/// Header of a page, above its sections.
pub struct PageHeader<'a> {
    /// A line above the heading: what kind of page it is.
    pub kicker: &'a str,
    /// The heading.
    pub heading: &'a str,
    /// Adapter on which the numbers were measured.
    pub adapter: Markup,
    /// Summary and notes.
    pub summary: Markup,
    /// Links to sections and other pages.
    pub links: Vec<Link<'a>>,
}

/// An entry of the navigation.
pub enum Link<'a> {
    /// Id of a section and the text of its link.
    Section(&'a str, &'a str),
    /// Path of another page and the text of its link.
    Page(&'a str, Markup),
}

/// The page as HTML text.
pub fn page(page: &Page<'_>) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (shorten(page.title, 80)) " · occlab" }
                style { (PreEscaped(include_str!("style.css"))) (PreEscaped(page.style)) }
            }
            body {
                (header(&page.header))
                main { (page.main) }
                @if !page.script.is_empty() { script { (PreEscaped(page.script)) } }
            }
        }
    };
    markup.into_string()
}

fn header(header: &PageHeader<'_>) -> Markup {
    html! {
        header {
            p.kicker { (header.kicker) }
            h1 { (header.heading) }
            p.adapter { (header.adapter) }
            (header.summary)
            nav { @for link in &header.links {
                @match link {
                    Link::Section(id, words) => { a href={ "#" (id) } { (words) } },
                    Link::Page(path, words) => { a href=(path) { (words) } },
                }
            } }
        }
    }
}
