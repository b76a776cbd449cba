//! `occlab stability`.

use super::progress::bar;
use super::{DeviceArgs, print_path};
use occlab::config::load_stability;
use occlab::config::shipped::{FileKind, find};
use occlab::gpu::Gpu;
use occlab::occlusion::Methods;
use occlab::raymarch::Renderer;
use occlab::stability::{FormVerdict, Profile, SearchResult, Sweep, SweepEvent, run};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct StabilityArgs {
    /// Stability file: small scenes and the extremes they are pushed to.
    #[arg(default_value = "configs/stability.json")]
    config: PathBuf,
    /// Output folder; default: reports/stability.
    #[arg(long, value_name = "DIR", default_value = "reports/stability")]
    out: PathBuf,
    /// quick: a few minutes; full: everything, the largest maps too.
    #[arg(long, value_enum, default_value = "quick")]
    profile: ProfileName,
    #[command(flatten)]
    device: DeviceArgs,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ProfileName {
    Quick,
    Full,
}

impl StabilityArgs {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let stability = load_stability(
            &find(FileKind::Stability, &self.config)?,
            &self.out,
            &Methods,
        )?;
        let quiet = self.device.quiet;
        let wanted = self.device.adapter.as_deref();
        let renderer = match Gpu::new(wanted) {
            Ok(gpu) => Some(Renderer::new(gpu)),
            Err(error) if wanted.is_some() => return Err(error.into()),
            Err(error) => {
                if !quiet {
                    eprintln!("note: the oracle runs alone: {error}");
                }
                None
            }
        };
        let profile = match self.profile {
            ProfileName::Quick => Profile::Quick,
            ProfileName::Full => Profile::Full,
        };
        let progress = bar(0, quiet);
        let sweep = run(
            &stability,
            profile,
            renderer.as_ref(),
            &self.out,
            &mut |event| {
                match event {
                    SweepEvent::Planned { cases, done } => {
                        progress.set_length(cases as u64);
                        progress.set_position(done as u64);
                    }
                    SweepEvent::Begins(what) => progress.set_message(what),
                    SweepEvent::Case(_) => progress.inc(1),
                }
                ControlFlow::Continue(())
            },
        )?;
        progress.finish_and_clear();
        let page = occlab::report::write_stability(&self.out, &sweep)?;
        if !quiet {
            summarise(&sweep);
        }
        print_path(&page)?;
        Ok(if sweep.defects().is_empty() {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(1)
        })
    }
}

/// Thresholds, counts and defects on stderr: the page has the rest.
fn summarise(sweep: &Sweep) {
    let shown = |value: Option<f64>| value.map_or("never".to_owned(), |v| format!("{v:.6}"));
    eprintln!(
        "{:<14} {:<50} {:<7} {:<7} {:<6} {:>12} {:>12} {:>12}",
        "form", "what happens", "at", "storage", "flush", "predicted", "oracle", "device"
    );
    for t in &sweep.thresholds {
        let device = match &t.device {
            Some(SearchResult::At(value)) => format!("{value:.3}"),
            Some(SearchResult::NotUpTo(limit)) => format!("> {limit}"),
            Some(SearchResult::Failed(_)) => "failed".to_owned(),
            None => "-".to_owned(),
        };
        let flush = t
            .flush
            .map_or("-", |flush| if flush { "yes" } else { "no" });
        eprintln!(
            "{:<14} {:<50} {:<7} {:<7} {flush:<6} {:>12} {:>12} {device:>12}",
            t.form,
            t.what,
            t.parameter,
            t.storage,
            digits(t.predicted, &shown),
            digits(t.measured, &shown)
        );
    }
    for form in ["stable", "published", "-"] {
        let count = |verdict| sweep.count(form, verdict);
        eprintln!(
            "oracle, form {form}: {} ok, {} ring, {} break, {} refused",
            count(FormVerdict::Ok),
            count(FormVerdict::Rings),
            count(FormVerdict::Breaks),
            count(FormVerdict::Refused)
        );
    }
    for (case, row) in sweep.defects() {
        let reason = row
            .oracle()
            .reason
            .as_deref()
            .unwrap_or("on the device alone");
        let device = row.device.as_ref().and_then(|d| d.reason.as_deref());
        eprintln!(
            "DEFECT: {} {}: {:?}: {reason}; device: {}",
            case.group,
            case.name,
            row.setting,
            device.unwrap_or("ok")
        );
    }
    eprintln!("{} cases, {:.1} s", sweep.cases.len(), sweep.wall_s);
}

/// Numbers near 0 are written as powers of ten.
fn digits(value: Option<f64>, plain: &dyn Fn(Option<f64>) -> String) -> String {
    match value {
        Some(v) if v != 0.0 && v.abs() < 1e-3 => format!("{v:.4e}"),
        other => plain(other),
    }
}
