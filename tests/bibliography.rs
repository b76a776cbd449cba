//! Every source that is cited has an entry in `src/BIBLIOGRAPHY.md`, and every entry is cited.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Keys of the entries: `Annen et al. 2008`.
fn keys() -> Vec<String> {
    let text = fs::read_to_string(root().join("src/BIBLIOGRAPHY.md")).expect("bibliography");
    let entries = text.lines().filter_map(|line| line.strip_prefix("- **"));
    let keys = entries.filter_map(|entry| Some(entry.split_once("**")?.0.to_owned()));
    keys.collect()
}

/// Rust, WGSL and JSON files below `path`, or `path` itself.
fn files(path: &Path) -> Vec<PathBuf> {
    let kinds = ["rs", "wgsl", "json"];
    match fs::read_dir(path) {
        Ok(entries) => entries
            .flat_map(|entry| files(&entry.expect("entry").path()))
            .collect(),
        Err(_)
            if path
                .extension()
                .is_some_and(|e| kinds.iter().any(|k| e == *k)) =>
        {
            vec![path.to_owned()]
        }
        Err(_) => Vec::new(),
    }
}

/// Text without what breaks a citation across lines of a comment.
fn joined(text: &str) -> String {
    let lines = text.lines().map(|line| {
        let line = line.trim();
        line.trim_start_matches(['/', '!']).trim()
    });
    lines.collect::<Vec<_>>().join(" ")
}

/// Citations `Name 1999`, `Name & Name 1999`, `Name et al. 1999`, `Name, Name & Name 1999`: the words before a year of
/// publication, from the first capital letter on.
fn cited(text: &str) -> BTreeSet<String> {
    let words: Vec<&str> = text.split(' ').collect();
    let name = |word: &str| {
        let word = word.trim_start_matches(['(', '"', '“', '*']);
        let letters = word.chars().all(|c| c.is_alphabetic() || c == '-');
        letters && word.chars().next().is_some_and(char::is_uppercase) && word.len() > 2
    };
    let mut found = BTreeSet::new();
    for (i, word) in words.iter().enumerate() {
        let digits: String = word.chars().take_while(char::is_ascii_digit).collect();
        let rest = &word[digits.len()..];
        let year = digits.len() == 4
            && ["19", "20"].contains(&&digits[..2])
            && !rest.starts_with(|c: char| c.is_alphanumeric() || "-/–…×".contains(c));
        if !year || i == 0 {
            continue;
        }
        let mut first = i;
        if words[..i].ends_with(&["et", "al."]) && i >= 3 && name(words[i - 3]) {
            first = i - 3;
        } else if name(words[i - 1]) {
            first = i - 1;
            if i >= 3 && words[i - 2] == "&" && name(words[i - 3]) {
                first = i - 3;
                let listed = |word: &str| word.strip_suffix(',').is_some_and(name);
                while first > 0 && listed(words[first - 1]) {
                    first -= 1;
                }
            }
        }
        if first < i {
            let names = words[first..i].join(" ");
            let names = names.trim_start_matches(['(', '"', '“', '*']);
            found.insert(format!("{names} {digits}"));
        }
    }
    found
}

#[test]
fn what_is_cited_is_listed_and_what_is_listed_is_cited() {
    let keys: BTreeSet<String> = keys().into_iter().collect();
    let mut paths = vec![root().join("README.md")];
    for folder in ["src", "shaders", "configs"] {
        paths.extend(files(&root().join(folder)));
    }
    let texts: Vec<_> = paths
        .iter()
        .map(|path| joined(&fs::read_to_string(path).expect("source")))
        .collect();
    let all: BTreeSet<String> = texts.iter().flat_map(|text| cited(text)).collect();
    let unlisted: Vec<_> = all.difference(&keys).collect();
    assert!(unlisted.is_empty(), "not in the bibliography: {unlisted:?}");
    let unused: Vec<_> = keys.difference(&all).collect();
    assert!(unused.is_empty(), "cited nowhere: {unused:?}");
}

#[test]
fn entries_are_in_order_and_have_names_and_a_title() {
    let keys = keys();
    let mut sorted = keys.clone();
    sorted.sort();
    assert_eq!(keys, sorted);
    let text = fs::read_to_string(root().join("src/BIBLIOGRAPHY.md")).expect("bibliography");
    for entry in text.lines().filter(|line| line.starts_with("- **")) {
        assert_eq!(entry.matches('*').count(), 6, "{entry}");
    }
}

/// Control: each form of a citation is seen, and what is none is not.
#[test]
fn citations_are_told_from_other_numbers() {
    let of = |text: &str| cited(&joined(text)).into_iter().collect::<Vec<_>>();
    assert_eq!(
        of("as in (Annen et al. 2008, eq. 3)"),
        ["Annen et al. 2008"]
    );
    assert_eq!(of("/// Kay\n/// & Kajiya 1986."), ["Kay & Kajiya 1986"]);
    assert_eq!(
        of("after Preetham, Shirley & Smits 1999; Perlin 2002"),
        ["Perlin 2002", "Preetham, Shirley & Smits 1999"]
    );
    assert_eq!(of("edge 2048 texels, Grey, 2048 and 1920 × 1080"), [""; 0]);
}
