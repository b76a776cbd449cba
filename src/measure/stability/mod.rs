//! Stability sweep: every method, form, storage and look-up at extremes of the number formats.
//!
//! ```text
//! stability.json ─► cases ─► oracle: T along light columns, f16/f32 and flushing emulated ─► verdict, asserted
//!                     └────► device: a small picture, its stored bits read back ──────────► recorded beside it
//! ```
//!
//! WGSL may assume that no value is NaN or infinite, and min and clamp are free to return anything for them: what a
//! device shows is recorded, not asserted. [`run`] writes one record a case; `report::write_stability` makes
//! the page.

mod cases;
mod columns;
mod pictures;
mod record;
mod sweep;
mod thresholds;

pub use cases::settings;
pub use record::{Columns, FormVerdict, SCHEMA, Setting, Sweep, SweepCase, SweepPicture, SweepRow};
pub use thresholds::{SEARCHED, SearchResult, Threshold, thresholds};

use crate::config::Stability;
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::raymarch::Renderer;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// How much of a stability file is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// Without the cases that are marked `full_only`.
    Quick,
    /// Everything.
    Full,
}

impl Profile {
    /// Name on the command line and on the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
        }
    }
}

/// An event of a sweep.
#[derive(Debug)]
pub enum SweepEvent<'a> {
    /// The cases are known; `done` of them were recorded by an earlier run and are not repeated.
    Planned {
        /// Cases of the profile.
        cases: usize,
        /// Cases recorded before.
        done: usize,
    },
    /// A stage begins; a short description.
    Begins(String),
    /// A case was recorded.
    Case(&'a SweepCase),
}

/// Receives events; `Break` stops the sweep, recorded cases are kept.
pub type SweepObserver<'a> = &'a mut dyn FnMut(SweepEvent<'_>) -> ControlFlow<()>;

/// Measures the missing cases of a sweep in `folder`; without a renderer on the oracle alone.
pub fn run(
    stability: &Stability,
    profile: Profile,
    renderer: Option<&Renderer>,
    folder: &Path,
    observe: SweepObserver,
) -> Result<Sweep> {
    cases::write_volumes(folder, &stability.volumes)?;
    let records = folder.join("records");
    std::fs::create_dir_all(&records).map_err(Error::writing(&records))?;
    let wanted: Vec<_> = stability
        .extremes
        .iter()
        .filter(|extreme| profile == Profile::Full || !extreme.full_only)
        .map(|extreme| (extreme, sweep::case_id(stability, extreme, renderer)))
        .collect();
    let mut found: Vec<Option<SweepCase>> = wanted
        .iter()
        .map(|(_, id)| sweep::recorded(folder, id))
        .collect();
    let mut tell = |event: SweepEvent<'_>| match observe(event) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Stopped),
    };
    tell(SweepEvent::Planned {
        cases: wanted.len(),
        done: found.iter().flatten().count(),
    })?;
    tell(SweepEvent::Begins("thresholds".to_owned()))?;
    let start = Instant::now();
    let thresholds = thresholds(renderer, folder)?;
    let mut wall_s = start.elapsed().as_secs_f64();
    let mut cases = Vec::with_capacity(wanted.len());
    for ((extreme, _), known) in wanted.iter().zip(&mut found) {
        let case = match known.take() {
            Some(case) => case,
            None => {
                tell(SweepEvent::Begins(format!(
                    "{} {}",
                    extreme.group, extreme.name
                )))?;
                let case = sweep::run_case(stability, extreme, renderer, folder)?;
                tell(SweepEvent::Case(&case))?;
                case
            }
        };
        wall_s += case.wall_s;
        cases.push(case);
    }
    Ok(Sweep {
        schema: SCHEMA.to_owned(),
        name: stability.name.clone(),
        profile: profile.name().to_owned(),
        environment: renderer.map(|renderer| Environment::of_device(&renderer.gpu)),
        wall_s,
        thresholds,
        cases,
    })
}
