//! Experiment → stream of events → records on disk. The only orchestrator: command line, tests and windows consume its
//! events and decide nothing.

mod block;
mod cell;
pub mod clock;
mod decompose;
mod flicker;
mod pictures;
mod reconstruct;
pub mod record;
mod rounds;
mod store;
mod view_steps;

use crate::backend::Backend;
use crate::config::{Experiment, Matrix, View as MatrixView, expand};
use crate::error::{Error, Result};
use crate::occlusion::Registry;
use crate::raymarch::TruthCache;
pub use cell::planned_cell;
use record::{Cell, Report, SCHEMA};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;
use store::Store;

/// What happens during a batch.
#[derive(Clone, Debug)]
pub enum Event {
    /// The matrix is known; `done` cells were found in the folder and are not repeated.
    Planned {
        /// Cells of the matrix.
        cells: usize,
        /// Cells recorded by an earlier run.
        done: usize,
    },
    /// Something the user should know, one line.
    Note(String),
    /// A stage of a view progressed.
    Stage {
        /// What is being done, e.g. `cumulus 60°: truth`.
        what: String,
        /// Finished share, 0…1.
        share: f64,
    },
    /// A cell was recorded.
    Cell(Box<Cell>),
}

impl Event {
    fn stage(view: &MatrixView, what: &str, share: f64) -> Self {
        let (scene, image) = (&view.scene, view.image);
        let what = format!(
            "{} {}° {}×{}: {what}",
            scene.name, scene.sun.elevation_deg, image.width, image.height
        );
        Self::Stage { what, share }
    }
}

/// Receives events; `Break` stops the batch, finished cells are kept.
pub type Observer<'a> = &'a mut dyn FnMut(Event) -> ControlFlow<()>;

/// What every view of a batch is measured with.
struct Task<'a> {
    experiment: &'a Experiment,
    backend: &'a Backend,
    store: &'a Store,
    cache: Option<&'a TruthCache>,
}

/// Runs what is missing of an experiment in `folder`; returns the report, which is not yet written.
pub fn run(
    experiment: &Experiment,
    backend: &Backend,
    folder: &Path,
    cache: Option<&TruthCache>,
    observe: Observer,
) -> Result<Report> {
    let start = Instant::now();
    let compiled_s = backend.compile_s();
    let matrix = expand(experiment, &Registry)?;
    let mut store = Store::open(
        folder,
        experiment.document().value(),
        &backend.environment(),
    )?;
    let done = matrix
        .views
        .iter()
        .flat_map(|v| v.cells.iter().map(move |c| cell::cell_id(v, c)))
        .filter(|id| store.has(id))
        .count();
    tell(
        observe,
        Event::Planned {
            cells: matrix.cell_count(),
            done,
        },
    )?;
    for note in &matrix.notes {
        tell(observe, Event::Note(note.clone()))?;
    }
    let mut passes_s = 0.0;
    let mut outcome = Ok(());
    let task = Task {
        experiment,
        backend,
        store: &store,
        cache,
    };
    for view in &matrix.views {
        let ran = run_view(&task, view, observe);
        match ran {
            Ok(seconds) => passes_s += seconds,
            Err(error) => {
                outcome = Err(error);
                break;
            }
        }
    }
    store.add_wall(
        start.elapsed().as_secs_f64(),
        passes_s,
        backend.compile_s() - compiled_s,
    )?;
    outcome?;
    assemble(&matrix, &store)
}

/// Timed rounds, then flicker and ghosting; returns the seconds spent in passes.
fn run_view(task: &Task, view: &MatrixView, observe: Observer) -> Result<f64> {
    let timed_s = block::run_view(task, view, observe)?;
    let flicker_s = flicker::run_view(task, view, observe)?;
    Ok(timed_s + flicker_s + reconstruct::run_view(task, view, observe)?)
}

/// The report of a folder from its records alone.
fn assemble(matrix: &Matrix, store: &Store) -> Result<Report> {
    let mut cells = Vec::new();
    let mut references = Vec::new();
    let mut clock = Vec::new();
    for view in &matrix.views {
        references.extend(store.reference(&cell::view_id(view))?);
        for spec in &view.cells {
            let id = cell::cell_id(view, spec);
            let mut cell = store.cell(&id)?;
            cell.index = spec.index;
            cells.push(cell);
        }
        clock.extend(store.clock(&cell::view_id(view))?);
    }
    Ok(Report {
        schema: SCHEMA.to_owned(),
        environment: store.state().environment.clone(),
        experiment: store.state().experiment.clone(),
        cells,
        references,
        clock,
        claims: Vec::new(),
        wall: store.state().wall.clone(),
    })
}

fn stage(observe: Observer, view: &MatrixView, what: &str, share: f64) -> Result<()> {
    tell(observe, Event::stage(view, what, share))
}

fn tell(observe: Observer, event: Event) -> Result<()> {
    match observe(event) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Stopped),
    }
}

/// Folder of an experiment's report below `parent`: its name, reduced to characters every file system takes.
pub fn report_folder(parent: &Path, name: &str) -> PathBuf {
    let safe: String = name
        .chars()
        .take(80)
        .map(|c| {
            if c.is_ascii_alphanumeric() || "-_".contains(c) {
                c
            } else {
                '-'
            }
        })
        .collect();
    parent.join(if safe.is_empty() {
        "report".to_owned()
    } else {
        safe
    })
}
