//! The study file: a named set of experiments with the charts, claims, errata and questions that are evaluated from
//! their records.
//!
//! ```json
//! { "name": "m", "title": "…", "source": "…",
//!   "profiles": {"quick": {"about": "…", "values": {"maps": [32, 64]}}, "full": {"about": "…", "values": {"maps": [256, 512]}}},
//!   "series": {"srm10": {"method": "srm", "at": {"steps": 10}}},
//!   "experiments": [{"id": "map", "title": "…", "matrix": {"image": …, "methods": [{"method": "esm", "resolution": "$maps"}]}}],
//!   "charts": […], "cost_model": {…}, "tables": […], "claims": […], "errata": […], "guide": […] }
//! ```
//!
//! A string `$NAME` anywhere below stands for the value of that name in the chosen profile. A matrix is an experiment
//! without its name, which the study gives; scene paths are relative to the study file.

mod spec;
mod verdicts;

pub use spec::{
    ChartSpec, Check, ClaimSpec, CostChart, CostSpec, Pick, Prices, Published, Quantity, Series,
    TableColumn, TableRow, TableSpec, Test,
};
pub use verdicts::{Erratum, Evidence, Question};

use super::document::Document;
use super::experiment::{self, Experiment};
use super::{locate, suggest};
use crate::error::{Error, Result};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A checked study file at one of its profiles.
#[derive(Clone, Debug)]
pub struct Study {
    /// Short name; it names the report folder.
    pub name: String,
    /// Heading of the page.
    pub title: String,
    /// What is reproduced: author, year, kind of text.
    pub source: String,
    /// How the source's numbers and these can be compared, sentences; may be empty.
    pub note: String,
    /// Name of the profile.
    pub profile: String,
    /// Difference between this profile and the others, in a sentence or two.
    pub about: String,
    /// Curves and columns by name.
    pub series: BTreeMap<String, Series>,
    /// Experiments in file order. Never empty.
    pub experiments: Vec<StudyExperiment>,
    /// Charts in file order.
    pub charts: Vec<ChartSpec>,
    /// How the source models costs.
    pub cost_model: CostSpec,
    /// Tables in file order.
    pub tables: Vec<TableSpec>,
    /// Experiments whose pictures are shown beside their truth.
    pub pictures: Vec<String>,
    /// Claims in file order.
    pub claims: Vec<ClaimSpec>,
    /// Defects of the text in file order.
    pub errata: Vec<Erratum>,
    /// Questions that the guide answers.
    pub guide: Vec<Question>,
}

/// One experiment of a study.
#[derive(Clone, Debug)]
pub struct StudyExperiment {
    /// Names the folder of its report: lower-case letters, digits, hyphens.
    pub id: String,
    /// One line on what it measures.
    pub title: String,
    /// The matrix.
    pub experiment: Experiment,
}

/// The file, placeholders filled in.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Study")]
pub(super) struct StudyFile {
    /// Short name; it names the report folder. Lower-case letters, digits, hyphens.
    name: String,
    /// Heading of the page.
    title: String,
    /// What is reproduced: author, year, kind of text.
    source: String,
    /// How the source's numbers and these can be compared, sentences.
    #[serde(default)]
    note: String,
    /// Sizes and counts by name: `"$NAME"` elsewhere stands for the value `NAME` of the chosen profile.
    profiles: BTreeMap<String, FileProfile>,
    /// Curves and columns by name.
    series: BTreeMap<String, Series>,
    /// What is measured.
    experiments: Vec<FileExperiment>,
    /// Charts of the page.
    #[serde(default)]
    charts: Vec<ChartSpec>,
    /// How the source models costs.
    #[serde(default)]
    cost_model: CostSpec,
    /// Tables of the page.
    #[serde(default)]
    tables: Vec<TableSpec>,
    /// Experiments whose pictures are shown beside their truth.
    #[serde(default)]
    pictures: Vec<String>,
    /// Claims that are put to the test.
    #[serde(default)]
    claims: Vec<ClaimSpec>,
    /// Defects of the source.
    #[serde(default)]
    errata: Vec<Erratum>,
    /// Questions that the guide answers.
    #[serde(default)]
    guide: Vec<Question>,
}

/// A profile.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "StudyProfile")]
struct FileProfile {
    /// What sets it apart, in a sentence or two.
    about: String,
    /// Values by name.
    #[serde(default)]
    values: Map<String, Value>,
}

/// One experiment.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "StudyExperiment")]
struct FileExperiment {
    /// Names the folder of its report: lower-case letters, digits, hyphens.
    id: String,
    /// One line on what it measures.
    title: String,
    /// An experiment without its name.
    matrix: Map<String, Value>,
}

/// Reads a study at `profile`.
pub fn load_study(path: &Path, profile: &str) -> Result<Study> {
    from_document(&Document::read(path)?, profile)
}

/// A study from text; `path` is for messages and for what is relative to it, and need not exist.
pub fn parse_study(path: &Path, text: String, profile: &str) -> Result<Study> {
    from_document(&Document::parse(path, text)?, profile)
}

/// Title and names of the profiles of a study file, for lists.
pub fn study_profiles(path: &Path) -> Result<(String, Vec<String>)> {
    let document = Document::read(path)?;
    let title: String = document.get("/title")?;
    let profiles: BTreeMap<String, Value> = document.get("/profiles")?;
    Ok((title, profiles.into_keys().collect()))
}

fn from_document(document: &Document, profile: &str) -> Result<Study> {
    let profiles: BTreeMap<String, FileProfile> = document.get("/profiles")?;
    let Some(chosen) = profiles.get(profile) else {
        let names: Vec<&str> = profiles.keys().map(String::as_str).collect();
        let problem = format!("there is no profile `{profile}`");
        let place = document.name();
        let remedy = format!("Profiles of {place}: {}.", names.join(", "));
        return Err(Error::input("--profile", problem, remedy));
    };
    let filled = fill(document, profile, &chosen.values)?;
    let file: StudyFile = filled.get("")?;
    check_names(&filled, &file)?;
    let experiments = (0..file.experiments.len())
        .map(|i| study_experiment(&filled, &file, i))
        .collect::<Result<_>>()?;
    let about = file.profiles[profile].about.clone();
    Ok(Study {
        name: file.name,
        title: file.title,
        source: file.source,
        note: file.note,
        profile: profile.to_owned(),
        about,
        series: file.series,
        experiments,
        charts: file.charts,
        cost_model: file.cost_model,
        tables: file.tables,
        pictures: file.pictures,
        claims: file.claims,
        errata: file.errata,
        guide: file.guide,
    })
}

/// The document with each `$NAME` replaced; every value of the profile must be used. Errors name the profile's value.
fn fill(document: &Document, profile: &str, values: &Map<String, Value>) -> Result<Document> {
    let mut value = document.value().clone();
    let mut used = BTreeMap::new();
    if let Some(members) = value.as_object_mut() {
        for (key, member) in members.iter_mut().filter(|(key, _)| *key != "profiles") {
            let place = locate::step(key);
            replace(document, &place, member, values, &mut used)?;
        }
    }
    let place = |name: &str| {
        let profile = locate::step(profile);
        format!("/profiles{profile}/values{}", locate::step(name))
    };
    let is_used = |name: &str| used.values().any(|used| used == name);
    if let Some(unused) = values.keys().find(|name| !is_used(name)) {
        let place = place(unused);
        let problem = format!("nothing uses `${unused}`");
        return Err(document.error_at_key(&place, problem, "Remove it, or correct the name."));
    }
    let origins = used.into_iter().map(|(at, name)| (at, place(&name)));
    Ok(document.filled(value, origins.collect()))
}

fn replace(
    document: &Document,
    place: &str,
    value: &mut Value,
    values: &Map<String, Value>,
    used: &mut BTreeMap<String, String>,
) -> Result<()> {
    match value {
        Value::String(text) => {
            let Some(name) = text.strip_prefix('$') else {
                return Ok(());
            };
            let Some(new) = values.get(name) else {
                let names = values.keys().map(String::as_str);
                let remedy = format!(
                    "{}Values stand under `profiles`.",
                    suggest::sentence(name, names)
                );
                let problem = format!("the profile has no value `{name}`");
                return Err(document.error(place, problem, remedy));
            };
            used.insert(place.to_owned(), name.to_owned());
            *value = new.clone();
            Ok(())
        }
        Value::Array(items) => items.iter_mut().enumerate().try_for_each(|(i, item)| {
            replace(document, &format!("{place}/{i}"), item, values, used)
        }),
        Value::Object(members) => members.iter_mut().try_for_each(|(key, member)| {
            let place = format!("{place}{}", locate::step(key));
            replace(document, &place, member, values, used)
        }),
        _ => Ok(()),
    }
}

/// Checks ids that name folders and anchors, and references between the parts of the file.
fn check_names(document: &Document, file: &StudyFile) -> Result<()> {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let named = |name: &str| !name.is_empty() && name.len() <= 60 && name.chars().all(plain);
    if !named(&file.name) {
        let remedy = "Use 1 to 60 lower-case letters, digits and hyphens.";
        return Err(document.error("/name", "it cannot name a folder", remedy));
    }
    if file.experiments.is_empty() {
        return Err(document.error("/experiments", "the list is empty", "Name an experiment."));
    }
    let mut ids = BTreeSet::new();
    for (i, experiment) in file.experiments.iter().enumerate() {
        if !named(&experiment.id) || !ids.insert(experiment.id.as_str()) {
            let problem = "it cannot name a folder, or names it twice";
            let remedy = "Use 1 to 60 lower-case letters, digits and hyphens.";
            return Err(document.error(&format!("/experiments/{i}/id"), problem, remedy));
        }
    }
    let charts = file.charts.iter().map(|chart| &chart.id);
    let costs = file.cost_model.charts.iter().map(|chart| &chart.id);
    let charts = charts
        .enumerate()
        .map(|(i, id)| (format!("/charts/{i}/id"), id));
    let costs = costs
        .enumerate()
        .map(|(i, id)| (format!("/cost_model/charts/{i}/id"), id));
    if let Some((place, id)) = charts.chain(costs).find(|(_, id)| !named(id)) {
        let problem = format!("`{id}` cannot name a file");
        let remedy = "Use 1 to 60 lower-case letters, digits and hyphens.";
        return Err(document.error(&place, problem, remedy));
    }
    let lists = [
        "/charts",
        "/tables",
        "/pictures",
        "/claims",
        "/errata",
        "/guide",
    ];
    lists.iter().try_for_each(|list| {
        let value = document.value().pointer(list).unwrap_or(&Value::Null);
        check_references(document, list, value, &ids, &file.series)
    })
}

/// Every `experiment` and `series` below `place` must exist.
fn check_references(
    document: &Document,
    place: &str,
    value: &Value,
    ids: &BTreeSet<&str>,
    series: &BTreeMap<String, Series>,
) -> Result<()> {
    let known = |place: &str, what: &str, name: &str| {
        let (exists, names): (bool, Vec<&str>) = match what {
            "series" => (
                series.contains_key(name),
                series.keys().map(String::as_str).collect(),
            ),
            _ => (ids.contains(name), ids.iter().copied().collect()),
        };
        if exists {
            return Ok(());
        }
        let hint = suggest::sentence(name, names.iter().copied());
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let remedy = format!("{hint}Known are {}.", names.join(", "));
        Err(document.error(place, format!("there is no {what} `{name}`"), remedy))
    };
    match value {
        Value::Array(items) => items.iter().enumerate().try_for_each(|(i, item)| {
            let place = format!("{place}/{i}");
            match item {
                Value::String(id) if place.starts_with("/pictures/") => {
                    known(&place, "experiment", id)
                }
                Value::String(name) if place.contains("/series/") => known(&place, "series", name),
                _ => check_references(document, &place, item, ids, series),
            }
        }),
        Value::Object(members) => members.iter().try_for_each(|(key, member)| {
            let place = format!("{place}{}", locate::step(key));
            match (key.as_str(), member) {
                ("experiment", Value::String(id)) => known(&place, "experiment", id),
                ("series" | "relative_to", Value::String(name)) => known(&place, "series", name),
                _ => check_references(document, &place, member, ids, series),
            }
        }),
        _ => Ok(()),
    }
}

fn study_experiment(document: &Document, file: &StudyFile, i: usize) -> Result<StudyExperiment> {
    let entry = &file.experiments[i];
    let mut matrix = entry.matrix.clone();
    let name = format!("Study {} · {}", file.name, entry.title);
    if matrix.insert("name".to_owned(), name.into()).is_some() {
        let place = format!("/experiments/{i}/matrix/name");
        let remedy = "Remove it: the study names its experiments by their titles.";
        return Err(document.error_at_key(&place, "the name is not given here", remedy));
    }
    let part = document.part(Value::Object(matrix), &format!("/experiments/{i}/matrix"));
    Ok(StudyExperiment {
        id: entry.id.clone(),
        title: entry.title.clone(),
        experiment: experiment::from_document(part)?,
    })
}
