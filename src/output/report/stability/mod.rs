//! Report of a stability sweep: `stability.json` and `index.html`, a self-contained page.

mod curves;
mod heat;
mod tables;

use super::files;
use super::shell::parts::plural;
use super::shell::{Link, Page, PageHeader, page};
use crate::error::{Error, Result};
use crate::stability::{FormVerdict, Sweep};
use maud::{Markup, html};
use std::path::{Path, PathBuf};

/// Writes `stability.json` and `index.html` into `folder`; returns the path of the page.
pub fn write(folder: &Path, sweep: &Sweep) -> Result<PathBuf> {
    let json = folder.join("stability.json");
    let text = serde_json::to_vec(sweep).map_err(|e| Error::writing(&json)(e.into()))?;
    files::write(&json, &text)?;
    let page = folder.join("index.html");
    files::write(&page, html(sweep)?.as_bytes())?;
    Ok(page)
}

fn html(sweep: &Sweep) -> Result<String> {
    let charts = curves::charts(sweep)?;
    let links = [
        ("thresholds", "Thresholds"),
        ("oracle", "Oracle"),
        ("device", "Device"),
        ("curves", "Curves"),
        ("environment", "Environment"),
        ("definitions", "Definitions"),
    ];
    Ok(page(&Page {
        title: &sweep.name,
        style: include_str!("style.css"),
        header: PageHeader {
            kicker: "occlab · where numbers end",
            heading: &sweep.name,
            adapter: html! { "Oracle in f64, number formats emulated · pictures on " strong { (device(sweep)) } },
            summary: summary(sweep),
            links: links.map(|(id, words)| Link::Section(id, words)).into(),
        },
        main: html! {
            (tables::defects(sweep))
            (tables::thresholds(sweep))
            (heat::section(sweep))
            (curves::section(&charts))
            (tables::refused(sweep))
            (tables::environment(sweep))
            (tables::definitions())
        },
        script: "",
    }))
}

/// Name of the device, or words for its absence.
fn device(sweep: &Sweep) -> String {
    let environment = sweep.environment.as_ref();
    environment.map_or_else(
        || "no adapter: the oracle ran alone".to_owned(),
        |e| format!("{} · {} · {}", e.adapter, e.device_type, e.backend),
    )
}

fn summary(sweep: &Sweep) -> Markup {
    let defects = sweep.defects().len();
    let rows: usize = sweep.cases.iter().map(|case| case.rows.len()).sum();
    let of = |form: &str, verdict: FormVerdict| sweep.count(form, verdict);
    html! {
        p {
            (plural(sweep.cases.len(), "extreme")) ", " (plural(rows, "result")) ", profile " (sweep.profile) ". "
            @if defects > 0 {
                a.alarm href="#defects" { "Forms that must hold break in " (plural(defects, "result")) "." }
            } @else {
                "Every stable form holds: no value that is not finite, T in [0, 1], no rise beyond documented ringing."
            }
        }
        table.small {
            thead { tr {
                th scope="col" { "Oracle's verdicts" }
                @for name in ["ok", "rings", "breaks", "refused"] { th.n scope="col" { (name) } }
            } }
            tbody { @for (form, name) in [("stable", "stable form"), ("published", "published form"), ("-", "one form only")] {
                tr {
                    th scope="row" { (name) }
                    @for verdict in [FormVerdict::Ok, FormVerdict::Rings, FormVerdict::Breaks, FormVerdict::Refused] {
                        td.n { (of(form, verdict)) }
                    }
                }
            } }
        }
    }
}
