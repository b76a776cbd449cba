//! One view of the matrix: its truth, then all its cells in interleaved rounds.
//!
//! Rounds go over all cells before the next begins, so that a drift of the machine's speed meets every method alike and
//! ratios can be taken inside a round. Nothing but passes runs between the first timed round and the last: pictures are
//! read in the first discarded round, counted, compared and written after the last.

use super::cell::{bare_cell, cell_id, record_failure, times, view_id};
use super::record::{Cell, Measured, Reference};
use super::store::Store;
use super::{Event, Observer, tell, view_name};
use crate::config::{CellSpec, Experiment, View as MatrixView};
use crate::error::{Error, Result};
use crate::frame::{Exposure, Frame, false_colour, tone_map, write_frame, write_png};
use crate::metrics::{ErrorNumbers, compare, delta_luminance, mean_sun};
use crate::occlusion::{MAP_PARAMS, MethodSetup, find};
use crate::raymarch::reference::{Truth, truth};
use crate::raymarch::{PassTimes, Prepared, Renderer, View};
use crate::scene::ImageSize;
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::Path;

/// Maps and pictures held at once, bytes; a view with more cells is measured in several blocks.
const BLOCK_BYTES: u64 = 2 << 30;
/// ΔL / mean L that gets the end colours of a difference picture: one scale everywhere.
const DIFF_SCALE: f32 = 1.0;

/// A cell being measured.
struct Run<'a> {
    spec: &'a CellSpec,
    setup: MethodSetup,
    prepared: Prepared,
    frame: Option<Frame>,
    times: Vec<PassTimes>,
}

/// State of one view.
struct Bench<'a> {
    experiment: &'a Experiment,
    renderer: &'a Renderer,
    matrix: &'a MatrixView,
    view: View,
    truth: Truth,
    store: &'a Store,
    /// `rel_rmse` of the uncompressed column by the map parameters it shares with a cell.
    floors: HashMap<String, f64>,
    passes_s: f64,
}

/// Measures the cells that are not recorded yet; returns the seconds spent in passes.
pub(super) fn run_view(
    experiment: &Experiment,
    renderer: &Renderer,
    matrix: &MatrixView,
    store: &Store,
    cache: Option<&Path>,
    observe: Observer,
) -> Result<f64> {
    let missing: Vec<_> = matrix
        .cells
        .iter()
        .filter(|spec| !store.has(&cell_id(matrix, spec)))
        .collect();
    if missing.is_empty() {
        return Ok(0.0);
    }
    let mut bench = match Bench::new(experiment, renderer, matrix, store, cache, observe) {
        Ok(bench) => bench,
        // The scene itself cannot be rendered here: every cell says so, the other scenes go on.
        Err(error @ Error::Gpu { .. }) => {
            for spec in missing {
                record_failure(matrix, renderer, store, spec, &error, observe)?;
            }
            return Ok(0.0);
        }
        Err(error) => return Err(error),
    };
    let mut rest = &missing[..];
    while !rest.is_empty() {
        rest = bench.block(rest, observe)?;
    }
    Ok(bench.passes_s)
}

impl<'a> Bench<'a> {
    fn new(
        experiment: &'a Experiment,
        renderer: &'a Renderer,
        matrix: &'a MatrixView,
        store: &'a Store,
        cache: Option<&Path>,
        observe: Observer,
    ) -> Result<Self> {
        let name = view_name(matrix);
        stage(observe, &name, "scene", 0.0)?;
        let (start, compiled_s) = (std::time::Instant::now(), renderer.gpu.compile_s());
        let view = renderer.view(&matrix.scene, matrix.image)?;
        let scene_s = start.elapsed().as_secs_f64() - (renderer.gpu.compile_s() - compiled_s);
        let what = format!("{name}: truth");
        let truth = truth(renderer, &view, cache, &mut |share| {
            observe(Event::Stage {
                what: what.clone(),
                share,
            })
        })?;
        let truth_s = if truth.cached {
            0.0
        } else {
            2.0 * truth.cost.wall_ms * 1e-3
        };
        let bench = Self {
            experiment,
            renderer,
            matrix,
            view,
            truth,
            store,
            floors: HashMap::new(),
            passes_s: scene_s + truth_s,
        };
        bench.record_truth()?;
        Ok(bench)
    }

    fn record_truth(&self) -> Result<()> {
        let id = view_id(self.matrix);
        let (exr, png) = (
            format!("images/truth-{id}.exr"),
            format!("images/truth-{id}.png"),
        );
        let frame = &self.truth.frame;
        write_frame(&self.store.path(&exr), frame)?;
        write_png(
            &self.store.path(&png),
            frame.width,
            frame.height,
            &tone_map(frame, Exposure::from_reference(frame)),
        )?;
        let cost = &self.truth.cost;
        let reference = Reference {
            id: id.clone(),
            scene: self.matrix.scene.name.clone(),
            sun_elevation_deg: self.matrix.scene.sun.elevation_deg,
            image: self.matrix.image,
            march_ms: cost.march_ms,
            light_samples: Some(cost.samples.light),
            view_samples: Some(cost.samples.view),
            cached: self.truth.cached,
            files: files([("exr", exr.into()), ("png", png.into())]),
        };
        self.store.put_reference(&id, &reference)
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
                    bytes += run.prepared.memory.map_bytes + frame_bytes(self.matrix.image);
                    runs.push(run);
                }
                Err(error) => record_failure(
                    self.matrix,
                    self.renderer,
                    self.store,
                    spec,
                    &error,
                    observe,
                )?,
            }
        }
        self.rounds(&mut runs, observe)?;
        for run in runs {
            let spec = run.spec;
            match self.measure(run) {
                Ok(cell) => {
                    self.store.put_cell(&cell)?;
                    tell(observe, Event::Cell(Box::new(cell)))?;
                }
                Err(error @ (Error::Gpu { .. } | Error::Input { .. } | Error::Shader { .. })) => {
                    record_failure(
                        self.matrix,
                        self.renderer,
                        self.store,
                        spec,
                        &error,
                        observe,
                    )?;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(&specs[taken..])
    }

    fn prepare(&self, spec: &'a CellSpec) -> Result<Run<'a>> {
        let setup = MethodSetup {
            method: find(&spec.method)?,
            params: spec.params.clone(),
        };
        let prepared = self.renderer.prepare(&self.view, &setup)?;
        Ok(Run {
            spec,
            setup,
            prepared,
            frame: None,
            times: Vec::new(),
        })
    }

    fn rounds(&mut self, runs: &mut [Run], observe: Observer) -> Result<()> {
        let name = view_name(self.matrix);
        let rounds = self.experiment.discard.max(1) + self.experiment.runs;
        let total = f64::from(rounds) * runs.len().max(1) as f64;
        for round in 0..rounds {
            for (i, run) in runs.iter_mut().enumerate() {
                let share = (f64::from(round) * total / f64::from(rounds) + i as f64) / total;
                stage(
                    observe,
                    &name,
                    &format!("round {}/{rounds}", round + 1),
                    share,
                )?;
                let times = run
                    .prepared
                    .run(&self.renderer.gpu, &mut |_| ControlFlow::Continue(()))?;
                self.passes_s += times.wall * 1e-3;
                if round == 0 {
                    run.frame = Some(self.view.read(&self.renderer.gpu)?);
                }
                if round >= self.experiment.discard.max(1) {
                    run.times.push(times);
                }
            }
        }
        Ok(())
    }

    fn measure(&mut self, run: Run) -> Result<Cell> {
        let frame = run
            .frame
            .ok_or_else(|| Error::gpu("the cell was never rendered", "Run the batch again."))?;
        let comparison = compare(&self.truth.frame, &frame)?;
        let counting = self.renderer.prepare_counting(&self.view, &run.setup)?;
        let counted = counting.run(&self.renderer.gpu, &mut |_| ControlFlow::Continue(()))?;
        self.passes_s += counted.wall * 1e-3;
        let counts = counting.counts(&self.renderer.gpu)?;
        let error = ErrorNumbers {
            floor_rel_rmse: self.floor(&run.setup)?,
            ..comparison.error
        };
        let result = Measured {
            reference: view_id(self.matrix),
            cloud_pixel_fraction: comparison.cloud_pixel_fraction,
            fallback_fraction: counts.fallbacks as f64 / counts.look_ups.max(1) as f64,
            memory: run.prepared.memory,
            time_ms: times(&run.times),
            rounds_total_ms: run.times.iter().filter_map(PassTimes::total).collect(),
            samples: counts.samples,
            error,
            files: self.write_pictures(&cell_id(self.matrix, run.spec), &frame)?,
        };
        Ok(Cell {
            result: Some(result),
            ..bare_cell(self.matrix, self.renderer, run.spec)
        })
    }

    /// The same cell with nothing compressed, or `None` for a method without a map.
    fn floor(&mut self, setup: &MethodSetup) -> Result<Option<f64>> {
        if setup.method.plan(&setup.params)?.map_values.is_none() {
            return Ok(None);
        }
        let mut floor = MethodSetup::defaults("floor")?;
        for spec in MAP_PARAMS {
            if let Some(value) = setup.params.get(spec.name) {
                floor.params.set(spec.name, value);
            }
        }
        let key = json!(floor.params).to_string();
        if let Some(known) = self.floors.get(&key) {
            return Ok(Some(*known));
        }
        let prepared = self.renderer.prepare(&self.view, &floor)?;
        let times = prepared.run(&self.renderer.gpu, &mut |_| ControlFlow::Continue(()))?;
        self.passes_s += times.wall * 1e-3;
        let error = compare(&self.truth.frame, &self.view.read(&self.renderer.gpu)?)?
            .error
            .rel_rmse;
        self.floors.insert(key, error);
        Ok(Some(error))
    }

    fn write_pictures(&self, id: &str, frame: &Frame) -> Result<Map<String, Value>> {
        let path = |suffix: &str| format!("images/{id}{suffix}");
        let (exr, png, diff) = (path(".exr"), path(".png"), path("-diff.png"));
        let exposure = Exposure::from_reference(&self.truth.frame);
        write_frame(&self.store.path(&exr), frame)?;
        write_png(
            &self.store.path(&png),
            frame.width,
            frame.height,
            &tone_map(frame, exposure),
        )?;
        let delta = delta_luminance(&self.truth.frame, frame)?;
        let scale = DIFF_SCALE * mean_sun(&self.truth.frame)? as f32;
        write_png(
            &self.store.path(&diff),
            frame.width,
            frame.height,
            &false_colour(frame.width, frame.height, &delta, scale),
        )?;
        Ok(files([
            ("exr", exr.into()),
            ("png", png.into()),
            ("diff_png", diff.into()),
            ("diff_scale", DIFF_SCALE.into()),
        ]))
    }
}

fn files<const N: usize>(entries: [(&str, Value); N]) -> Map<String, Value> {
    entries
        .into_iter()
        .map(|(k, v)| (k.to_owned(), v))
        .collect()
}

fn frame_bytes(image: ImageSize) -> u64 {
    u64::from(image.width) * u64::from(image.height) * 32
}

fn stage(observe: Observer, view: &str, what: &str, share: f64) -> Result<()> {
    tell(
        observe,
        Event::Stage {
            what: format!("{view}: {what}"),
            share,
        },
    )
}
