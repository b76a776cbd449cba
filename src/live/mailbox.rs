//! Inbox of the worker: the latest request and the latest batch.

use super::Request;
use std::path::PathBuf;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Latest request and latest batch that the worker has not taken yet; a newer one replaces an older.
#[derive(Default)]
pub(super) struct Mailbox {
    inbox: Mutex<Inbox>,
    filled: Condvar,
}

#[derive(Default)]
struct Inbox {
    request: Option<Request>,
    batch: Option<(PathBuf, PathBuf)>,
    cancel: bool,
    stop: bool,
}

/// The next thing to do.
pub(super) enum Job {
    Request(Box<Request>),
    /// Experiment file and report folder.
    Batch(PathBuf, PathBuf),
    /// Nothing arrived while waiting.
    Idle,
    Stop,
}

impl Mailbox {
    pub fn post_request(&self, request: Request) {
        self.lock().request = Some(request);
        self.filled.notify_one();
    }

    pub fn post_batch(&self, config: PathBuf, folder: PathBuf) {
        let mut inbox = self.lock();
        inbox.cancel = false;
        inbox.batch = Some((config, folder));
        self.filled.notify_one();
    }

    /// Ends the batch under way; returns whether it had not begun, so that no update will report its end.
    pub fn cancel_batch(&self) -> bool {
        let mut inbox = self.lock();
        inbox.cancel = true;
        inbox.batch.take().is_some()
    }

    pub fn stop(&self) {
        self.lock().stop = true;
        self.filled.notify_one();
    }

    /// The next job; waits for one at most `patience`.
    pub fn next(&self, patience: Duration) -> Job {
        let empty = |i: &mut Inbox| !i.stop && i.request.is_none() && i.batch.is_none();
        let (mut inbox, _) = self
            .filled
            .wait_timeout_while(self.lock(), patience, empty)
            .unwrap_or_else(PoisonError::into_inner);
        if inbox.stop {
            return Job::Stop;
        }
        if let Some((config, folder)) = inbox.batch.take() {
            return Job::Batch(config, folder);
        }
        match inbox.request.take() {
            Some(request) => Job::Request(Box::new(request)),
            None => Job::Idle,
        }
    }

    /// Whether a newer request, a batch or the end of the worker is waiting.
    pub fn supersedes_request(&self) -> bool {
        let inbox = self.lock();
        inbox.stop || inbox.request.is_some() || inbox.batch.is_some()
    }

    /// Whether the batch under way is to end.
    pub fn supersedes_batch(&self) -> bool {
        let inbox = self.lock();
        inbox.stop || inbox.cancel
    }

    /// A poisoned lock means that another thread panicked between two assignments: the inbox is still whole.
    fn lock(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
