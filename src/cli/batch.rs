//! `occlab batch` and `occlab report`.

use super::progress::bar;
use super::{DeviceArgs, print_path, say};
use occlab::batch::record::{Cell, Clock, Report};
use occlab::batch::{BatchPlan, Event, measure, report_file, report_folder};
use occlab::config::shipped::{FileKind, find};
use occlab::config::{describe, load_experiment};
use occlab::error::Error;
use occlab::truth::TruthCache;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct BatchArgs {
    /// Experiment file, or its name; any value in it may be a list, lists multiply into the matrix. Or a report, by its
    /// folder or its report.json: its cells are measured again, from the scenes and parameters that it holds.
    config: PathBuf,
    /// Report folder; default: reports/NAME of the experiment. Needed for a report: a folder other than its own.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the matrix and stop.
    #[arg(long)]
    dry_run: bool,
    /// Render truths anew instead of taking them from the cache (see `occlab cache`).
    #[arg(long)]
    no_cache: bool,
    #[command(flatten)]
    device: DeviceArgs,
}

impl BatchArgs {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let report = report_file(&self.config);
        let plan = match &report {
            Some(report) => BatchPlan::of_report(report)?,
            None => BatchPlan::new(load_experiment(&find(FileKind::Experiment, &self.config)?)?)?,
        };
        if self.dry_run {
            say(describe(plan.matrix()).trim_end())?;
            return Ok(ExitCode::SUCCESS);
        }
        let folder = match report {
            Some(report) => another_folder(&report, self.out)?,
            None => self
                .out
                .unwrap_or_else(|| report_folder(&PathBuf::from("reports"), plan.name())),
        };
        let backend = self.device.open()?;
        let cache = match self.no_cache {
            true => None,
            false => TruthCache::from_environment()?,
        };
        let quiet = self.device.quiet;
        let progress = bar(0, quiet);
        let report = measure(&plan, &backend, &folder, cache.as_ref(), &mut |event| {
            show(&progress, quiet, event);
            ControlFlow::Continue(())
        })?;
        progress.finish_and_clear();
        let page = occlab::report::write(&folder, &report)?;
        if !quiet {
            summarise(&report);
        }
        print_path(&page)?;
        let failed = report.cells.iter().filter(|c| c.failed.is_some()).count();
        Ok(if failed > 0 {
            ExitCode::from(1)
        } else {
            ExitCode::SUCCESS
        })
    }
}

/// The folder for a report that is measured again: one that does not hold the old records.
fn another_folder(report: &Path, out: Option<PathBuf>) -> Result<PathBuf, Error> {
    let real = |path: &Path| path.canonicalize().ok();
    let parent = report.parent().filter(|p| !p.as_os_str().is_empty());
    let own = real(parent.unwrap_or(Path::new(".")));
    match out {
        Some(out) if own.is_none() || real(&out) != own => Ok(out),
        _ => Err(Error::input(
            report.display().to_string(),
            "a report is measured again into a folder of its own",
            "Name a new one with --out.",
        )),
    }
}

fn show(progress: &indicatif::ProgressBar, quiet: bool, event: Event) {
    // A bar prints nothing where stderr is no terminal, but a log should have these lines too.
    let line = |text: String| {
        if !quiet {
            progress.suspend(|| eprintln!("{text}"));
        }
    };
    match event {
        Event::Planned { cells, done } => {
            progress.set_length(cells as u64);
            progress.set_position(done as u64);
        }
        Event::Note(note) => line(format!("note: {note}")),
        Event::Stage { what, share } => {
            progress.set_message(format!("{what} {:.0} %", share * 100.0))
        }
        Event::Cell(cell) => {
            progress.inc(1);
            if let Some(reason) = &cell.failed {
                line(format!(
                    "failed: {} {} {:?}: {reason}",
                    cell.scene, cell.method, cell.params
                ));
            }
        }
    }
}

/// The table on stderr: the page has the rest.
fn summarise(report: &Report) {
    let clock = report.clock();
    eprintln!(
        "{:<16} {:>4} {:<6} {:>9} {:>8} {:>8} {:>9} {:>10}  setting",
        "scene",
        "sun",
        "method",
        "rel_rmse",
        "leak",
        "darken",
        format!("{} ms", clock.name()),
        "map bytes"
    );
    for cell in &report.cells {
        eprintln!("{}", row(cell, clock));
    }
    for truth in &report.references {
        let samples = truth
            .light_samples
            .zip(truth.view_samples)
            .map(|(l, v)| (l + v) as f64);
        let (what, time_ms) = match truth.march_ms {
            Some(ms) => ("", Some(ms)),
            None => ("wall ", truth.wall_ms),
        };
        let rate = samples.zip(time_ms).map_or("n/a".into(), |(n, ms)| {
            format!("{:.1} M samples/s", n / ms * 1e-3)
        });
        let ms = time_ms.map_or("n/a".into(), |ms| format!("{what}{ms:.0} ms"));
        eprintln!(
            "{:<16} {:>3}° truth: {ms}, {rate}{}",
            truth.scene,
            truth.sun_elevation_deg,
            if truth.cached { ", cached" } else { "" }
        );
    }
    let wall = &report.wall;
    eprintln!(
        "wall {:.1} s = {:.2} × passes ({:.1} s) + compilation {:.1} s",
        wall.total_s,
        (wall.total_s - wall.compile_s) / wall.passes_s.max(1e-9),
        wall.passes_s,
        wall.compile_s
    );
    if let Some([least, most]) = report.clock_drift() {
        let unsettled = report.clock.iter().filter(|block| !block.settled).count();
        eprintln!(
            "clock probe: changed by {:+.1} … {:+.1} % over the rounds; not settled before {unsettled} of {} blocks",
            least * 100.0,
            most * 100.0,
            report.clock.len()
        );
    }
}

fn row(cell: &Cell, clock: Clock) -> String {
    let setting: Vec<_> = cell
        .params
        .iter()
        .map(|(k, v)| format!("{k}={}", v.as_str().map_or(v.to_string(), str::to_owned)))
        .chain((!cell.reconstruct.is_full()).then(|| cell.reconstruct.id.to_owned()))
        .collect();
    let start = format!(
        "{:<16} {:>3}° {:<6}",
        cell.scene, cell.sun_elevation_deg, cell.method
    );
    match &cell.result {
        None => format!("{start} FAILED  {}", setting.join(" ")),
        Some(r) => format!(
            "{start} {:>9.4} {:>8.4} {:>8.4} {:>9} {:>10}  {}",
            r.error.rel_rmse,
            r.error.leak,
            r.error.darken,
            clock
                .cost(&r.time_ms)
                .map_or("n/a".into(), |t| format!("{:.1}", t.median)),
            r.memory.map_bytes,
            setting.join(" ")
        ),
    }
}

#[derive(clap::Args)]
pub struct Rebuild {
    /// Folder that holds report.json.
    folder: PathBuf,
}

impl Rebuild {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let report = Report::read(&self.folder.join("report.json"))?;
        print_path(&occlab::report::write(&self.folder, &report)?)?;
        Ok(ExitCode::SUCCESS)
    }
}
