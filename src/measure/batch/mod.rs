//! Runs a batch: experiment → stream of events → records on disk. Command line, tests and windows only consume the
//! events.

mod block;
mod cell;
pub mod clock;
mod decompose;
mod flicker;
mod identity;
pub mod lock;
pub mod numbers;
mod pictures;
mod plan;
mod reconstruct;
pub mod record;
mod rounds;
mod store;
mod view_steps;

use crate::backend::Backend;
use crate::config::{Experiment, MatrixView};
use crate::error::{Error, Result};
use crate::truth::TruthCache;
pub use cell::planned_cell;
use identity::Identity;
use lock::Lock;
pub use plan::{BatchPlan, report_file};
use record::{Cell, Reference, Report, SCHEMA, SceneRecord, WallClock};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;
use store::{FolderState, Store};

/// An event of a batch.
#[derive(Clone, Debug)]
pub enum Event {
    /// The matrix is known; `done` cells were found in the folder and are not repeated.
    Planned {
        /// Cells of the matrix.
        cells: usize,
        /// Cells recorded by an earlier run.
        done: usize,
    },
    /// A message for the user, one line.
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

/// Settings that all views of a batch share.
struct Task<'a> {
    experiment: &'a Experiment,
    backend: &'a Backend,
    store: &'a Store,
    identity: &'a Identity,
    cache: Option<&'a TruthCache>,
}

impl Task<'_> {
    /// Records a cell, unless the file of its scene has changed since the batch began.
    fn put_cell(&self, view: &MatrixView, cell: &Cell) -> Result<()> {
        self.identity.check(&view.scene)?;
        self.store.put_cell(cell)
    }
}

/// Measures the missing cells of an experiment in `folder`; returns the report, which is not yet written.
pub fn run(
    experiment: &Experiment,
    backend: &Backend,
    folder: &Path,
    cache: Option<&TruthCache>,
    observe: Observer,
) -> Result<Report> {
    let plan = BatchPlan::new(experiment.clone())?;
    measure(&plan, backend, folder, cache, observe)
}

/// Measures the missing cells of a plan in `folder`, which no other run may use meanwhile; returns the report, which is
/// not yet written.
pub fn measure(
    plan: &BatchPlan,
    backend: &Backend,
    folder: &Path,
    cache: Option<&TruthCache>,
    observe: Observer,
) -> Result<Report> {
    let start = Instant::now();
    let compiled_s = backend.compile_s();
    let _lock = Lock::take(folder)?;
    let matrix = plan.matrix();
    let identity = Identity::new(backend, matrix)?;
    let wanted = FolderState {
        experiment: plan.recorded().clone(),
        environment: backend.environment(),
        sources: identity.sources().to_owned(),
        inputs: identity.hashes(),
        wall: WallClock::default(),
    };
    let (mut store, found) = Store::open(folder, wanted)?;
    let cells = matrix.views.iter().flat_map(|v| {
        let ids = v.cells.iter().map(move |c| (v, c));
        ids.map(|(v, c)| identity.cell(v, c))
    });
    let done = cells.filter(|id| store.has(id)).count();
    tell(
        observe,
        Event::Planned {
            cells: matrix.cell_count(),
            done,
        },
    )?;
    let again = plan.differs_from(identity.sources(), &backend.environment().commit);
    let still = flicker::note_of_rest(plan.experiment(), matrix)?;
    let notes = found.iter().chain(&again).chain(&matrix.notes);
    for note in notes.chain(&still) {
        tell(observe, Event::Note(note.clone()))?;
    }
    let mut passes_s = 0.0;
    let mut outcome = Ok(());
    let task = Task {
        experiment: plan.experiment(),
        backend,
        store: &store,
        identity: &identity,
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
    assemble(plan, &identity, &store)
}

/// Timed rounds, then flicker and ghosting; returns the seconds spent in passes.
fn run_view(task: &Task, view: &MatrixView, observe: Observer) -> Result<f64> {
    let timed_s = block::run_view(task, view, observe)?;
    let flicker_s = flicker::run_view(task, view, observe)?;
    Ok(timed_s + flicker_s + reconstruct::run_view(task, view, observe)?)
}

/// The report of a folder from its records and its plan. Records are keyed by content, so that one may have been
/// measured under another name of its file: names come from the plan.
fn assemble(plan: &BatchPlan, identity: &Identity, store: &Store) -> Result<Report> {
    let mut cells = Vec::new();
    let mut references = Vec::new();
    let mut clock = Vec::new();
    let mut scenes: Vec<SceneRecord> = Vec::new();
    for view in &plan.matrix().views {
        let scene = identity.scene(&view.scene, store.folder());
        let id = identity.view(view);
        if references.iter().all(|known: &Reference| known.id != id) {
            references.extend(store.reference(&id)?);
            clock.extend(store.clock(&id)?);
        }
        for spec in &view.cells {
            cells.push(Cell {
                index: spec.index,
                scene_id: scene.id.clone(),
                scene_set: view.scene_set.clone(),
                ..store.cell(&identity.cell(view, spec))?
            });
        }
        if scenes.iter().all(|known| known.id != scene.id) {
            scenes.push(scene);
        }
    }
    let state = store.state();
    Ok(Report {
        schema: SCHEMA.to_owned(),
        environment: state.environment.clone(),
        sources: state.sources.clone(),
        experiment: state.experiment.clone(),
        scenes,
        inputs: identity.files(store.folder()),
        cells,
        references,
        clock,
        claims: Vec::new(),
        wall: state.wall.clone(),
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
