//! What temporal integration costs a picture: each temporal cell on a pan, every frame against the full render of that
//! frame by the same method, so that nothing but reconstruction differs.
//!
//! The pan begins at rest: four frames of the scene as it is make the first picture, so that the curve shows ghosting
//! come up, and not a history fill. Runs after the timed rounds, as flicker does, and joins the record when it is over.

use super::cell::{cell_id, setup};
use super::record::{Cell, Measured, Reconstruction};
use super::{Event, Observer, Task, stage, tell};
use crate::backend::{History, Prepared, View, history_bytes};
use crate::config::{CellSpec, View as MatrixView};
use crate::error::Result;
use crate::frame::Frame;
use crate::metrics::relative_rmse;
use crate::occlusion::MethodSetup;
use crate::raymarch::unwatched;
use crate::scene::{Reconstruct, Track};

/// How a note begins that says why there are no numbers.
const NOTE: &str = "reconstruction: ";

/// A temporal cell on the move.
struct Case {
    cell: Cell,
    setup: MethodSetup,
    history: History,
    /// Error of each frame so far, or why there is none.
    errors: Result<Vec<f64>, String>,
}

/// Runs a prepared cell until a resting camera sees the whole picture, but for the last frame; returns the seconds.
pub(super) fn fill(prepared: &Prepared, reconstruct: Reconstruct) -> Result<f64> {
    let mut passes_s = 0.0;
    for _ in 1..reconstruct.frames() {
        passes_s += prepared.run(&mut unwatched)?.wall * 1e-3;
    }
    Ok(passes_s)
}

/// Measures what the records of a view still lack; returns the seconds spent in passes.
pub(super) fn run_view(task: &Task, matrix: &MatrixView, observe: Observer) -> Result<f64> {
    let mut cases = Vec::new();
    for spec in &matrix.cells {
        cases.extend(open_case(task, matrix, spec)?);
    }
    if cases.is_empty() {
        return Ok(0.0);
    }
    let mut passes_s = 0.0;
    for frame in 0..Track::FRAMES {
        let what = format!("reconstruction {}/{}", frame + 1, Track::FRAMES);
        stage(
            observe,
            matrix,
            &what,
            f64::from(frame) / f64::from(Track::FRAMES),
        )?;
        let scene = Track::Pan.scene(&matrix.scene, matrix.image, frame);
        match task.backend.view(&scene, matrix.image) {
            Ok(view) => {
                for case in &mut cases {
                    passes_s += run_case(task, &view, frame == 0, case)?;
                }
            }
            Err(error) if error.concerns_one_cell() => {
                for case in &mut cases {
                    case.errors = Err(error.to_string());
                }
            }
            Err(error) => return Err(error),
        }
    }
    for case in cases {
        record(task, matrix, case, observe)?;
    }
    Ok(passes_s)
}

/// The cell, when it is temporal and has numbers, but neither these nor a note why not.
fn open_case(task: &Task, matrix: &MatrixView, spec: &CellSpec) -> Result<Option<Case>> {
    if spec.reconstruct.is_full() {
        return Ok(None);
    }
    let cell = task.store.cell(&cell_id(matrix, spec))?;
    let open = |result: &Measured| {
        let noted = result.notes.iter().any(|note| note.starts_with(NOTE));
        result.reconstruction.is_none() && !noted
    };
    if !cell.result.as_ref().is_some_and(open) {
        return Ok(None);
    }
    Ok(Some(Case {
        cell,
        setup: setup(spec)?,
        history: task.backend.history(matrix.image)?,
        errors: Ok(Vec::new()),
    }))
}

/// One frame of one case, at `rest` the four that fill its history; returns the seconds of its passes.
fn run_case(task: &Task, view: &View, rest: bool, case: &mut Case) -> Result<f64> {
    let Ok(errors) = &mut case.errors else {
        return Ok(0.0);
    };
    let mut passes_s = 0.0;
    let mut render = |prepared: Prepared, filling: Reconstruct| -> Result<Frame> {
        passes_s += fill(&prepared, filling)?;
        passes_s += prepared.run(&mut unwatched)?.wall * 1e-3;
        prepared.picture()
    };
    let mut error = || -> Result<f64> {
        let full = render(task.backend.prepare(view, &case.setup)?, Reconstruct::Full)?;
        let temporal = task
            .backend
            .prepare_temporal(view, &case.setup, &case.history)?;
        let filling = if rest {
            Reconstruct::Temporal2x2
        } else {
            Reconstruct::Full
        };
        let rebuilt = render(temporal, filling)?;
        relative_rmse(&full, &full, &rebuilt)
    };
    match error() {
        Ok(value) => errors.push(value),
        Err(error) if error.concerns_one_cell() => case.errors = Err(error.to_string()),
        Err(error) => return Err(error),
    }
    Ok(passes_s)
}

/// Adds the numbers, or why there are none, to the cell's record.
fn record(task: &Task, matrix: &MatrixView, case: Case, observe: Observer) -> Result<()> {
    let mut cell = case.cell;
    let Some(result) = &mut cell.result else {
        return Ok(());
    };
    match case.errors {
        Ok(errors) => {
            result.reconstruction = Some(Reconstruction {
                full_rel_rmse: errors[0],
                pan_step_deg: Track::Pan.step_deg(&matrix.scene, matrix.image),
                ghosting_rel_rmse: errors,
                history_bytes: history_bytes(cell.reconstruct, matrix.image),
            });
        }
        Err(reason) => {
            let note = format!("{NOTE}{reason}");
            let told = format!("{} {}: {note}", cell.scene, cell.method);
            tell(observe, Event::Note(told))?;
            result.notes.push(note);
        }
    }
    task.store.put_cell(&cell)
}
