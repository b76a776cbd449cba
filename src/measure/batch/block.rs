//! One view of the matrix: its truth, then all its cells in interleaved rounds.
//!
//! Rounds go over all cells before the next begins, so that a drift of the machine's speed affects all methods equally
//! and ratios can be taken inside a round. Nothing but passes runs between the first timed round and the last: pictures
//! are read back in the first discarded round, counted, compared and written after the last. Frames in flight of a
//! cell: [`super::rounds`]; clock of the device during the block: [`super::clock`].

use super::cell::{bare_cell, each_round, record_failure, setup, times};
use super::clock::Watch;
use super::decompose::{Decomposer, Parts};
use super::pictures::{write_compared, write_parts, write_picture};
use super::record::{Cell, Measured, Reference};
use super::rounds::{self, Round};
use super::view_steps::view_step_error;
use super::{Event, Observer, Task, flicker, reconstruct, stage, tell};
use crate::backend::{Prepared, View};
use crate::config::{CellSpec, MatrixView};
use crate::cost::Counting;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::metrics::{ErrorNumbers, compare};
use crate::occlusion::MethodSetup;
use crate::progress::unwatched;
use crate::scene::ImageSize;
use crate::truth::Truth;
use serde_json::json;
use std::collections::HashMap;

/// Maps, pictures and histories held at once, bytes; a view with more cells is measured in several blocks.
pub(super) const BLOCK_BYTES: u64 = 2 << 30;

/// A cell being measured.
struct TimedCell<'a> {
    spec: &'a CellSpec,
    setup: MethodSetup,
    prepared: Prepared<'a>,
    frame: Option<Frame>,
    /// Latest estimate of a frame's time, ms; infinite before the first frame.
    frame_ms: f64,
    rounds: Vec<Round>,
}

impl TimedCell<'_> {
    /// First round: one frame that is waited for; its picture is kept.
    fn first(&mut self) -> Result<Round> {
        let filled_s = reconstruct::fill(&self.prepared, self.spec.reconstruct)?;
        let times = self.prepared.run(&mut unwatched)?;
        self.frame = Some(self.prepared.picture()?);
        self.frame_ms = rounds::cost_ms(&times);
        Ok(Round {
            times,
            total_ms: times.total(),
            frames: 1,
            refused: times.refused.into(),
            seconds: filled_s + times.wall * 1e-3,
        })
    }
}

/// State of one view.
struct Bench<'a> {
    task: &'a Task<'a>,
    matrix: &'a MatrixView,
    view: &'a View,
    truth: Truth,
    /// `rel_rmse` of the uncompressed light column, by the map parameters that it shares with a cell.
    floors: HashMap<String, f64>,
    /// Made for the first cell that is decomposed.
    decomposer: Option<Decomposer>,
    passes_s: f64,
}

/// Measures the cells that are not recorded yet; returns the seconds spent in passes.
pub(super) fn run_view(task: &Task, matrix: &MatrixView, observe: Observer) -> Result<f64> {
    let missing: Vec<_> = matrix
        .cells
        .iter()
        .filter(|spec| !task.store.has(&task.identity.cell(matrix, spec)))
        .collect();
    if missing.is_empty() {
        return Ok(0.0);
    }
    let (view, scene_s) = match open_view(task, matrix, observe) {
        Ok(opened) => opened,
        Err(error) => return refuse(task, matrix, &missing, error, observe),
    };
    let mut bench = match Bench::new(task, matrix, &view, scene_s, observe) {
        Ok(bench) => bench,
        Err(error) => return refuse(task, matrix, &missing, error, observe),
    };
    let mut rest = &missing[..];
    while !rest.is_empty() {
        rest = bench.block(rest, observe)?;
    }
    Ok(bench.passes_s)
}

/// The view, and the seconds that making its scene ready took without compilation.
fn open_view(task: &Task, matrix: &MatrixView, observe: Observer) -> Result<(View, f64)> {
    stage(observe, matrix, "scene", 0.0)?;
    let (start, compiled_s) = (std::time::Instant::now(), task.backend.compile_s());
    let view = task.backend.view(&matrix.scene, matrix.image)?;
    let scene_s = start.elapsed().as_secs_f64() - (task.backend.compile_s() - compiled_s);
    Ok((view, scene_s))
}

/// Records in every missing cell why its scene cannot be rendered on this adapter; the other scenes go on.
fn refuse(
    task: &Task,
    matrix: &MatrixView,
    missing: &[&CellSpec],
    error: Error,
    observe: Observer,
) -> Result<f64> {
    if !matches!(error, Error::Gpu { .. }) {
        return Err(error);
    }
    for spec in missing {
        record_failure(task, matrix, spec, &error, observe)?;
    }
    Ok(0.0)
}

impl<'a> Bench<'a> {
    fn new(
        task: &'a Task,
        matrix: &'a MatrixView,
        view: &'a View,
        scene_s: f64,
        observe: Observer,
    ) -> Result<Self> {
        let mut progress = |share| observe(Event::stage(matrix, "truth", share));
        let truth = task
            .backend
            .truth(view, task.cache, Counting::On, &mut progress)?;
        if let Some(note) = &truth.note {
            tell(observe, Event::Note(note.clone()))?;
        }
        let mut bench = Self {
            task,
            matrix,
            view,
            passes_s: scene_s + truth.passes_s,
            truth,
            floors: HashMap::new(),
            decomposer: None,
        };
        bench.record_reference(observe)?;
        Ok(bench)
    }

    /// Pictures are written first: a truth that has a record is complete, and a resumed run keeps it.
    fn record_reference(&mut self, observe: Observer) -> Result<()> {
        let (task, matrix) = (self.task, self.matrix);
        let id = task.identity.view(matrix);
        if task.store.reference(&id)?.is_some() {
            return Ok(());
        }
        stage(observe, matrix, "view steps", 0.0)?;
        let (frame, cost) = (&self.truth.frame, self.truth.cost);
        let files = write_picture(task.store, &format!("truth-{id}"), frame, frame)?;
        let (view_step_rel_rmse, passes_s) = view_step_error(task, self.view)?;
        self.passes_s += passes_s;
        let reference = Reference {
            id: id.clone(),
            scene: matrix.scene.name.clone(),
            sun_elevation_deg: matrix.scene.sun.elevation_deg,
            image: matrix.image,
            march_ms: cost.march_ms,
            wall_ms: Some(cost.wall_ms),
            light_samples: cost.samples.map(|samples| samples.light),
            view_samples: cost.samples.map(|samples| samples.view),
            cached: self.truth.cached,
            view_steps: match matrix.scene.march.step_m {
                Some(_) => None,
                None => Some(matrix.scene.march.steps),
            },
            view_step_rel_rmse,
            tracks: flicker::tracks(task, matrix),
            files,
        };
        task.identity.check(&matrix.scene)?;
        task.store.put_reference(&id, &reference)
    }

    /// Prepares as many cells as fit, measures and records them; returns the others.
    fn block<'s>(
        &mut self,
        specs: &'s [&'a CellSpec],
        observe: Observer,
    ) -> Result<&'s [&'a CellSpec]> {
        let mut runs = Vec::new();
        let mut bytes = 0;
        let mut taken = 0;
        for spec in specs {
            if bytes > BLOCK_BYTES {
                break;
            }
            taken += 1;
            match self.prepare(spec) {
                Ok(run) => {
                    let image = self.matrix.image;
                    bytes += run.prepared.memory.map_bytes + frame_bytes(image);
                    bytes += spec.reconstruct.history_bytes(image);
                    runs.push(run);
                }
                Err(error) => record_failure(self.task, self.matrix, spec, &error, observe)?,
            }
        }
        let block = specs[0].index;
        self.rounds(&mut runs, block, observe)?;
        for run in runs {
            let spec = run.spec;
            match self.measure(run, block) {
                Ok(cell) => {
                    self.task.put_cell(self.matrix, &cell)?;
                    tell(observe, Event::Cell(Box::new(cell)))?;
                }
                Err(error) if error.concerns_one_cell() => {
                    record_failure(self.task, self.matrix, spec, &error, observe)?;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(&specs[taken..])
    }

    fn prepare(&self, spec: &'a CellSpec) -> Result<TimedCell<'a>> {
        let setup = setup(spec)?;
        let backend = self.task.backend;
        let sequence = backend.sequence(spec.reconstruct, self.matrix.image)?;
        let prepared = backend.prepare(self.view, &setup, &sequence)?;
        Ok(TimedCell {
            spec,
            setup,
            prepared,
            frame: None,
            frame_ms: f64::INFINITY,
            rounds: Vec::new(),
        })
    }

    fn rounds(&mut self, runs: &mut [TimedCell], block: usize, observe: Observer) -> Result<()> {
        if runs.is_empty() {
            return Ok(());
        }
        let task = self.task;
        let (discard, timed) = task
            .backend
            .rounds(task.experiment.discard, task.experiment.runs);
        let rounds = discard + timed;
        let mut watch = Watch::new(task.backend)?;
        let aim_ms = watch.in_flight_ms();
        for round in 0..rounds {
            if round == discard {
                stage(observe, self.matrix, "until the clock settles", 0.0)?;
                watch.settle(&task.identity.view(self.matrix), block)?;
                // The probe is arithmetic alone; frames of the cells raise the memory clock.
                for run in runs.iter_mut().filter(|_| watch.has_clock()) {
                    let made = rounds::fly(&run.prepared, aim_ms, &mut run.frame_ms, &mut || ())?;
                    self.passes_s += made.seconds;
                }
            }
            watch.between_rounds()?;
            let count = runs.len() as f64;
            for (i, run) in runs.iter_mut().enumerate() {
                let share = (f64::from(round) + i as f64 / count) / f64::from(rounds);
                let what = format!("round {}/{rounds}", round + 1);
                stage(observe, self.matrix, &what, share)?;
                let made = match round {
                    0 => run.first()?,
                    _ => rounds::fly(&run.prepared, aim_ms, &mut run.frame_ms, &mut || {
                        if round >= discard {
                            watch.read();
                        }
                    })?,
                };
                self.passes_s += made.seconds;
                if round >= discard {
                    run.rounds.push(made);
                }
            }
        }
        watch.between_rounds()?;
        self.passes_s += watch.seconds;
        match watch.finish() {
            Some(record) => task.store.put_clock(&record),
            None => Ok(()),
        }
    }

    fn measure(&mut self, run: TimedCell, block: usize) -> Result<Cell> {
        let frame = run
            .frame
            .ok_or_else(|| Error::defect("batch", "a cell was never rendered"))?;
        let id = self.task.identity.cell(self.matrix, run.spec);
        let comparison = compare(&self.truth.frame, &frame)?;
        let (counts, counting_s) = run.prepared.counts(&mut unwatched)?;
        self.passes_s += counting_s;
        let error = ErrorNumbers {
            floor_rel_rmse: self.floor(&run.setup)?,
            ..comparison.error
        };
        let mut files = write_compared(self.task.store, &id, &self.truth.frame, &frame)?;
        let mut notes: Vec<String> = rounds::note(&run.rounds).into_iter().collect();
        let decomposition = match self.decompose(&run.setup, &frame) {
            Ok(None) => None,
            Ok(Some((record, parts))) => {
                write_parts(self.task.store, &id, &self.truth.frame, &parts, &mut files)?;
                Some(record)
            }
            Err(error) if error.concerns_one_cell() => {
                notes.push(format!("decomposition: {error}"));
                None
            }
            Err(error) => return Err(error),
        };
        let rest = reconstruct::at_rest(self.task, self.view, run.spec, &run.setup, &frame)?;
        let reconstruction = rest.map(|(record, full_s)| {
            self.passes_s += full_s;
            record
        });
        let result = Measured {
            reference: self.task.identity.view(self.matrix),
            cloud_pixel_fraction: comparison.cloud_pixel_fraction,
            fallback_fraction: counts.fallbacks as f64 / counts.look_ups.max(1) as f64,
            memory: run.prepared.memory,
            block,
            time_ms: times(&run.rounds),
            frames_in_flight: run.rounds.iter().map(|r| r.frames).min().unwrap_or(1),
            rounds_total_ms: each_round(&run.rounds, |round| round.total_ms),
            rounds_generate_ms: each_round(&run.rounds, |round| round.times.generate),
            samples: counts.samples,
            look_ups: counts.look_ups,
            error,
            decomposition,
            reconstruction,
            notes,
            files,
        };
        Ok(Cell {
            result: Some(result),
            ..bare_cell(self.task, self.matrix, run.spec)
        })
    }

    /// The parts of a cell's error with their images; `None` where the experiment asks for none.
    fn decompose(&mut self, setup: &MethodSetup, frame: &Frame) -> Result<Option<Parts>> {
        if !self.task.experiment.decompose {
            return Ok(None);
        }
        let truth = &self.truth.frame;
        let decomposer = match &mut self.decomposer {
            Some(made) => made,
            none => none.insert(Decomposer::new(
                &self.matrix.scene,
                self.matrix.image,
                truth,
                self.task.cache,
            )?),
        };
        decomposer.measure(setup, truth, frame).map(Some)
    }

    /// `rel_rmse` of the same cell with an uncompressed map; `None` for a method without a map.
    fn floor(&mut self, setup: &MethodSetup) -> Result<Option<f64>> {
        if setup.method.plan(&setup.params)?.map_values().is_none() {
            return Ok(None);
        }
        let floor = setup.uncompressed()?;
        let key = json!(floor.params).to_string();
        if let Some(known) = self.floors.get(&key) {
            return Ok(Some(*known));
        }
        let prepared = self.task.backend.prepare_full(self.view, &floor)?;
        let times = prepared.run(&mut unwatched)?;
        self.passes_s += times.wall * 1e-3;
        let error = compare(&self.truth.frame, &prepared.picture()?)?
            .error
            .rel_rmse;
        self.floors.insert(key, error);
        Ok(Some(error))
    }
}

fn frame_bytes(image: ImageSize) -> u64 {
    u64::from(image.width) * u64::from(image.height) * 32
}
