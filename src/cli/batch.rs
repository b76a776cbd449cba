//! `occlab batch` and `occlab report`.

use super::progress::bar;
use super::{Device, print_path, say};
use occlab::batch::record::{Cell, Report};
use occlab::batch::{Event, report_folder, run};
use occlab::config::{describe, expand, load_experiment};
use occlab::gpu::Gpu;
use occlab::occlusion::Registry;
use occlab::raymarch::Renderer;
use occlab::raymarch::reference::cache_folder;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct Batch {
    /// Experiment file; any value in it may be a list, lists multiply into the matrix.
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
        let experiment = load_experiment(&self.config)?;
        if self.dry_run {
            say(describe(&expand(&experiment, &Registry)?).trim_end())?;
            return Ok(ExitCode::SUCCESS);
        }
        let folder = self
            .out
            .unwrap_or_else(|| report_folder(&PathBuf::from("reports"), &experiment.name));
        let renderer = Renderer::new(Gpu::new(self.device.adapter.as_deref())?);
        let cache = if self.no_cache { None } else { cache_folder() };
        let quiet = self.device.quiet;
        if !quiet {
            eprintln!(
                "adapter: {} ({:?})",
                renderer.gpu.info.name, renderer.gpu.info.device_type
            );
        }
        let progress = bar(0, quiet);
        let report = run(
            &experiment,
            &renderer,
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
    eprintln!(
        "{:<16} {:>4} {:<6} {:>9} {:>8} {:>8} {:>9} {:>10}  setting",
        "scene", "sun", "method", "rel_rmse", "leak", "darken", "total ms", "map bytes"
    );
    for cell in &report.cells {
        eprintln!("{}", row(cell));
    }
    for truth in &report.references {
        let samples = truth
            .light_samples
            .zip(truth.view_samples)
            .map(|(l, v)| (l + v) as f64);
        let rate = samples.zip(truth.march_ms).map_or("n/a".into(), |(n, ms)| {
            format!("{:.1} M samples/s", n / ms * 1e-3)
        });
        let ms = truth
            .march_ms
            .map_or("n/a".into(), |ms| format!("{ms:.0} ms"));
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

fn row(cell: &Cell) -> String {
    let setting: Vec<_> = cell
        .params
        .iter()
        .map(|(k, v)| format!("{k}={}", v.as_str().map_or(v.to_string(), str::to_owned)))
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
            r.time_ms
                .total
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
