//! A method prepared in a view, on either backend: renders frames, reads back pictures and maps, counts samples.

use super::sequence::{Sequence, SequenceKind};
use super::{Backend, View, ViewKind};
use crate::cost::Counting;
use crate::cost::{Counts, Memory, PassTimes};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::occlusion::MethodSetup;
use crate::oracle::{Options, Oracle};
use crate::progress::{Progress, unwatched};
use crate::raymarch::{self, MapTexels, Renderer, planned_memory};
use crate::reconstruct::{OracleSequence, Reconstruction};
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::Instant;

/// A method prepared in a view; renders the next frames of a sequence.
pub struct Prepared<'v> {
    /// Memory of the method, without the history of the sequence.
    pub memory: Memory,
    setup: MethodSetup,
    reconstruction: &'static dyn Reconstruction,
    kind: Executor<'v>,
}

enum Executor<'v> {
    Device {
        renderer: &'v Renderer,
        view: &'v raymarch::DeviceView,
        prepared: Box<raymarch::PreparedPasses>,
    },
    Oracle {
        oracle: &'v Oracle,
        /// The frame whose light map is read.
        map_of: &'v Oracle,
        sequence: Rc<RefCell<Box<dyn OracleSequence>>>,
        /// Counts of the last frame.
        counts: Cell<Option<Counts>>,
    },
}

/// Error: a view was passed to a backend that did not make it.
pub(super) fn stranger() -> Error {
    Error::defect(
        "backend",
        "a view of a device was given to the oracle, or the reverse",
    )
}

impl<'v> Prepared<'v> {
    pub(super) fn new(
        backend: &'v Backend,
        view: &'v View,
        map_of: &'v View,
        setup: &MethodSetup,
        sequence: &Sequence,
    ) -> Result<Self> {
        let views = (&view.kind, &map_of.kind);
        let (memory, kind) = match (backend, views, &sequence.kind) {
            (
                Backend::Device(renderer),
                (ViewKind::Device(view), ViewKind::Device(map_of)),
                SequenceKind::Device(sequence),
            ) => {
                let prepared = renderer.prepare_with_map_of(map_of, view, setup, sequence)?;
                let memory = prepared.memory;
                let kind = Executor::Device {
                    renderer,
                    view,
                    prepared: Box::new(prepared),
                };
                (memory, kind)
            }
            (
                Backend::Oracle(_),
                (ViewKind::Oracle(oracle), ViewKind::Oracle(map_of)),
                SequenceKind::Oracle(sequence),
            ) => {
                // A setting that cannot be prepared is refused here, not in the middle of a round.
                oracle.prepare(setup, Options::stored(setup))?;
                let kind = Executor::Oracle {
                    oracle,
                    map_of,
                    sequence: sequence.clone(),
                    counts: Cell::new(None),
                };
                (planned_memory(setup)?, kind)
            }
            _ => return Err(stranger()),
        };
        Ok(Self {
            memory,
            setup: setup.clone(),
            reconstruction: sequence.reconstruction,
            kind,
        })
    }

    /// Renders the next frame. On the oracle the map is marched anew, and only the wall time is known.
    pub fn run(&self, progress: Progress) -> Result<PassTimes> {
        match &self.kind {
            Executor::Device {
                renderer, prepared, ..
            } => prepared.run(&renderer.gpu, progress),
            Executor::Oracle {
                oracle,
                map_of,
                sequence,
                counts,
            } => {
                let start = Instant::now();
                let options = Options::stored(&self.setup);
                let method = oracle.prepare_with_map_of(map_of, &self.setup, options)?;
                let made = sequence.borrow_mut().render(&method, progress)?;
                counts.set(Some(made));
                Ok(PassTimes {
                    wall: start.elapsed().as_secs_f64() * 1e3,
                    ..PassTimes::default()
                })
            }
        }
    }

    /// Renders the next `frames` frames without waiting between them; returns the times of each. `meanwhile` is called
    /// while they are in flight, on the oracle before the first. Needs one [`Self::run`] before.
    pub fn repeat(&self, frames: u32, meanwhile: impl FnOnce()) -> Result<Vec<PassTimes>> {
        match &self.kind {
            Executor::Device {
                renderer, prepared, ..
            } => prepared.repeat(&renderer.gpu, frames, meanwhile),
            Executor::Oracle { .. } => {
                meanwhile();
                (0..frames).map(|_| self.run(&mut unwatched)).collect()
            }
        }
    }

    /// The picture of the last frame. In a view on a device all methods that march every pixel share one picture: read
    /// it back before another of them runs there.
    pub fn picture(&self) -> Result<Frame> {
        match &self.kind {
            Executor::Device {
                renderer, prepared, ..
            } => prepared.picture(&renderer.gpu),
            Executor::Oracle { sequence, .. } => {
                // Borrowed while a frame is under way, which has no picture yet.
                let made = sequence.try_borrow().ok();
                made.and_then(|s| s.picture()).ok_or_else(unrendered)
            }
        }
    }

    /// The light map of the last run; `None` for a method without one, and on the oracle, which keeps none.
    pub fn map_texels(&self) -> Result<Option<MapTexels>> {
        match &self.kind {
            Executor::Device {
                renderer, prepared, ..
            } => prepared.map_texels(&renderer.gpu),
            Executor::Oracle { .. } => Ok(None),
        }
    }

    /// Counts of one frame, and the seconds that counting took. A device counts in extra passes, over the first frame
    /// of a sequence; the oracle counts while it renders, in 0 s.
    pub fn counts(&self, progress: Progress) -> Result<(Counts, f64)> {
        match &self.kind {
            Executor::Device { renderer, view, .. } => {
                let sequence = self.reconstruction.on_device(&renderer.gpu, view.image)?;
                let counting = renderer.prepare(view, &self.setup, &sequence, Counting::On)?;
                let times = counting.run(&renderer.gpu, progress)?;
                Ok((counting.counts(&renderer.gpu)?, times.wall * 1e-3))
            }
            Executor::Oracle { counts, .. } => Ok((counts.get().ok_or_else(unrendered)?, 0.0)),
        }
    }
}

fn unrendered() -> Error {
    Error::defect("backend", "a picture was asked for before it was rendered")
}
