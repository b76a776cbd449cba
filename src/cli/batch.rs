//! `occlab batch` and `occlab report`.

use super::progress::bar;
use super::{Device, print_path, say};
use occlab::batch::record::{Cell, Clock, Report};
use occlab::batch::{Event, report_folder, run};
use occlab::config::shipped::{Kind, find};
use occlab::config::{describe, expand, load_experiment};
use occlab::occlusion::Registry;
use occlab::raymarch::reference::cache_folder;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct Batch {
    /// Experiment file, or its name; any value in it may be a list, lists multiply into the matrix.
    config: PathBuf,
    /// Report folder; default: reports/NAME of the experiment.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the matrix and stop.
    #[arg(long)]
    dry_run: bool,
    /// Render truths anew instead of taking them from the cache (OCCLAB_CACHE, or the user's cache folder).
    #[arg(long)]
    no_cache: bool,
    #[command(flatten)]
    device: Device,
}

impl Batch {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let experiment = load_experiment(&find(Kind::Experiment, &self.config)?)?;
        if self.dry_run {
            say(describe(&expand(&experiment, &Registry)?).trim_end())?;
            return Ok(ExitCode::SUCCESS);
        }
        let folder = self
            .out
            .unwrap_or_else(|| report_folder(&PathBuf::from("reports"), &experiment.name));
        let backend = self.device.open()?;
        let cache = if self.no_cache { None } else { cache_folder() };
        let quiet = self.device.quiet;
        let progress = bar(0, quiet);
        let report = run(
            &experiment,
            &backend,
            &folder,
            cache.as_deref(),
            &mut |event| {
                show(&progress, quiet, event);
                ControlFlow::Continue(())
            },
        )?;
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
}

fn row(cell: &Cell, clock: Clock) -> String {
    let setting: Vec<_> = cell
        .params
        .iter()
        .map(|(k, v)| format!("{k}={}", v.as_str().map_or(v.to_string(), str::to_owned)))
        .chain((!cell.reconstruct.is_full()).then(|| cell.reconstruct.name().to_owned()))
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
