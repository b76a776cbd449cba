//! The worker's loop.

use super::Request;
use super::mailbox::{Job, Mailbox};
use super::stage::{Finished, Stage, coarser, filled};
use super::update::{Rgb, Sender, Update, What};
use crate::backend::{Backend, View};
use crate::batch;
use crate::config::load_experiment;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::{Gpu, Sources};
use crate::metrics::{compare, difference_picture};
use crate::occlusion::MethodSetup;
use crate::occlusion::param::ParamValue;
use crate::raymarch::reference::cache_folder;
use crate::raymarch::{Renderer, Tiling, unwatched};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How often shaders on disk are looked at, and parts of a slow picture are sent.
const PATIENCE: Duration = Duration::from_millis(300);
const PARTS: Duration = Duration::from_millis(150);
/// A first picture may take about this, ms; what is slower starts coarser.
const FIRST_MS: f64 = 60.0;
/// Coarseness of a first picture whose speed is not known.
const UNKNOWN_FACTOR: u32 = 4;
/// The coarsest first picture.
const MOST_FACTOR: u32 = 8;

/// Edge of the smallest map of a first picture, texels.
const LEAST_MAP: i64 = 32;

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

struct Worker<'a> {
    backend: Backend,
    mailbox: &'a Mailbox,
    sender: Sender,
    stage: Option<Stage>,
    /// Milliseconds a pixel of the last exact picture, by method.
    speed: HashMap<&'static str, f64>,
    last: Option<Request>,
    /// Folder of shaders, and its files when they were last compiled.
    shaders: Option<PathBuf>,
    seen: Option<Sources>,
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

    fn failed(&self, serial: u64, what: Option<What>, error: &Error) {
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
        let mut wanted: Vec<(What, MethodSetup)> = Vec::new();
        for (i, setup) in request.methods.iter().enumerate() {
            wanted.push((What::Method(i), setup.clone()));
        }
        if request.truth {
            wanted.push((What::Truth, MethodSetup::truth(&request.scene)?));
        }
        let mut show = Show {
            worker: self,
            request,
            stage,
            coarse: HashMap::new(),
            shown: false,
        };
        let outcome = show.all(&wanted);
        let stage = show.stage;
        self.stage = Some(stage);
        outcome?;
        self.repeat(request)
    }

    /// Times of the first method, until something else is wanted.
    fn repeat(&self, request: &Request) -> Result<()> {
        let Some(setup) = request.methods.first().filter(|_| request.repeat) else {
            return Ok(());
        };
        let view = self.backend.view(&request.scene, request.image)?;
        let prepared = self.backend.prepare(&view, setup)?;
        loop {
            let times = prepared.run(&mut |_| self.superseded())?;
            let serial = request.serial;
            self.sender.send(Update::Times { serial, times });
        }
    }

    fn superseded(&self) -> ControlFlow<()> {
        if self.mailbox.supersedes_request() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Coarseness of a first picture.
    fn factor(&self, request: &Request, setup: &MethodSetup) -> u32 {
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
        // A file that cannot be read is being written by an editor: it is looked at again.
        let Ok(sources) = Sources::read(folder) else {
            return;
        };
        let first = self.seen.is_none() && sources == renderer.gpu.sources;
        if first || self.seen.as_ref() == Some(&sources) {
            self.seen = Some(sources);
            return;
        }
        self.seen = Some(sources.clone());
        let last = self.last.clone();
        let outcome = renderer.reload(sources, |renderer| {
            let Some(request) = &last else {
                return Ok(());
            };
            let view = renderer.view(&request.scene, request.image)?;
            for setup in &request.methods {
                renderer.prepare(&view, setup)?;
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
        let cache = cache_folder();
        let cache = cache.as_deref();
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

/// The method with a map as coarse as its first picture: on a slow adapter the map takes longest.
fn preview(setup: &MethodSetup, factor: u32) -> MethodSetup {
    let mut setup = setup.clone();
    if let Some(ParamValue::Int(resolution)) = setup.params.get("resolution") {
        let coarse = (resolution / i64::from(factor)).max(resolution.min(LEAST_MAP));
        setup.params.set("resolution", ParamValue::Int(coarse));
    }
    setup
}

/// One request being served.
struct Show<'a, 'w> {
    worker: &'a mut Worker<'w>,
    request: &'a Request,
    stage: Stage,
    coarse: HashMap<What, Frame>,
    /// Something of this request is on the screen: it may be superseded from now on.
    shown: bool,
}

impl Show<'_, '_> {
    /// Coarse pictures first, then exact ones, in the order of urgency; what fails is said and the others go on.
    fn all(&mut self, wanted: &[(What, MethodSetup)]) -> Result<()> {
        let mut coarse = Vec::new();
        for (what, setup) in wanted {
            if let Some(finished) = self.stage.finished(setup).cloned() {
                self.send_exact(*what, setup, &finished)?;
                continue;
            }
            match self.first(*what, setup) {
                Ok(true) => {}
                Ok(false) => coarse.push((*what, setup)),
                Err(error) => self.tell_or_stop(*what, error)?,
            }
        }
        for (what, setup) in coarse {
            // Finished meanwhile: the same method twice.
            let outcome = match self.stage.finished(setup).cloned() {
                Some(finished) => self.send_exact(what, setup, &finished),
                None => self.exact(what, setup),
            };
            if let Err(error) = outcome {
                self.tell_or_stop(what, error)?;
            }
        }
        Ok(())
    }

    fn tell_or_stop(&self, what: What, error: Error) -> Result<()> {
        if !error.concerns_one_cell() {
            return Err(error);
        }
        self.worker.failed(self.request.serial, Some(what), &error);
        Ok(())
    }

    /// The first picture, coarse where the exact one would take too long; is it the exact one?
    fn first(&mut self, what: What, setup: &MethodSetup) -> Result<bool> {
        let factor = self.worker.factor(self.request, setup);
        if factor == 1 {
            self.exact(what, setup)?;
            return Ok(true);
        }
        let image = coarser(self.request.image, factor);
        let view = self.worker.backend.view(&self.request.scene, image)?;
        let prepared = self
            .worker
            .backend
            .prepare(&view, &preview(setup, factor))?;
        let (worker, shown) = (&*self.worker, self.shown);
        prepared.run(&mut |_| match shown {
            true => worker.superseded(),
            false => ControlFlow::Continue(()),
        })?;
        let frame = prepared.picture()?;
        let drawn = self
            .stage
            .drawn(what, Arc::new(frame.clone()), factor, 1.0, None);
        self.send(drawn);
        self.coarse.insert(what, frame);
        Ok(false)
    }

    /// The exact picture; its finished bands are sent while it takes long.
    fn exact(&mut self, what: What, setup: &MethodSetup) -> Result<()> {
        let (scene, image) = (&self.request.scene, self.request.image);
        let view: View = self.worker.backend.view(scene, image)?;
        let prepared = self.worker.backend.prepare(&view, setup)?;
        let mut sent = Instant::now();
        let mut broken = None;
        let ran = prepared.run(&mut |share| {
            if self.shown && self.worker.superseded().is_break() {
                return ControlFlow::Break(());
            }
            let due = sent.elapsed() >= PARTS && share > 0.0 && share < 1.0;
            if let Some(coarse) = self.coarse.get(&what).filter(|_| due) {
                match prepared.picture() {
                    Ok(frame) => {
                        let frame = Arc::new(filled(frame, share, coarse));
                        let drawn = self.stage.drawn(what, frame, 1, share, None);
                        self.worker.sender.send(Update::Picture {
                            serial: self.request.serial,
                            drawn,
                        });
                    }
                    Err(error) => {
                        broken = Some(error);
                        return ControlFlow::Break(());
                    }
                }
                sent = Instant::now();
            }
            ControlFlow::Continue(())
        });
        if let Some(error) = broken {
            return Err(error);
        }
        let times = ran?;
        let finished = Finished {
            frame: Arc::new(prepared.picture()?),
            cost: (times, prepared.memory),
        };
        let pixels = f64::from(image.width) * f64::from(image.height);
        let id = setup.method.info().id;
        self.worker.speed.insert(id, times.wall / pixels);
        self.stage.keep(setup, finished.clone());
        if let What::Method(index) = what
            && self.request.map_of == Some(index)
        {
            let texels = prepared.map_texels()?.map(Arc::new);
            self.send_map(index, texels);
        }
        self.send_kept(what, &finished);
        Ok(())
    }

    /// An exact picture that was there already; its map is rendered again if it is wanted.
    fn send_exact(&mut self, what: What, setup: &MethodSetup, finished: &Finished) -> Result<()> {
        if let What::Method(index) = what
            && self.request.map_of == Some(index)
        {
            let (scene, image) = (
                &self.request.scene,
                coarser(self.request.image, MOST_FACTOR),
            );
            let view = self.worker.backend.view(scene, image)?;
            let prepared = self.worker.backend.prepare(&view, setup)?;
            prepared.run(&mut unwatched)?;
            let texels = prepared.map_texels()?.map(Arc::new);
            self.send_map(index, texels);
        }
        self.send_kept(what, finished);
        Ok(())
    }

    fn send_map(&self, method: usize, texels: Option<Arc<crate::raymarch::MapTexels>>) {
        self.worker.sender.send(Update::Map {
            serial: self.request.serial,
            method,
            texels,
        });
    }

    /// Sends an exact picture and what can be said of it; a new truth concerns all methods.
    fn send_kept(&mut self, what: What, finished: &Finished) {
        let drawn = self.stage.exact(what, finished);
        self.send(drawn);
        let methods = self.request.methods.iter().enumerate();
        let concerned: Vec<_> = methods
            .filter(|(i, _)| what == What::Truth || what == What::Method(*i))
            .filter_map(|(i, setup)| Some((i, self.stage.finished(setup)?.clone())))
            .collect();
        for (method, finished) in concerned {
            if what == What::Truth {
                // At the truth's own exposure.
                let drawn = self.stage.exact(What::Method(method), &finished);
                self.send(drawn);
            }
            self.compare(method, &finished);
        }
    }

    fn send(&mut self, drawn: super::Drawn) {
        self.shown = true;
        let serial = self.request.serial;
        self.worker.sender.send(Update::Picture { serial, drawn });
    }

    /// Compares with the truth, if it is there, beside the worker.
    fn compare(&self, method: usize, finished: &Finished) {
        let Some(truth) = self.stage.truth.clone().filter(|_| self.request.truth) else {
            return;
        };
        let (sender, frame) = (self.worker.sender.clone(), finished.frame.clone());
        let serial = self.request.serial;
        rayon::spawn(move || {
            let compared = compare(&truth, &frame).and_then(|comparison| {
                let difference = Rgb {
                    width: frame.width,
                    height: frame.height,
                    pixels: difference_picture(&truth, &frame)?,
                };
                Ok((comparison, Arc::new(difference)))
            });
            sender.send(Update::Compared {
                serial,
                method,
                result: compared.map_err(|e| e.to_string()),
            });
        });
    }
}
