//! What a batch measures: the matrix of an experiment file, or the cells of an existing report, measured again.

use super::cell::planned_cell;
use super::identity::hash_file;
use super::record::{Cell, InputFile, Report, SceneRecord};
use crate::config::{Experiment, Matrix, expand, experiment_of};
use crate::density::Density;
use crate::density::volume::file_of;
use crate::error::{Error, Result};
use crate::provenance;
use crate::reconstruct::Registry;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// File of a report in its folder.
const REPORT: &str = "report.json";

/// What a batch measures, and how.
#[derive(Clone, Debug)]
pub struct BatchPlan {
    experiment: Experiment,
    recorded: Value,
    matrix: Matrix,
    again: Option<Again>,
}

/// Sources and commit of the report that is measured again.
#[derive(Clone, Debug)]
struct Again {
    sources: String,
    commit: String,
}

/// The report that `path` names, by its folder or by itself; `None` for anything else.
pub fn report_file(path: &Path) -> Option<PathBuf> {
    #[derive(Deserialize)]
    struct Start {
        schema: String,
    }
    if path.is_dir() {
        // A folder without a report that shares its name with an experiment does not count.
        return Some(path.join(REPORT)).filter(|report| report.is_file());
    }
    if !path.is_file() {
        return None;
    }
    let file = BufReader::new(std::fs::File::open(path).ok()?);
    let start: Start = serde_json::from_reader(file).ok()?;
    let is_report = start.schema.starts_with("occlab-report-");
    is_report.then(|| path.to_owned())
}

impl BatchPlan {
    /// The matrix of an experiment.
    pub fn new(experiment: Experiment) -> Result<Self> {
        Ok(Self {
            matrix: expand(&experiment, &Registry)?,
            recorded: experiment.document().value().clone(),
            experiment,
            again: None,
        })
    }

    /// The cells of a report, from its file alone: each scene as it was resolved, every parameter as it was recorded.
    /// The files that the scenes read must be those that were measured, at their places or beside the report.
    pub fn of_report(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(Error::reading(path))?;
        let report = Report::parse(path, &text)?;
        if report.scenes.is_empty() {
            let problem = "it does not hold its scenes, because an earlier version wrote it";
            let remedy = "Run its experiment file instead; the new report can be measured again.";
            return Err(Error::input(path.display().to_string(), problem, remedy));
        }
        let scenes = with_files(path, &report)?;
        let cells = distinct(&report.cells);
        let value = experiment(&report.experiment, &scenes, &cells);
        let experiment = experiment_of(path, text, value)?;
        let mut matrix = expand(&experiment, &Registry)?;
        let mut planned = cells.iter();
        let images = experiment.images.len();
        for (i, view) in matrix.views.iter_mut().enumerate() {
            let scene = scenes
                .get(i / images)
                .ok_or_else(|| unlike(path, &report))?;
            let mut set = None;
            for spec in &view.cells {
                let cell = planned.next().filter(|cell| {
                    let plan = planned_cell(view, spec);
                    (&scene.id, &plan.scene, key(&plan)) == (&cell.scene_id, &cell.scene, key(cell))
                });
                let cell = cell.ok_or_else(|| unlike(path, &report))?;
                set.get_or_insert(&cell.scene_set);
            }
            view.scene_set = set.cloned().unwrap_or_default();
        }
        if planned.next().is_some() {
            return Err(unlike(path, &report));
        }
        Ok(Self {
            experiment,
            recorded: report.experiment,
            matrix,
            again: Some(Again {
                sources: report.sources,
                commit: report.environment.commit,
            }),
        })
    }

    /// Views and cells of the batch.
    pub fn matrix(&self) -> &Matrix {
        &self.matrix
    }

    /// Name of the experiment.
    pub fn name(&self) -> &str {
        &self.experiment.name
    }

    /// The experiment, with round counts and options of the measurement.
    pub(super) fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// The experiment as its file has it.
    pub(super) fn recorded(&self) -> &Value {
        &self.recorded
    }

    /// A note where a report is measured again with sources other than its own.
    pub(super) fn differs_from(&self, sources: &str, commit: &str) -> Option<String> {
        let again = self.again.as_ref()?;
        let differs = again.sources != sources;
        differs.then(|| {
            let theirs = &again.commit;
            format!(
                "the report was measured by {theirs}, this program is {commit}, and the sources that decide numbers differ"
            )
        })
    }
}

/// The scenes of a report with the paths of their files as they are found now; an error that names every file that is
/// absent or another.
fn with_files(path: &Path, report: &Report) -> Result<Vec<SceneRecord>> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut scenes = report.scenes.clone();
    let mut found = BTreeMap::new();
    let mut problems = Vec::new();
    for scene in &mut scenes {
        let Some(written) = scene.scene.get_mut("density") else {
            continue;
        };
        // A density that cannot be parsed is reported with the experiment.
        let Ok(mut density) = Density::deserialize(&*written) else {
            continue;
        };
        let Some(path) = density.field_mut().input_file_mut() else {
            continue;
        };
        let name = path.to_string_lossy().into_owned();
        if !found.contains_key(&name) {
            let looked = find(folder, &name, &report.inputs);
            problems.extend(looked.as_ref().err().cloned());
            found.insert(name.clone(), looked.ok());
        }
        if let Some(Some(place)) = found.get(&name) {
            *path = place.into();
            *written = json!(density);
        }
    }
    if problems.is_empty() {
        return Ok(scenes);
    }
    let problem = format!(
        "files are not those that were measured: {}",
        problems.join("; ")
    );
    let remedy = "Put the files that were measured at their places, or beside the report.";
    Err(Error::input(path.display().to_string(), problem, remedy))
}

/// Where the file that a report calls `name` is now, as seen from its folder; or what is wrong with it.
fn find(folder: &Path, name: &str, inputs: &[InputFile]) -> Result<String, String> {
    let Some(input) = inputs.iter().find(|input| input.path == name) else {
        return Err(format!("`{name}` has no hash in the report"));
    };
    let part = file_of(Path::new(name));
    let beside = part.file.file_name().map(|file| part.path_in(file));
    let beside = beside.as_deref().map(Path::to_string_lossy);
    let mut other = None;
    for place in [Some(name), beside.as_deref()].into_iter().flatten() {
        let file = folder.join(place);
        match file_of(&file).file.metadata() {
            Ok(metadata) if metadata.len() != input.bytes => {
                let bytes = metadata.len();
                other = other.or(Some(format!(
                    "`{place}` has {bytes} bytes, {} were measured",
                    input.bytes
                )));
            }
            Ok(_) => match hash_file(&file) {
                Ok((hash, _)) if hash == input.blake3 => return Ok(place.to_owned()),
                Ok(_) => other = other.or(Some(format!("`{place}` has another content"))),
                Err(error) => other = other.or(Some(error.to_string())),
            },
            Err(_) => {}
        }
    }
    Err(other.unwrap_or_else(|| format!("`{name}` is not there")))
}

/// What distinguishes a cell from every other of its scene.
fn key(cell: &Cell) -> Value {
    json!([cell.image, cell.method, cell.params, cell.reconstruct])
}

/// The cells without duplicates: files of one content under two names give the same cell twice.
fn distinct(cells: &[Cell]) -> Vec<&Cell> {
    let mut seen = std::collections::HashSet::new();
    let mut all: Vec<&Cell> = cells.iter().collect();
    all.retain(|cell| seen.insert(format!("{} {}", cell.scene_id, key(cell))));
    all
}

/// The experiment whose matrix is these cells: its scenes are included, every parameter is written out.
fn experiment(written: &Value, scenes: &[SceneRecord], cells: &[&Cell]) -> Value {
    let list = |of: &dyn Fn(&Cell) -> Value| {
        let mut seen = Vec::new();
        for value in cells.iter().map(|cell| of(cell)) {
            if !seen.contains(&value) {
                seen.push(value);
            }
        }
        Value::Array(seen)
    };
    let method = |cell: &Cell| {
        let mut members = Map::from_iter([("method".to_owned(), json!(cell.method))]);
        members.extend(cell.params.clone());
        Value::Object(members)
    };
    let scenes: Vec<Value> = scenes.iter().map(|s| json!({"scene": s.scene})).collect();
    let mut value = written.clone();
    if let Some(members) = value.as_object_mut() {
        // Suns are in the scenes.
        members.remove("sun_elevation_deg");
        members.remove("view_steps");
        members.insert("scenes".to_owned(), scenes.into());
        members.insert("image".to_owned(), list(&|cell| json!(cell.image)));
        members.insert("methods".to_owned(), list(&method));
        let reconstruct = list(&|cell| json!(cell.reconstruct));
        members.insert("reconstruct".to_owned(), reconstruct);
    }
    value
}

/// Error: the cells made here from the report's scenes and settings are not those that it holds.
fn unlike(path: &Path, report: &Report) -> Error {
    let remedy = "Run its experiment file instead.";
    let problem = match report.sources == provenance::cell_sources() {
        true => "its cells are not those of its scenes, images, methods and parameters: somebody edited it".to_owned(),
        false => format!(
            "its cells are not those that this version makes of its scenes, images, methods and parameters: it was measured \
             by {}, which may have had others, or somebody edited it",
            report.environment.commit
        ),
    };
    Error::input(path.display().to_string(), problem, remedy)
}
