//! Runs the experiments of a study one after the other, each resumable in its own folder, and reports progress.

use super::check::check;
use super::claims::{self, Claim};
use super::select::Records;
use super::{EXPERIMENTS, Outcome, conclude};
use crate::backend::Backend;
use crate::batch::{self, lock::Lock, record::Report};
use crate::config::{CellSpec, Experiment, Matrix, MatrixView, Study, Test, expand};
use crate::error::Result;
use crate::occlusion::is_truth;
use crate::reconstruct::Registry;
use crate::scene::Track;
use crate::truth::TruthCache;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Forecast: density samples per view sample of the truth.
const TRUTH_SAMPLES: f64 = 150.0;
/// Forecast: fixed cost of a cell or a truth, as a number of density samples.
const LEAST_SAMPLES: f64 = 3e6;

/// Progress of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudyProgress {
    /// Finished share of the forecast work, 0…1.
    pub share: f64,
    /// Seconds left at the speed of this run so far; `None` before its first finished cell.
    pub eta_s: Option<f64>,
}

/// Event during a study.
#[derive(Clone, Debug)]
pub enum StudyEvent<'a> {
    /// An experiment begins.
    Begins {
        /// Index of the experiment, from 0.
        index: usize,
        /// Number of experiments.
        count: usize,
        /// Title of the experiment.
        title: &'a str,
    },
    /// Event of an experiment's batch.
    Batch(batch::Event, StudyProgress),
    /// The report of the experiment with this id is written.
    Done(&'a str, StudyProgress),
}

/// Callback that receives events; `Break` stops the study, finished cells are kept.
pub type StudyObserver<'a> = &'a mut dyn FnMut(StudyEvent<'_>) -> ControlFlow<()>;

/// Forecast of an experiment's work in density samples: for all its truths together, and for each cell.
struct Forecast {
    truths: f64,
    cells: Vec<f64>,
}

impl Forecast {
    fn new(experiment: &Experiment, matrix: &Matrix) -> Self {
        let frames = f64::from(Track::FRAMES);
        let rounds = f64::from(experiment.runs + experiment.discard + 1);
        let flicker = (frames - 1.0) * experiment.flicker.len() as f64;
        let moving = frames * experiment.ghosting.len() as f64;
        let truth = |view: &MatrixView| {
            (1.0 + flicker) * (view_samples(view) * TRUTH_SAMPLES + LEAST_SAMPLES)
        };
        let cells = matrix.views.iter().flat_map(|view| {
            view.cells.iter().map(move |cell| {
                let whole = cell_samples(view, cell, 1.0);
                let share = 1.0 / f64::from(cell.reconstruct.pattern.one_in());
                let frame = cell_samples(view, cell, share);
                let moved = match cell.reconstruct.history {
                    Some(_) => moving * (whole + frame),
                    None => 0.0,
                };
                rounds * frame + moved + flicker * whole + LEAST_SAMPLES
            })
        });
        Self {
            truths: matrix.views.iter().map(truth).sum(),
            cells: cells.collect(),
        }
    }

    fn total(&self) -> f64 {
        self.truths + self.cells.iter().sum::<f64>()
    }

    /// Density samples of a cell plus an equal share of the truths'.
    fn cell(&self, index: usize) -> f64 {
        let own = self.cells.get(index).copied().unwrap_or(0.0);
        own + self.truths / self.cells.len().max(1) as f64
    }
}

/// Forecast of view samples: pixels × steps × ½, the assumed share of pixels that show cloud.
fn view_samples(view: &MatrixView) -> f64 {
    let pixels = f64::from(view.image.width) * f64::from(view.image.height);
    0.5 * pixels * f64::from(view.scene.march.steps)
}

/// Forecast of density samples of a picture that marches a `share` of its pixels, 0…1.
fn cell_samples(view: &MatrixView, cell: &CellSpec, share: f64) -> f64 {
    let number = |name| cell.params.int(name).map_or(0.0, f64::from);
    let look_ups = share * view_samples(view);
    match number("resolution") {
        _ if is_truth(&cell.method) => look_ups * TRUTH_SAMPLES,
        0.0 => look_ups * number("steps").max(1.0),
        texels => look_ups + texels * texels * number("steps"),
    }
}

/// Measures the cells missing in `folder` and evaluates the study; returns the outcome and the path of the page.
pub fn run(
    study: &Study,
    backend: &Backend,
    folder: &Path,
    cache: Option<&TruthCache>,
    observe: StudyObserver<'_>,
) -> Result<(Outcome, PathBuf)> {
    let entries = study.experiments.iter();
    let matrices = entries.map(|e| expand(&e.experiment, &Registry));
    let matrices = matrices.collect::<Result<Vec<_>>>()?;
    check(study, &matrices)?;
    let entries = study.experiments.iter().zip(&matrices);
    let forecasts: Vec<Forecast> = entries
        .map(|(e, matrix)| Forecast::new(&e.experiment, matrix))
        .collect();
    // Each experiment also locks its own folder; this lock prevents a second run of the study from writing its pages.
    let _lock = Lock::take(folder)?;
    let mut meter = Meter::new(forecasts.iter().map(Forecast::total).sum());
    let mut reports: Vec<(String, Report)> = Vec::new();
    for (index, (entry, forecast)) in study.experiments.iter().zip(&forecasts).enumerate() {
        let count = study.experiments.len();
        let title = entry.title.as_str();
        tell(observe(StudyEvent::Begins {
            index,
            count,
            title,
        }))?;
        let own = folder.join(EXPERIMENTS).join(&entry.id);
        let before = meter.done;
        let mut watch = |event: batch::Event| {
            match &event {
                batch::Event::Planned { cells, done } => {
                    meter.skip(forecast.total() * *done as f64 / (*cells).max(1) as f64);
                }
                batch::Event::Cell(cell) => meter.done += forecast.cell(cell.index),
                _ => {}
            }
            observe(StudyEvent::Batch(event, meter.progress()))
        };
        let report = batch::run(&entry.experiment, backend, &own, cache, &mut watch)?;
        meter.done = before + forecast.total();
        reports.push((entry.id.clone(), report));
        write_report(study, &mut reports, &own)?;
        tell(observe(StudyEvent::Done(&entry.id, meter.progress())))?;
    }
    conclude(study, &reports, folder)
}

fn tell(flow: ControlFlow<()>) -> Result<()> {
    match flow {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(crate::error::Error::Stopped),
    }
}

/// Progress meter: work done, in density samples, and the time it took.
struct Meter {
    total: f64,
    done: f64,
    /// Work done by an earlier run, which does not count for the speed.
    found: f64,
    start: Instant,
}

impl Meter {
    fn new(total: f64) -> Self {
        Self {
            total,
            done: 0.0,
            found: 0.0,
            start: Instant::now(),
        }
    }

    fn skip(&mut self, work: f64) {
        self.done += work;
        self.found += work;
    }

    fn progress(&self) -> StudyProgress {
        let own = self.done - self.found;
        let left = (self.total - self.done).max(0.0);
        StudyProgress {
            share: (self.done / self.total.max(1.0)).min(1.0),
            eta_s: (own > 0.0).then(|| self.start.elapsed().as_secs_f64() * left / own),
        }
    }
}

/// Writes the last report with the verdicts on the claims that need its records and no later ones.
fn write_report(study: &Study, reports: &mut [(String, Report)], folder: &Path) -> Result<()> {
    let Some((id, _)) = reports.last() else {
        return Ok(());
    };
    let known: BTreeSet<&str> = reports.iter().map(|(id, _)| id.as_str()).collect();
    let records = Records {
        reports,
        series: &study.series,
    };
    let concerns = |names: &BTreeSet<&str>| names.contains(id.as_str()) && names.is_subset(&known);
    let claims: Vec<Value> = study
        .claims
        .iter()
        .filter(|spec| concerns(&experiments(spec.checks.iter().map(|c| &c.test))))
        .map(|spec| summary(&claims::decide(&records, spec)))
        .collect();
    if let Some((_, report)) = reports.last_mut() {
        report.claims = claims;
        crate::report::write(folder, report)?;
    }
    Ok(())
}

/// A claim as an entry of `report.json`.
fn summary(claim: &Claim) -> Value {
    let numbers: Vec<&str> = claim
        .parts
        .iter()
        .map(|part| part.finding.numbers.as_str())
        .collect();
    json!({
        "claim": claim.id,
        "published": claim.place,
        "says": claim.says,
        "verdict": claim.verdict.words(),
        "numbers": numbers.join(" | "),
        "because": claim.because,
    })
}

/// Experiments that tests take cells from.
fn experiments<'a>(tests: impl Iterator<Item = &'a Test>) -> BTreeSet<&'a str> {
    let mut names = BTreeSet::new();
    for test in tests {
        match test {
            Test::Range { of, .. } => names.extend(quantity(of)),
            Test::Ratio { of, to, .. } => names.extend(quantity(of).chain(quantity(to))),
            Test::Order { ascending, .. } => {
                names.extend(ascending.iter().flatten().map(|p| p.experiment.as_str()));
            }
            Test::Straight { of, .. } | Test::Gain { of, .. } => {
                names.insert(of.experiment.as_str());
            }
            Test::Crossover { of, over, .. } => {
                names.extend([of.experiment.as_str(), over.experiment.as_str()]);
            }
            Test::Unmeasured { .. } => {}
        }
    }
    names
}

fn quantity(quantity: &crate::config::Quantity) -> impl Iterator<Item = &str> {
    let picks = [Some(&quantity.of), quantity.minus.as_ref()]
        .into_iter()
        .flatten();
    picks.map(|pick| pick.experiment.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::load_study;

    /// Forecasts of an experiment of the shipped study.
    fn forecast(profile: &str, id: &str, edit: impl FnOnce(&mut Experiment)) -> Forecast {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/studies/m.json");
        let mut study = load_study(&path, profile).unwrap();
        let found = study.experiments.iter_mut().find(|e| e.id == id).unwrap();
        edit(&mut found.experiment);
        let matrix = expand(&found.experiment, &Registry).unwrap();
        Forecast::new(&found.experiment, &matrix)
    }

    #[test]
    fn the_forecast_knows_what_costs_time() {
        let plain = forecast("quick", "screens", |_| ());
        let temporal = forecast("quick", "screens", |e| {
            e.reconstruct = vec![(String::new(), json!("temporal_2x2"))];
        });
        let (srm, quarter) = (
            plain.cell(0) - LEAST_SAMPLES,
            temporal.cell(0) - LEAST_SAMPLES,
        );
        let truths = plain.truths / plain.cells.len() as f64;
        let ratio = (quarter - truths) / (srm - truths);
        assert!((ratio - 0.25).abs() < 1e-9, "{ratio}");
        let still = forecast("quick", "temporal", |e| e.ghosting.clear());
        assert!(forecast("quick", "temporal", |_| ()).total() > 2.0 * still.total());
        let still = forecast("quick", "flicker", |e| e.flicker.clear());
        assert!(forecast("quick", "flicker", |_| ()).total() > 5.0 * still.total());
        assert!(
            forecast("full", "map", |_| ()).total()
                > 10.0 * forecast("quick", "map", |_| ()).total()
        );
    }

    #[test]
    fn what_an_earlier_run_did_says_nothing_of_the_time_to_go() {
        let mut meter = Meter::new(100.0);
        meter.skip(60.0);
        assert_eq!(meter.progress().eta_s, None);
        meter.done += 20.0;
        std::thread::sleep(std::time::Duration::from_millis(20));
        let progress = meter.progress();
        let elapsed_s = meter.start.elapsed().as_secs_f64();
        let eta_s = progress.eta_s.unwrap();
        assert!(
            eta_s > 0.0 && eta_s <= elapsed_s,
            "20 of 20 to go: as long again"
        );
        assert!((progress.share - 0.8).abs() < 1e-12);
    }
}
