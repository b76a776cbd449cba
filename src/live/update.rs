//! Updates that the worker sends.

use super::probes::Probed;
use crate::batch::Event;
use crate::cost::{Memory, PassTimes};
use crate::frame::Frame;
use crate::metrics::Comparison;
use crate::raymarch::MapTexels;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};

/// Which picture of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum What {
    /// Picture of the method with this index in [`super::Request::methods`].
    Method(usize),
    /// The truth.
    Truth,
}

/// A picture for the screen: 8-bit sRGB, three bytes a pixel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Rgb {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes.
    pub pixels: Vec<u8>,
}

/// A picture, coarse or exact.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Which one.
    pub what: What,
    /// Tone-mapped at the exposure of the view's truth; until there is one, at that of the last picture before.
    pub rgb: Arc<Rgb>,
    /// Linear radiance, of the size of `rgb`.
    pub frame: Arc<Frame>,
    /// Pixels of the exact picture along an edge of one of these: 1 = the exact size.
    pub factor: u32,
    /// Share of the picture that is rendered at `factor` (the rest is filled from a coarser one), 0…1.
    pub share: f64,
    /// Times and memory of the exact, whole picture.
    pub cost: Option<(PassTimes, Memory)>,
}

impl Drawn {
    /// Is this the picture that a batch would keep?
    pub fn is_exact(&self) -> bool {
        self.factor == 1 && self.share >= 1.0
    }
}

/// News from the worker; `serial` is that of the request.
#[derive(Debug)]
pub enum Update {
    /// A picture, or more of one.
    Picture {
        /// See [`super::Request::serial`].
        serial: u64,
        /// The picture.
        drawn: Drawn,
    },
    /// Comparison of a method's exact picture with the truth.
    Compared {
        /// See [`super::Request::serial`].
        serial: u64,
        /// Index of the method.
        method: usize,
        /// Error numbers and the signed difference in false colours; or why there are none.
        result: Result<(Comparison, Arc<Rgb>), String>,
    },
    /// The light map of a method; `None` when it has none.
    Map {
        /// See [`super::Request::serial`].
        serial: u64,
        /// Index of the method.
        method: usize,
        /// Texels of the map; `None` for a method without one.
        texels: Option<Arc<MapTexels>>,
    },
    /// Times of one more run of the first method.
    Times {
        /// See [`super::Request::serial`].
        serial: u64,
        /// Times of that run.
        times: PassTimes,
    },
    /// Everything of a request was sent.
    Done {
        /// See [`super::Request::serial`].
        serial: u64,
    },
    /// Part of a request could not be rendered, the rest follows.
    Failed {
        /// See [`super::Request::serial`].
        serial: u64,
        /// Which picture; `None` = all of them.
        what: Option<What>,
        /// One paragraph.
        message: String,
    },
    /// Curves along a light column, or why there are none.
    Probed {
        /// See [`super::Request::serial`].
        serial: u64,
        /// The curves.
        result: Result<Arc<Probed>, String>,
    },
    /// Shaders changed on disk: taken over, or refused with file, line and reason while the old ones stay.
    Shaders(Result<(), String>),
    /// A batch goes on.
    Batch(Event),
    /// A batch ended; its page, or why there is none.
    BatchDone(Result<PathBuf, String>),
    /// The adapter vanished; nothing will be rendered any more.
    Lost(String),
}

/// Sends updates and wakes their receiver.
#[derive(Clone)]
pub(super) struct Sender {
    updates: mpsc::Sender<Update>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl Sender {
    pub fn new(updates: mpsc::Sender<Update>, wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        Self { updates, wake }
    }

    pub fn send(&self, update: Update) {
        // The receiver is gone while the owner is ending the worker: then no update is wanted.
        if self.updates.send(update).is_ok() {
            (self.wake)();
        }
    }
}
