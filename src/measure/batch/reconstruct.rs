//! Error and memory of a reconstruction: at rest, and, where it has a history, along movements of the camera. Every
//! frame is compared with the full render of that frame by the same method, so that nothing but the reconstruction
//! differs.
//!
//! A movement begins at rest, with a filled history, so that the curve shows how ghosting builds up and not how the
//! history fills. Runs after the timed rounds, as flicker does; the numbers are added to the record when the movement
//! is over.

use super::block::BLOCK_BYTES;
use super::cell::setup;
use super::record::{Cell, Ghosting, Measured, ReconstructionNumbers};
use super::{Event, Observer, Task, stage, tell};
use crate::backend::{Prepared, Sequence, View};
use crate::config::{CellSpec, MatrixView};
use crate::error::Result;
use crate::frame::Frame;
use crate::metrics::ghosting;
use crate::occlusion::MethodSetup;
use crate::progress::unwatched;
use crate::scene::{CameraTrack, ReconstructionInfo, Track};

/// A cell during a movement.
struct MovingCell {
    cell: Cell,
    /// Frames so far, or why the cell has no numbers.
    moving: Result<Moving, String>,
}

struct Moving {
    setup: MethodSetup,
    reconstruct: &'static ReconstructionInfo,
    sequence: Sequence,
    /// Error of each frame.
    rel_rmse: Vec<f64>,
}

/// Renders all but the last of the frames after which the picture of a resting camera no longer changes; returns the
/// seconds.
pub(super) fn fill(prepared: &Prepared, reconstruct: &ReconstructionInfo) -> Result<f64> {
    let mut passes_s = 0.0;
    for _ in 1..reconstruct.rest.frames {
        passes_s += prepared.run(&mut unwatched)?.wall * 1e-3;
    }
    Ok(passes_s)
}

/// Error and memory of a cell's reconstruction at rest, and the seconds of the full render; `None` where every pixel is
/// marched. `frame` is the cell's picture.
pub(super) fn at_rest(
    task: &Task,
    view: &View,
    spec: &CellSpec,
    setup: &MethodSetup,
    frame: &Frame,
) -> Result<Option<(ReconstructionNumbers, f64)>> {
    if spec.reconstruct.is_full() {
        return Ok(None);
    }
    let full = task.backend.prepare_full(view, setup)?;
    let passes_s = full.run(&mut unwatched)?.wall * 1e-3;
    let record = ReconstructionNumbers {
        full_rel_rmse: ghosting(&full.picture()?, frame)?,
        history_bytes: spec.reconstruct.history_bytes(view.image),
        ..ReconstructionNumbers::default()
    };
    Ok(Some((record, passes_s)))
}

/// Measures the ghosting that the records of a view still lack; returns the seconds spent in passes.
pub(super) fn run_view(task: &Task, matrix: &MatrixView, observe: Observer) -> Result<f64> {
    let mut passes_s = 0.0;
    for track in &task.experiment.ghosting {
        let mut open = Vec::new();
        for spec in &matrix.cells {
            open.extend(open_cell(task, matrix, spec, *track)?.map(|cell| (spec, cell)));
        }
        while !open.is_empty() {
            let bytes = open
                .iter()
                .map(|(spec, _)| spec.reconstruct.history_bytes(matrix.image));
            let rest = open.split_off(open.len().min(histories_held(bytes.max())));
            let mut cases = Vec::new();
            for (spec, cell) in open {
                let moving = noted(moving(task, matrix, spec))?;
                cases.push(MovingCell { cell, moving });
            }
            passes_s += run_track(task, matrix, *track, &mut cases, observe)?;
            for case in cases {
                record(task, matrix, case, *track, observe)?;
            }
            open = rest;
        }
    }
    Ok(passes_s)
}

/// Number of histories of at most `bytes` each that fit into [`BLOCK_BYTES`], at least one.
fn histories_held(bytes: Option<u64>) -> usize {
    let each = bytes.unwrap_or_default().max(1);
    usize::try_from(BLOCK_BYTES / each).map_or(usize::MAX, |n| n.max(1))
}

/// The cell's record, where its reconstruction has a history and it has numbers, but neither the ghosting along this
/// movement nor a note why it is missing.
fn open_cell(
    task: &Task,
    matrix: &MatrixView,
    spec: &CellSpec,
    track: CameraTrack,
) -> Result<Option<Cell>> {
    if spec.reconstruct.history.is_none() {
        return Ok(None);
    }
    let cell = task.store.cell(&task.identity.cell(matrix, spec))?;
    let open = |result: &Measured| {
        let start = note(track, "");
        let noted = result.notes.iter().any(|note| note.starts_with(&start));
        let parts = result.reconstruction.as_ref();
        parts.is_some_and(|parts| !parts.ghosting.contains_key(&track)) && !noted
    };
    let open = cell.result.as_ref().is_some_and(open);
    Ok(open.then_some(cell))
}

fn moving(task: &Task, matrix: &MatrixView, spec: &CellSpec) -> Result<Moving> {
    Ok(Moving {
        setup: setup(spec)?,
        reconstruct: spec.reconstruct,
        sequence: task.backend.sequence(spec.reconstruct, matrix.image)?,
        rel_rmse: Vec::new(),
    })
}

/// Turns an error that concerns one cell alone into its note; any other ends the batch.
fn noted<T>(result: Result<T>) -> Result<Result<T, String>> {
    match result {
        Ok(value) => Ok(Ok(value)),
        Err(error) if error.concerns_one_cell() => Ok(Err(error.to_string())),
        Err(error) => Err(error),
    }
}

/// Renders all frames of a movement with all cases.
fn run_track(
    task: &Task,
    matrix: &MatrixView,
    track: CameraTrack,
    cases: &mut [MovingCell],
    observe: Observer,
) -> Result<f64> {
    let mut passes_s = 0.0;
    for frame in 0..Track::FRAMES {
        let what = format!("ghosting, {} {}/{}", track.name(), frame + 1, Track::FRAMES);
        let share = f64::from(frame) / f64::from(Track::FRAMES);
        stage(observe, matrix, &what, share)?;
        let scene = track.scene(&matrix.scene, matrix.image, frame);
        match noted(task.backend.view(&scene, matrix.image))? {
            Ok(view) => {
                for case in &mut *cases {
                    passes_s += run_case(task, &view, frame == 0, case)?;
                }
            }
            Err(reason) => {
                for case in &mut *cases {
                    case.moving = Err(reason.clone());
                }
            }
        }
    }
    Ok(passes_s)
}

/// One frame of one case, or at `rest` all that fill its history; returns the seconds of its passes.
fn run_case(task: &Task, view: &View, rest: bool, case: &mut MovingCell) -> Result<f64> {
    let Ok(moving) = &mut case.moving else {
        return Ok(0.0);
    };
    let mut passes_s = 0.0;
    match noted(run_frame(task, view, rest, moving, &mut passes_s))? {
        Ok(error) => moving.rel_rmse.push(error),
        Err(reason) => case.moving = Err(reason),
    }
    Ok(passes_s)
}

/// Error of one frame.
fn run_frame(
    task: &Task,
    view: &View,
    rest: bool,
    moving: &Moving,
    passes_s: &mut f64,
) -> Result<f64> {
    let full = task.backend.prepare_full(view, &moving.setup)?;
    *passes_s += full.run(&mut unwatched)?.wall * 1e-3;
    let full = full.picture()?;
    let next = task
        .backend
        .prepare(view, &moving.setup, &moving.sequence)?;
    if rest {
        *passes_s += fill(&next, moving.reconstruct)?;
    }
    *passes_s += next.run(&mut unwatched)?.wall * 1e-3;
    ghosting(&full, &next.picture()?)
}

/// Adds the curve, or why there is none, to the cell's record.
fn record(
    task: &Task,
    matrix: &MatrixView,
    case: MovingCell,
    track: CameraTrack,
    observe: Observer,
) -> Result<()> {
    let mut cell = case.cell;
    let Some(result) = &mut cell.result else {
        return Ok(());
    };
    match (case.moving, &mut result.reconstruction) {
        (Ok(moving), Some(parts)) => {
            let curve = Ghosting {
                step_deg: track.step_deg(&matrix.scene, matrix.image),
                step_m: track.step_m(&matrix.scene, matrix.image),
                rel_rmse: moving.rel_rmse,
            };
            parts.ghosting.insert(track, curve);
        }
        (Ok(_), None) => {}
        (Err(reason), _) => {
            let note = note(track, &reason);
            let told = format!("{} {}: {note}", cell.scene, cell.method);
            tell(observe, Event::Note(told))?;
            result.notes.push(note);
        }
    }
    task.put_cell(matrix, &cell)
}

fn note(track: CameraTrack, reason: &str) -> String {
    format!("ghosting, {}: {reason}", track.name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn histories_held_at_once_fit_a_block() {
        let held = |bytes| histories_held(Some(bytes));
        let bytes = 1920 * 1080 * 72;
        let n = held(bytes) as u64;
        assert!(n * bytes <= BLOCK_BYTES && (n + 1) * bytes > BLOCK_BYTES);
        assert_eq!(held(8192 * 8192 * 72), 1, "one is always tried");
        assert!(held(2 * 2 * 72) > 1000 && histories_held(None) > 1000);
    }

    #[test]
    fn only_what_concerns_one_cell_becomes_a_note() {
        let lost: Result<()> = Err(Error::gpu("out of memory", "Choose a smaller image."));
        assert!(noted(lost).is_ok_and(|told| told.is_err()));
        assert!(noted::<()>(Err(Error::Stopped)).is_err());
    }
}
