//! The one shell of every page: head, style, script, header with the adapter's line, navigation. The index of a batch, a
//! study with its guide, and a stability sweep are bodies in it. A page is one file that needs no network.

pub mod parts;

use super::format::shorten;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Sorts, chooses and compares: for pages with the tables and pictures of a report.
pub const SCRIPT: &str = include_str!("script.js");

/// One page.
pub struct Page<'a> {
    /// Title of the window.
    pub title: &'a str,
    /// Rules besides those that all pages share.
    pub style: &'a str,
    /// What stands above the sections.
    pub header: PageHeader<'a>,
    /// The sections.
    pub main: Markup,
    /// [`SCRIPT`], or empty.
    pub script: &'a str,
}

/// What stands above the sections of a page.
pub struct PageHeader<'a> {
    /// A line above the heading: what kind of page it is.
    pub kicker: &'a str,
    /// The heading.
    pub heading: &'a str,
    /// On what the numbers were measured.
    pub adapter: Markup,
    /// Summary and notes.
    pub summary: Markup,
    /// Links to sections and other pages.
    pub links: Vec<Link<'a>>,
}

/// An entry of the navigation.
pub enum Link<'a> {
    /// Id of a section and words for it.
    Section(&'a str, &'a str),
    /// Path of another page and words for it.
    Page(&'a str, Markup),
}

/// The page as text.
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
