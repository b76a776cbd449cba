//! Configuration files → checked values: scenes, experiments, the matrix of cells, the JSON Schema of all of them.
//!
//! ```text
//! scene.json ─► Document ─► Scene
//! experiment.json ─► Document ─► Experiment ─ expand(catalogue) ─► Matrix ─► batch
//! ```
//!
//! The shipped files are compiled into the program ([`shipped`]): a path without a file stands for the built-in one.
//! Every error names the file, line, column and JSON pointer. No GPU types here.

mod document;
mod experiment;
mod locate;
mod matrix;
mod methods;
mod reconstructions;
mod scenes;
mod schema;
pub mod shipped;
mod stability;
mod study;
mod suggest;
#[cfg(test)]
mod tests;
mod wanted;

pub use document::{Document, MAX_FILE_BYTES};
pub use experiment::{Experiment, MethodEntry, load_experiment, parse_experiment};
pub use matrix::{CellSpec, MAX_CELLS, Matrix, MatrixView, describe, expand};
pub use methods::MethodCatalogue;
pub use reconstructions::Catalogue;
pub use scenes::{SceneAxis, SceneEntry};
pub use schema::schema;
pub use stability::{Extreme, Fill, Stability, VolumeFile, load_stability, parse_stability};
pub use study::{
    ChartSpec, Check, ClaimSpec, CostChart, CostSpec, Erratum, Evidence, Pick, Prices, Published,
    Quantity, Question, Series, Study, StudyExperiment, TableColumn, TableRow, TableSpec, Test,
    load_study, parse_study, study_profiles,
};

pub use experiment::experiment_of;
pub use suggest::sentence as suggestion;

use crate::error::Result;
use crate::scene::Scene;
use document::Fault;
use std::path::Path;

/// Reads, checks and resolves a scene file; volume paths become relative to the file's folder.
pub fn load_scene(path: &Path) -> Result<Scene> {
    let document = Document::read(path)?;
    scene_of(document.value(), document.folder()).map_err(|fault| document.fault(fault))
}

/// A scene from its JSON value: types, then ranges, then paths relative to `folder`.
fn scene_of(value: &serde_json::Value, folder: &Path) -> Result<Scene, Fault> {
    let mut scene: Scene = document::deserialize(value)?;
    scene.validate()?;
    scene.resolve_paths(folder);
    if scene.input_file().is_some() {
        // Checked again: the path now includes the folder's name.
        scene.density.field().validate(&scene.container)?;
    }
    Ok(scene)
}
