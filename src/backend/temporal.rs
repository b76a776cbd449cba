//! Sequences of frames that remember, on either backend.

use super::prepared::{Prepared, stranger, unrendered};
use super::{Backend, View, ViewKind};
use crate::cost::{Counts, PassTimes};
use crate::error::Result;
use crate::frame::Frame;
use crate::occlusion::MethodSetup;
use crate::oracle::{self, Options, Oracle};
use crate::progress::{Progress, unwatched};
use crate::raymarch::{self, Renderer, planned_memory};
use crate::scene::{ImageSize, Reconstruct};
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::Instant;

/// The pictures that a sequence of frames remembers; see [`Reconstruct::Temporal2x2`].
#[derive(Clone)]
pub enum History {
    /// On a device.
    Device(Rc<raymarch::History>),
    /// Of the oracle.
    Oracle(Rc<RefCell<oracle::History>>),
}

/// A method made ready in a view, for frames of a sequence.
pub(super) enum Temporal<'v> {
    Device {
        renderer: &'v Renderer,
        view: &'v raymarch::View,
        prepared: Box<raymarch::Temporal>,
    },
    Oracle {
        oracle: &'v Oracle,
        history: Rc<RefCell<oracle::History>>,
        /// Of the last frame.
        counts: Cell<Option<Counts>>,
    },
}

impl Backend {
    /// A history that remembers nothing yet.
    pub fn history(&self, image: ImageSize) -> Result<History> {
        Ok(match self {
            Self::Device(renderer) => {
                History::Device(raymarch::History::new(&renderer.gpu, image)?)
            }
            Self::Oracle(_) => History::Oracle(Rc::new(RefCell::new(oracle::History::new(image)?))),
        })
    }

    /// Makes a method ready for the next frames of a sequence, which march a quarter of the pixels. Views of one sequence
    /// may differ in their cameras.
    pub fn prepare_temporal<'v>(
        &'v self,
        view: &'v View,
        setup: &MethodSetup,
        history: &History,
    ) -> Result<Prepared<'v>> {
        let (memory, temporal) = match (self, &view.kind, history) {
            (Self::Device(renderer), ViewKind::Device(view), History::Device(history)) => {
                let prepared = Box::new(renderer.prepare_temporal(view, setup, history)?);
                let memory = prepared.memory;
                let temporal = Temporal::Device {
                    renderer,
                    view,
                    prepared,
                };
                (memory, temporal)
            }
            (Self::Oracle(_), ViewKind::Oracle(oracle), History::Oracle(history)) => {
                oracle.prepare(setup, Options::stored(setup))?;
                let temporal = Temporal::Oracle {
                    oracle,
                    history: history.clone(),
                    counts: Cell::new(None),
                };
                (planned_memory(setup)?, temporal)
            }
            _ => return Err(stranger()),
        };
        Ok(Prepared::temporal(memory, setup, temporal))
    }

    /// [`Backend::prepare`], or for a method of its own sequence [`Backend::prepare_temporal`].
    pub fn prepare_as<'v>(
        &'v self,
        view: &'v View,
        setup: &MethodSetup,
        reconstruct: Reconstruct,
    ) -> Result<Prepared<'v>> {
        match reconstruct {
            Reconstruct::Full => self.prepare(view, setup),
            Reconstruct::Temporal2x2 => {
                self.prepare_temporal(view, setup, &self.history(view.image)?)
            }
        }
    }
}

impl Temporal<'_> {
    /// The next frame.
    pub fn run(&self, setup: &MethodSetup, progress: Progress) -> Result<PassTimes> {
        match self {
            Self::Device {
                renderer, prepared, ..
            } => prepared.run(&renderer.gpu, progress),
            Self::Oracle {
                oracle,
                history,
                counts,
            } => {
                let start = Instant::now();
                let method = oracle.prepare(setup, Options::stored(setup))?;
                let made = method.render_next(&mut history.borrow_mut(), progress)?;
                counts.set(Some(made));
                Ok(PassTimes {
                    wall: start.elapsed().as_secs_f64() * 1e3,
                    ..PassTimes::default()
                })
            }
        }
    }

    /// The next frames, without waiting between them.
    pub fn repeat(
        &self,
        setup: &MethodSetup,
        frames: u32,
        meanwhile: impl FnOnce(),
    ) -> Result<Vec<PassTimes>> {
        match self {
            Self::Device {
                renderer, prepared, ..
            } => prepared.repeat(&renderer.gpu, frames, meanwhile),
            Self::Oracle { .. } => {
                meanwhile();
                (0..frames)
                    .map(|_| self.run(setup, &mut unwatched))
                    .collect()
            }
        }
    }

    /// The picture of the sequence's last frame.
    pub fn picture(&self) -> Result<Frame> {
        match self {
            Self::Device {
                renderer, prepared, ..
            } => prepared.picture(&renderer.gpu),
            Self::Oracle { history, .. } => history.borrow().picture().ok_or_else(unrendered),
        }
    }

    /// Counts of one frame, and the seconds that counting took.
    pub fn counts(&self, setup: &MethodSetup, progress: Progress) -> Result<(Counts, f64)> {
        match self {
            Self::Device { renderer, view, .. } => {
                let counting = renderer.prepare_temporal_counting(view, setup)?;
                let times = counting.run(&renderer.gpu, progress)?;
                Ok((counting.counts(&renderer.gpu)?, times.wall * 1e-3))
            }
            Self::Oracle { counts, .. } => Ok((counts.get().ok_or_else(unrendered)?, 0.0)),
        }
    }
}

/// Bytes that a method of this kind remembers beside its maps.
pub fn history_bytes(reconstruct: Reconstruct, image: ImageSize) -> u64 {
    match reconstruct {
        Reconstruct::Full => 0,
        Reconstruct::Temporal2x2 => raymarch::history_bytes(image),
    }
}
