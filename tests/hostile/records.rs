//! `report.json`.

use super::damage::{cases, changed, changes, damaged, edits, json, text};
use super::is_one_paragraph;
use occlab::batch::record::Report;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A report of four cells, the last of which failed.
pub fn report() -> Value {
    serde_json::from_str(include_str!("report.json")).unwrap()
}

/// Every file below `folder`, relative to it.
pub fn files(folder: &Path) -> BTreeSet<PathBuf> {
    fn walk(folder: &Path, root: &Path, out: &mut BTreeSet<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => walk(&path, root, out),
                false => drop(out.insert(path.strip_prefix(root).unwrap().to_owned())),
            }
        }
    }
    let mut out = BTreeSet::new();
    walk(folder, folder, &mut out);
    out
}

/// What a record says becomes a page, tables and charts inside its folder, or is refused.
pub fn holds(bytes: &[u8]) {
    let outside = tempfile::tempdir().unwrap();
    let folder = outside.path().join("report");
    std::fs::create_dir(&folder).unwrap();
    let path = folder.join("report.json");
    std::fs::write(&path, bytes).unwrap();
    match Report::read(&path) {
        Err(error) => assert!(is_one_paragraph(&error.to_string(), &path), "{error}"),
        Ok(report) => {
            occlab::report::write(&folder, &report).unwrap();
            let known = ["index.html", "report.json", "cells.csv"];
            for file in files(outside.path()) {
                let inside = file
                    .strip_prefix("report")
                    .unwrap_or_else(|_| panic!("{} is outside", file.display()));
                let name = inside.to_str().unwrap();
                let chart = name.strip_prefix("charts/").is_some_and(|n| {
                    n.ends_with(".svg")
                        && n.chars()
                            .all(|c| c.is_ascii_alphanumeric() || "-.".contains(c))
                });
                assert!(known.contains(&name) || chart, "{name}");
            }
            Report::read(&path).unwrap();
            is_inert(&std::fs::read_to_string(folder.join("index.html")).unwrap());
        }
    }
}

/// The page has its own script and nothing that asks for anything outside or came in as markup.
pub fn is_inert(html: &str) {
    assert_eq!(html.matches("<script").count(), 1, "a name became a script");
    for bad in [
        "<b>",
        "onerror=\"",
        "href=\"javascript",
        "href=\"..",
        "href=\"/",
        "src=\"/",
        "src=\"..",
        "src=\"http",
        "href=\"http",
    ] {
        assert!(!html.contains(bad), "the page contains {bad}");
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn any_json_as_records(value in json()) {
        holds(value.to_string().as_bytes());
    }

    #[test]
    fn changed_records(changes in changes()) {
        holds(changed(report(), &changes).to_string().as_bytes());
    }

    #[test]
    fn damaged_records(edits in edits()) {
        let text = serde_json::to_vec_pretty(&report()).unwrap();
        holds(&damaged(&text, &edits, usize::MAX));
    }

    /// Names that people, or attackers, choose.
    #[test]
    fn any_names(scene in text(), method in text(), key in text(), value in json(), adapter in text(), file in text()) {
        let mut report = report();
        report["environment"]["adapter"] = json!(adapter);
        report["experiment"]["name"] = json!(file);
        for cell in report["cells"].as_array_mut().unwrap() {
            cell["scene"] = json!(scene);
            cell["method"] = json!(method);
            cell["scene_set"][key.as_str()] = value.clone();
            cell["params"][key.as_str()] = value.clone();
            if cell["result"].is_object() {
                cell["result"]["files"]["png"] = json!(file);
            }
        }
        report["cells"][1]["scene"] = json!("other");
        holds(report.to_string().as_bytes());
    }
}

#[test]
fn the_report_used_here_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.json");
    std::fs::write(&path, report().to_string()).unwrap();
    let read = Report::read(&path).unwrap();
    assert_eq!(read.cells.len(), 4);
    occlab::report::write(folder.path(), &read).unwrap();
    assert!(files(folder.path()).len() > 5, "charts are drawn");
}
