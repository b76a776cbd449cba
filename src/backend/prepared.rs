//! A method made ready in a view, on either backend.

use super::temporal::Temporal;
use super::{Backend, View, ViewKind};
use crate::cost::{Counts, Memory, PassTimes};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::occlusion::MethodSetup;
use crate::oracle::{Options, Oracle};
use crate::progress::{Progress, unwatched};
use crate::raymarch::{self, MapTexels, Renderer, planned_memory};
use std::cell::RefCell;
use std::time::Instant;

/// See the module.
pub struct Prepared<'v> {
    /// Memory of the method.
    pub memory: Memory,
    setup: MethodSetup,
    kind: Kind<'v>,
}

enum Kind<'v> {
    Device {
        renderer: &'v Renderer,
        view: &'v raymarch::View,
        prepared: Box<raymarch::Prepared>,
    },
    Oracle {
        oracle: &'v Oracle,
        /// What the last run made.
        made: RefCell<Option<(Frame, Counts)>>,
    },
    Temporal(Temporal<'v>),
}

/// A view was handed to a backend that did not make it.
pub(super) fn stranger() -> Error {
    Error::defect(
        "backend",
        "a view of a device was given to the oracle, or the reverse",
    )
}

impl<'v> Prepared<'v> {
    pub(super) fn new(backend: &'v Backend, view: &'v View, setup: &MethodSetup) -> Result<Self> {
        let (memory, kind) = match (backend, &view.kind) {
            (Backend::Device(renderer), ViewKind::Device(view)) => {
                let prepared = Box::new(renderer.prepare(view, setup)?);
                let memory = prepared.memory;
                let kind = Kind::Device {
                    renderer,
                    view,
                    prepared,
                };
                (memory, kind)
            }
            (Backend::Oracle(_), ViewKind::Oracle(oracle)) => {
                // What cannot be prepared is refused here, not in the middle of a round.
                oracle.prepare(setup, Options::stored(setup))?;
                let made = RefCell::default();
                (planned_memory(setup)?, Kind::Oracle { oracle, made })
            }
            _ => return Err(stranger()),
        };
        Ok(Self {
            memory,
            setup: setup.clone(),
            kind,
        })
    }

    pub(super) fn temporal(memory: Memory, setup: &MethodSetup, temporal: Temporal<'v>) -> Self {
        Self {
            memory,
            setup: setup.clone(),
            kind: Kind::Temporal(temporal),
        }
    }

    /// Renders once, or the next frame of a sequence. On the oracle the map is marched anew, and only the wall time is known.
    pub fn run(&self, progress: Progress) -> Result<PassTimes> {
        match &self.kind {
            Kind::Temporal(temporal) => temporal.run(&self.setup, progress),
            Kind::Device {
                renderer, prepared, ..
            } => prepared.run(&renderer.gpu, progress),
            Kind::Oracle { oracle, made } => {
                let start = Instant::now();
                let method = oracle.prepare(&self.setup, Options::stored(&self.setup))?;
                let result = method.render(progress)?;
                *made.borrow_mut() = Some(result);
                Ok(PassTimes {
                    wall: start.elapsed().as_secs_f64() * 1e3,
                    ..PassTimes::default()
                })
            }
        }
    }

    /// Renders `frames` pictures, or the next frames of a sequence, without waiting between them; the times of each. `meanwhile`
    /// is called while they are under way, on the oracle before them. Run once before.
    pub fn repeat(&self, frames: u32, meanwhile: impl FnOnce()) -> Result<Vec<PassTimes>> {
        match &self.kind {
            Kind::Temporal(temporal) => temporal.repeat(&self.setup, frames, meanwhile),
            Kind::Device {
                renderer, prepared, ..
            } => prepared.repeat(&renderer.gpu, frames, meanwhile),
            Kind::Oracle { .. } => {
                meanwhile();
                (0..frames).map(|_| self.run(&mut unwatched)).collect()
            }
        }
    }

    /// The picture of the last run. A device keeps one for each view: ask before another method runs there.
    pub fn picture(&self) -> Result<Frame> {
        match &self.kind {
            Kind::Temporal(temporal) => temporal.picture(),
            Kind::Device { renderer, view, .. } => view.read(&renderer.gpu),
            Kind::Oracle { made, .. } => match &*made.borrow() {
                Some((frame, _)) => Ok(frame.clone()),
                None => Err(unrendered()),
            },
        }
    }

    /// The light map of the last run; `None` for a method without one, for frames of a sequence, and on the oracle, which
    /// keeps none.
    pub fn map_texels(&self) -> Result<Option<MapTexels>> {
        match &self.kind {
            Kind::Device {
                renderer, prepared, ..
            } => prepared.map_texels(&renderer.gpu),
            Kind::Temporal(_) | Kind::Oracle { .. } => Ok(None),
        }
    }

    /// Counts of one picture, or of one frame of a sequence, and the seconds that counting took: a pass of its own on a
    /// device, nothing on the oracle, which counts as it renders.
    pub fn counts(&self, progress: Progress) -> Result<(Counts, f64)> {
        match &self.kind {
            Kind::Temporal(temporal) => temporal.counts(&self.setup, progress),
            Kind::Device { renderer, view, .. } => {
                let counting = renderer.prepare_counting(view, &self.setup)?;
                let times = counting.run(&renderer.gpu, progress)?;
                Ok((counting.counts(&renderer.gpu)?, times.wall * 1e-3))
            }
            Kind::Oracle { made, .. } => match &*made.borrow() {
                Some((_, counts)) => Ok((*counts, 0.0)),
                None => Err(unrendered()),
            },
        }
    }
}

pub(super) fn unrendered() -> Error {
    Error::defect("backend", "a picture was asked for before it was rendered")
}
