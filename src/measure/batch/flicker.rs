//! Flicker of the recorded cells of one view: every frame of a movement against that frame's own truth.
//!
//! Every pixel is marched, whatever a cell's `reconstruct` says; the error that reconstruction adds:
//! [`super::reconstruct`].
//!
//! Runs after the timed rounds. A cell's number is added to its record when the movement is over, so that a killed run
//! loses no cell; the truths of its finished frames are in the cache.

use super::cell::setup;
use super::record::{Cell, Measured, TrackRecord};
use super::{Event, Observer, Task, stage, tell};
use crate::backend::View;
use crate::config::{CellSpec, Experiment, Matrix, MatrixView};
use crate::cost::Counting;
use crate::error::{Error, Result};
use crate::metrics::{ErrorNumbers, Flicker};
use crate::occlusion::MethodSetup;
use crate::progress::unwatched;
use crate::scene::{Scene, Track};
use crate::truth::Truth;

/// A cell during a movement: its number so far, or why it has none.
struct FlickerCell {
    cell: Cell,
    setup: MethodSetup,
    flicker: Result<Flicker, String>,
}

/// Movements that the experiment asks for in this view, for the record.
pub(super) fn tracks(task: &Task, matrix: &MatrixView) -> Vec<TrackRecord> {
    let record = |track: &Track| TrackRecord {
        track: *track,
        frames: Track::FRAMES,
        step_deg: track.step_deg(&matrix.scene, matrix.image),
        step_m: track.step_m(&matrix.scene, matrix.image),
    };
    task.experiment.flicker.iter().map(record).collect()
}

/// Note on maps that are filled over several frames while nothing moves; `None` where there are none.
pub(super) fn note_of_rest(experiment: &Experiment, matrix: &Matrix) -> Result<Option<String>> {
    let mut specs = matrix.views.iter().take(1).flat_map(|view| &view.cells);
    let slow = specs.try_fold(false, |slow, spec| {
        Ok::<_, Error>(slow || setup(spec)?.fill_frames() > 1)
    })?;
    Ok((slow && experiment.flicker.is_empty()).then(|| {
        "`fill_frames` shows in times and bytes alone: at rest the picture is that of a map filled at once. Name movements \
         in `flicker` to measure what the age of a map costs"
            .to_owned()
    }))
}

/// Measures the flicker that the records of a view still lack; returns the seconds spent in passes.
pub(super) fn run_view(task: &Task, matrix: &MatrixView, observe: Observer) -> Result<f64> {
    let mut passes_s = 0.0;
    for track in &task.experiment.flicker {
        let mut cases = Vec::new();
        for spec in &matrix.cells {
            cases.extend(open_case(task, matrix, spec, *track)?);
        }
        if cases.is_empty() {
            continue;
        }
        passes_s += run_track(task, matrix, *track, &mut cases, observe)?;
        for case in cases {
            record(task, matrix, case, *track, observe)?;
        }
    }
    Ok(passes_s)
}

/// The cell, where it has numbers but neither this one nor a note why it is missing.
fn open_case(
    task: &Task,
    matrix: &MatrixView,
    spec: &CellSpec,
    track: Track,
) -> Result<Option<FlickerCell>> {
    let mut cell = task.store.cell(&task.identity.cell(matrix, spec))?;
    let noted = |result: &Measured| {
        let start = note(track, "");
        result.notes.iter().any(|note| note.starts_with(&start))
    };
    let open = cell
        .result
        .as_mut()
        .is_some_and(|result| numbers(&mut result.error, track).0.is_none() && !noted(result));
    Ok(if open {
        Some(FlickerCell {
            cell,
            setup: setup(spec)?,
            flicker: Ok(Flicker::default()),
        })
    } else {
        None
    })
}

/// Renders all frames of a movement with all cases.
fn run_track(
    task: &Task,
    matrix: &MatrixView,
    track: Track,
    cases: &mut [FlickerCell],
    observe: Observer,
) -> Result<f64> {
    let mut passes_s = 0.0;
    for frame in 0..Track::FRAMES {
        let scene = track.scene(&matrix.scene, matrix.image, frame);
        let what = format!("flicker, {} {}/{}", track.name(), frame + 1, Track::FRAMES);
        stage(observe, matrix, &what, 0.0)?;
        let prepared = task
            .backend
            .view(&scene, matrix.image)
            .and_then(|view| Ok((frame_truth(task, matrix, &view, &what, observe)?, view)));
        match prepared {
            Ok((truth, view)) => {
                passes_s += truth.passes_s;
                for case in &mut *cases {
                    let begun = map_frame(frame, case.setup.fill_frames());
                    let moment = Moment {
                        view: &view,
                        truth: &truth,
                        map_scene: (begun < frame)
                            .then(|| track.scene(&matrix.scene, matrix.image, begun)),
                    };
                    passes_s += run_case(task, &moment, case)?;
                }
            }
            Err(error) if error.concerns_one_cell() => {
                for case in &mut *cases {
                    case.flicker = Err(error.to_string());
                }
            }
            Err(error) => return Err(error),
        }
    }
    Ok(passes_s)
}

fn frame_truth(
    task: &Task,
    matrix: &MatrixView,
    view: &View,
    what: &str,
    observe: Observer,
) -> Result<Truth> {
    let mut progress = |share| observe(Event::stage(matrix, what, share));
    let truth = task
        .backend
        .truth(view, task.cache, Counting::Off, &mut progress)?;
    if let Some(note) = &truth.note {
        tell(observe, Event::Note(note.clone()))?;
    }
    Ok(truth)
}

/// A frame of a movement.
struct Moment<'a> {
    view: &'a View,
    truth: &'a Truth,
    /// The scene of the earlier frame whose light map is read; `None` = of this one.
    map_scene: Option<Scene>,
}

/// One frame of one case; returns the seconds of its passes.
fn run_case(task: &Task, moment: &Moment, case: &mut FlickerCell) -> Result<f64> {
    let Ok(flicker) = &mut case.flicker else {
        return Ok(0.0);
    };
    let mut add = || -> Result<f64> {
        let Moment { view, truth, .. } = moment;
        let map_scene = moment.map_scene.as_ref();
        let earlier = map_scene.map(|scene| task.backend.view(scene, view.image));
        let earlier = earlier.transpose()?;
        let prepared = match &earlier {
            None => task.backend.prepare_full(view, &case.setup)?,
            Some(earlier) => {
                let backend = task.backend;
                backend.prepare_with_map_of(earlier, view, &case.setup)?
            }
        };
        let times = prepared.run(&mut unwatched)?;
        flicker.add(&truth.frame, &prepared.picture()?)?;
        Ok(times.wall * 1e-3)
    };
    match add() {
        Err(error) if error.concerns_one_cell() => {
            case.flicker = Err(error.to_string());
            Ok(0.0)
        }
        other => other,
    }
}

/// Adds the number, or why there is none, to the cell's record.
fn record(
    task: &Task,
    matrix: &MatrixView,
    case: FlickerCell,
    track: Track,
    observe: Observer,
) -> Result<()> {
    let FlickerCell {
        mut cell, flicker, ..
    } = case;
    let text = |e: Error| e.to_string();
    let both = |f: Flicker| Ok((f.value().map_err(text)?, f.rel_rmse().map_err(text)?));
    let value = flicker.and_then(both);
    let Some(result) = &mut cell.result else {
        return Ok(());
    };
    match value {
        Ok((flicker, rel_rmse)) => {
            let numbers = numbers(&mut result.error, track);
            (*numbers.0, *numbers.1) = (Some(flicker), Some(rel_rmse));
        }
        Err(reason) => {
            let note = note(track, &reason);
            tell(
                observe,
                Event::Note(format!("{} {}: {note}", cell.scene, cell.method)),
            )?;
            result.notes.push(note);
        }
    }
    task.put_cell(matrix, &cell)
}

/// The numbers that a movement gives: flicker, and the error over all frames.
fn numbers(error: &mut ErrorNumbers, track: Track) -> (&mut Option<f64>, &mut Option<f64>) {
    match track {
        Track::Pan => (&mut error.flicker, &mut error.rel_rmse_pan),
        Track::Sun => (&mut error.flicker_sun, &mut error.rel_rmse_sun),
        Track::Dolly => (&mut error.flicker_dolly, &mut error.rel_rmse_dolly),
    }
}

/// Frame whose light map is read in a frame of a movement, where a map is filled over `fill_frames` frames: the one in
/// which the last complete map was begun, never before the first, ahead of which the scene rested.
fn map_frame(frame: u32, fill_frames: u32) -> u32 {
    fill_frames * ((frame + 1) / fill_frames).saturating_sub(1)
}

fn note(track: Track, reason: &str) -> String {
    format!("flicker, {}: {reason}", track.name())
}

#[cfg(test)]
mod tests {
    use super::map_frame;

    #[test]
    fn a_map_is_read_from_the_frame_that_completes_it_until_the_next_is_complete() {
        let begun = |fill_frames| (0..8).map(move |frame| map_frame(frame, fill_frames));
        assert!(begun(1).eq(0..8));
        assert!(begun(2).eq([0, 0, 0, 2, 2, 4, 4, 6]));
        assert!(begun(4).eq([0, 0, 0, 0, 0, 0, 0, 4]));
    }
}
