//! Interactive worker: a thread that owns the renderer and serves one request at a time; a newer request cancels the
//! current one. Pictures start coarse and end exact. The window consumes its updates; the worker does not depend on a
//! window.
//!
//! ```text
//! Request ─► mailbox ─► worker: coarse picture, exact picture, truth band by band, error numbers ─► Update
//! ```
//!
//! An exact picture and its error numbers equal those of a batch cell.

mod mailbox;
mod probes;
mod show;
mod stage;
mod state;
mod update;
mod worker;

pub use probes::{Probed, Where};
pub use state::State;
pub use update::{Drawn, Rgb, Update, What};

use crate::gpu::Gpu;
use crate::occlusion::MethodSetup;
use crate::scene::{ImageSize, Scene};
use mailbox::Mailbox;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use update::Sender;

/// Request for pictures of one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Comes back with every [`Update`] about it.
    pub serial: u64,
    /// A valid scene.
    pub scene: Scene,
    /// Size of the exact pictures.
    pub image: ImageSize,
    /// Methods, the most urgent first; [`What::Method`] counts them from 0.
    pub methods: Vec<MethodSetup>,
    /// The truth too, and error numbers of every method against it.
    pub truth: bool,
    /// Index of the method whose light map is wanted.
    pub map_of: Option<usize>,
    /// Render the first method repeatedly when everything else is done, for its times.
    pub repeat: bool,
}

/// Handle of the worker thread; dropping it ends the thread.
pub struct Live {
    mailbox: Arc<Mailbox>,
    updates: Receiver<Update>,
    sender: Sender,
    oracle: probes::Shared,
    worker: Option<JoinHandle<()>>,
}

impl Live {
    /// Starts a worker on `gpu`. `wake` is called from other threads after every update; shaders are read from
    /// `shaders`, where given, and read again when they change.
    pub fn start(
        gpu: Gpu,
        shaders: Option<PathBuf>,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let mailbox = Arc::new(Mailbox::default());
        let (send, updates) = channel();
        let sender = Sender::new(send, Arc::new(wake));
        let (inbox, outbox) = (mailbox.clone(), sender.clone());
        let worker = std::thread::spawn(move || worker::work(gpu, shaders, &inbox, outbox));
        Self {
            mailbox,
            updates,
            sender,
            oracle: probes::Shared::default(),
            worker: Some(worker),
        }
    }

    /// Asks for pictures; an earlier request that is still under way is dropped after its first picture.
    pub fn request(&self, request: Request) {
        self.mailbox.post_request(request);
    }

    /// Runs an experiment file into `folder`; pictures wait until it is over.
    pub fn batch(&self, config: PathBuf, folder: PathBuf) {
        self.mailbox.post_batch(config, folder);
    }

    /// Stops the batch under way; its finished cells are kept.
    pub fn cancel_batch(&self) {
        if self.mailbox.cancel_batch() {
            let stopped = Err(crate::Error::Stopped.to_string());
            self.sender.send(Update::BatchDone(stopped));
        }
    }

    /// Asks for T(d) of `methods` along one light column, which the oracle computes beside the worker.
    pub fn probe(&self, request: &Request, methods: Vec<MethodSetup>, at: Where) {
        probes::start(&self.oracle, request, methods, at, self.sender.clone());
    }

    /// What happened since the last call.
    pub fn updates(&self) -> impl Iterator<Item = Update> + '_ {
        self.updates.try_iter()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.mailbox.stop();
        if let Some(worker) = self.worker.take() {
            // A panic of the worker was printed on stderr; nothing is left to end.
            let _ = worker.join();
        }
    }
}
