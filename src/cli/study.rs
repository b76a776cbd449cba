//! `occlab study`.

use super::progress::bar;
use super::{DeviceArgs, print_path, say};
use indicatif::ProgressBar;
use occlab::batch::{self, report_folder};
use occlab::config::shipped::{self, FileKind, find};
use occlab::config::{load_study, study_profiles};
use occlab::study::{Outcome, StudyEvent, StudyProgress, run};
use occlab::truth::TruthCache;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Steps of the progress bar.
const STEPS: f64 = 1000.0;

#[derive(clap::Args)]
pub struct StudyArgs {
    /// Name of a study, or the path of a study file; without it the studies are listed.
    name: Option<PathBuf>,
    /// Profile of the study: its sizes and counts. `quick` takes minutes, `full` may take hours.
    #[arg(long, default_value = "quick")]
    profile: String,
    /// Output folder; default: reports/study-NAME-PROFILE.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Render truths anew instead of taking them from the cache (see `occlab cache`).
    #[arg(long)]
    no_cache: bool,
    #[command(flatten)]
    device: DeviceArgs,
}

impl StudyArgs {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let Some(name) = &self.name else {
            return list();
        };
        let study = load_study(&find(FileKind::Study, name)?, &self.profile)?;
        let named = format!("study-{}-{}", study.name, study.profile);
        let folder = self
            .out
            .unwrap_or_else(|| report_folder(Path::new("reports"), &named));
        let backend = self.device.open()?;
        let cache = match self.no_cache {
            true => None,
            false => TruthCache::from_environment()?,
        };
        let quiet = self.device.quiet;
        let progress = bar(STEPS as u64, quiet);
        let mut resumed = false;
        let (outcome, page) = run(&study, &backend, &folder, cache.as_ref(), &mut |event| {
            show(&progress, quiet, &mut resumed, event);
            ControlFlow::Continue(())
        })?;
        progress.finish_and_clear();
        if !quiet {
            summarise(&outcome);
        }
        print_path(&page)?;
        Ok(if outcome.failed > 0 {
            ExitCode::from(1)
        } else {
            ExitCode::SUCCESS
        })
    }
}

/// Names, profiles and titles of the studies in `configs/studies` and of the built-in ones.
fn list() -> anyhow::Result<ExitCode> {
    for path in shipped::list(FileKind::Study) {
        let name = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        match study_profiles(&path) {
            Ok((title, profiles)) => {
                say(format!("{name:<12} {:<14} {title}", profiles.join(", ")))?;
            }
            Err(error) => say(format!("{name:<12} cannot be read: {error}"))?,
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn show(bar: &ProgressBar, quiet: bool, resumed: &mut bool, event: StudyEvent<'_>) {
    // A bar prints nothing where stderr is no terminal, but a log should have these lines too.
    let line = |text: String| {
        if !quiet {
            bar.suspend(|| eprintln!("{text}"));
        }
    };
    let place = |progress: StudyProgress| bar.set_position((progress.share * STEPS) as u64);
    match event {
        StudyEvent::Begins {
            index,
            count,
            title,
        } => {
            line(format!("experiment {}/{count}: {title}", index + 1));
        }
        StudyEvent::Done(id, progress) => {
            place(progress);
            line(format!("  `{id}` done, {}", far(progress)));
        }
        StudyEvent::Batch(event, progress) => {
            place(progress);
            match event {
                batch::Event::Planned { cells, done } => {
                    if done > 0 {
                        line(format!("  {done} of {cells} cells were recorded before"));
                    }
                    if !*resumed {
                        bar.reset_eta();
                    }
                    *resumed = true;
                }
                batch::Event::Note(note) => line(format!("  note: {note}")),
                batch::Event::Stage { what, share } => {
                    bar.set_message(format!("{what} {:.0} %, {}", share * 100.0, far(progress)));
                }
                batch::Event::Cell(cell) => {
                    if let Some(reason) = &cell.failed {
                        line(format!(
                            "  failed: {} {:?}: {reason}",
                            cell.method, cell.params
                        ));
                    }
                }
            }
        }
    }
}

/// Share and time to go.
fn far(progress: StudyProgress) -> String {
    let share = format!("{:.0} % of the study", progress.share * 100.0);
    match progress.eta_s {
        Some(s) if s >= 5400.0 => format!("{share}, about {:.1} h to go", s / 3600.0),
        Some(s) if s >= 90.0 => format!("{share}, about {:.0} min to go", s / 60.0),
        Some(s) => format!("{share}, about {s:.0} s to go"),
        None => share,
    }
}

/// The verdicts on stderr: the page has the rest.
fn summarise(outcome: &Outcome) {
    eprintln!("adapter: {}", outcome.adapter);
    for claim in &outcome.claims {
        let verdict = claim.verdict.words();
        eprintln!("{:<4} {verdict:<18} {}", claim.id, claim.because);
    }
    for shown in &outcome.errata {
        eprintln!("erratum {}: {}", shown.place, shown.numbers);
    }
    if let Some(model) = &outcome.cost_model {
        eprintln!(
            "one price: {:.1} ns a sample, R² {:.3}",
            model.one_price_ns, model.one_price_r2
        );
    }
    eprintln!(
        "{} cells, {} failed, {:.1} s",
        outcome.cells, outcome.failed, outcome.wall_s
    );
}
