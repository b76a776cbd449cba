//! The worker's loop.

use super::Request;
use super::mailbox::{Job, Mailbox};
use super::show::Show;
use super::stage::Stage;
use super::update::{Sender, Update, What};
use crate::backend::Backend;
use crate::batch;
use crate::config::load_experiment;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Sources};
use crate::occlusion::MethodSetup;
use crate::raymarch::{Renderer, Tiling};
use crate::truth::TruthCache;
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Interval at which shaders on disk are checked.
const PATIENCE: Duration = Duration::from_millis(300);
/// Time for which files must stay unchanged before they are compiled.
const REST: Duration = Duration::from_millis(200);
/// Aimed time of a first picture, ms; slower ones start coarser.
const FIRST_MS: f64 = 60.0;
/// Coarseness of a first picture whose speed is not known.
const UNKNOWN_FACTOR: u32 = 4;
/// The coarsest first picture.
pub(super) const MOST_FACTOR: u32 = 8;

/// Takes jobs until it is told to stop.
pub(super) fn work(gpu: Gpu, shaders: Option<PathBuf>, mailbox: &Mailbox, sender: Sender) {
    let tiling = Tiling::beside_a_window(&gpu);
    let mut renderer = Renderer::new(gpu);
    renderer.tiling = tiling;
    let mut worker = Worker {
        backend: Backend::Device(Box::new(renderer)),
        mailbox,
        sender,
        stage: None,
        speed: HashMap::new(),
        last: None,
        seen: None,
        resting: None,
        shaders,
    };
    loop {
        worker.look_at_shaders();
        match mailbox.next(PATIENCE) {
            Job::Stop => return,
            Job::Idle => {}
            Job::Request(request) => worker.serve(*request),
            Job::Batch(config, folder) => worker.batch(&config, &folder),
        }
        if worker.say_if_lost() {
            return;
        }
    }
}

pub(super) struct Worker<'a> {
    pub backend: Backend,
    mailbox: &'a Mailbox,
    pub sender: Sender,
    stage: Option<Stage>,
    /// Milliseconds a pixel of the last exact picture, by method.
    pub speed: HashMap<&'static str, f64>,
    last: Option<Request>,
    /// Folder of shaders, and its files when they were last compiled.
    shaders: Option<PathBuf>,
    seen: Option<Sources>,
    /// Changed files that were not compiled yet, and since when they are unchanged.
    resting: Option<(Instant, Sources)>,
}

impl Worker<'_> {
    fn serve(&mut self, request: Request) {
        let serial = request.serial;
        self.last = Some(request.clone());
        match self.pictures(&request) {
            Ok(()) => self.sender.send(Update::Done { serial }),
            Err(Error::Stopped) => {}
            Err(error) => self.failed(serial, None, &error),
        }
    }

    pub fn failed(&self, serial: u64, what: Option<What>, error: &Error) {
        self.sender.send(Update::Failed {
            serial,
            what,
            message: error.to_string(),
        });
    }

    fn pictures(&mut self, request: &Request) -> Result<()> {
        let stage = match self.stage.take() {
            Some(stage) if stage.shows(request) => stage,
            other => Stage::new(request, other.and_then(|stage| stage.exposure())),
        };
        let mut show = Show::new(self, request, stage);
        let outcome = show.all();
        let stage = show.into_stage();
        self.stage = Some(stage);
        outcome?;
        self.repeat(request)
    }

    /// Renders the first method repeatedly, for its times, until something else is requested.
    fn repeat(&self, request: &Request) -> Result<()> {
        let Some(setup) = request.methods.first().filter(|_| request.repeat) else {
            return Ok(());
        };
        let view = self.backend.view(&request.scene, request.image)?;
        let prepared = self.backend.prepare_full(&view, setup)?;
        loop {
            let times = prepared.run(&mut |_| self.superseded())?;
            let serial = request.serial;
            self.sender.send(Update::Times { serial, times });
        }
    }

    pub fn superseded(&self) -> ControlFlow<()> {
        if self.mailbox.supersedes_request() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Coarseness of a first picture.
    pub fn factor(&self, request: &Request, setup: &MethodSetup) -> u32 {
        let pixels = f64::from(request.image.width) * f64::from(request.image.height);
        let Some(ms) = self.speed.get(setup.method.info().id).map(|s| s * pixels) else {
            return UNKNOWN_FACTOR;
        };
        let mut factor = 1;
        while factor < MOST_FACTOR && ms / f64::from(factor * factor) > FIRST_MS {
            factor *= 2;
        }
        factor
    }

    /// Takes shaders that changed on disk, if they compile.
    fn look_at_shaders(&mut self) {
        let (Some(folder), Backend::Device(renderer)) = (&self.shaders, &mut self.backend) else {
            return;
        };
        // A file that cannot be read is being written by an editor: it is read again later.
        let Ok(sources) = Sources::read(folder) else {
            return;
        };
        let first = self.seen.is_none() && sources == renderer.gpu.sources;
        if first || self.seen.as_ref() == Some(&sources) {
            self.seen = Some(sources);
            return;
        }
        // An editor may also truncate a file before writing it: files must stay unchanged for a while.
        match &self.resting {
            Some((since, known)) if *known == sources => {
                if since.elapsed() < REST {
                    return;
                }
            }
            _ => {
                self.resting = Some((Instant::now(), sources));
                return;
            }
        }
        self.seen = Some(sources.clone());
        let last = self.last.clone();
        let outcome = renderer.reload(sources, |renderer| {
            let Some(request) = &last else {
                return Ok(());
            };
            let view = renderer.view(&request.scene, request.image)?;
            for setup in &request.methods {
                renderer.prepare_full(&view, setup)?;
            }
            Ok(())
        });
        let taken = outcome.is_ok();
        let told = outcome.map_err(|error| error.to_string());
        self.sender.send(Update::Shaders(told));
        if taken && let Some(request) = last {
            self.stage = None;
            self.serve(request);
        }
    }

    fn batch(&mut self, config: &Path, folder: &Path) {
        let result = self.run_batch(config, folder);
        let told = result.map_err(|error| error.to_string());
        self.sender.send(Update::BatchDone(told));
    }

    fn run_batch(&self, config: &Path, folder: &Path) -> Result<PathBuf> {
        let experiment = load_experiment(config)?;
        let mut observe = |event| {
            self.sender.send(Update::Batch(event));
            if self.mailbox.supersedes_batch() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let cache = TruthCache::from_environment()?;
        let cache = cache.as_ref();
        let report = batch::run(&experiment, &self.backend, folder, cache, &mut observe)?;
        crate::report::write(folder, &report)
    }

    fn say_if_lost(&self) -> bool {
        let lost = matches!(&self.backend, Backend::Device(r) if r.gpu.is_lost());
        if lost {
            let name = self.backend.environment().adapter;
            let message = format!("the adapter {name} vanished (driver reset, or unplugged)");
            self.sender.send(Update::Lost(message));
        }
        lost
    }
}
