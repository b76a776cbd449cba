//! Names and records of cells.

use super::record::{Cell, Times};
use super::{Event, Observer, Task, tell};
use crate::config::{CellSpec, View as MatrixView};
use crate::error::{Error, Result};
use crate::metrics::summarise;
use crate::occlusion::{MethodSetup, find};
use crate::raymarch::PassTimes;
use serde_json::json;

/// The method of a cell with its parameters.
pub(super) fn setup(spec: &CellSpec) -> Result<MethodSetup> {
    Ok(MethodSetup {
        method: find(&spec.method)?,
        params: spec.params.clone(),
    })
}

/// Statistics of each pass over the timed rounds.
pub(super) fn times(runs: &[PassTimes]) -> Times {
    let stats = |value: fn(&PassTimes) -> Option<f64>| {
        summarise(&runs.iter().filter_map(value).collect::<Vec<_>>())
    };
    Times {
        generate: stats(|t| t.generate),
        march: stats(|t| t.march),
        reconstruct: stats(|t| t.reconstruct),
        total: stats(PassTimes::total),
        wall: stats(|t| Some(t.wall)),
    }
}

/// A record without numbers.
pub(super) fn bare_cell(task: &Task, view: &MatrixView, spec: &CellSpec) -> Cell {
    let environment = task.backend.environment();
    Cell {
        id: task.identity.cell(view, spec),
        backend: format!("{} {}", environment.backend, environment.device_type),
        ..planned_cell(view, spec)
    }
}

/// What a record will say of a cell before it is measured anywhere; its keys come with the measurement.
pub fn planned_cell(view: &MatrixView, spec: &CellSpec) -> Cell {
    Cell {
        id: String::new(),
        index: spec.index,
        scene: view.scene.name.clone(),
        scene_id: String::new(),
        scene_set: view.scene_set.clone(),
        sun_elevation_deg: view.scene.sun.elevation_deg,
        method: spec.method.clone(),
        params: spec
            .params
            .iter()
            .map(|(k, v)| (k.to_owned(), json!(v)))
            .collect(),
        reconstruct: spec.reconstruct,
        backend: String::new(),
        image: view.image,
        failed: None,
        result: None,
    }
}

/// Records why a cell has no numbers, and goes on.
pub(super) fn record_failure(
    task: &Task,
    view: &MatrixView,
    spec: &CellSpec,
    error: &Error,
    observe: Observer,
) -> Result<()> {
    let cell = Cell {
        failed: Some(error.to_string()),
        ..bare_cell(task, view, spec)
    };
    task.put_cell(view, &cell)?;
    tell(observe, Event::Cell(Box::new(cell)))
}
