//! Serves one request: coarse pictures, exact ones, comparisons with the truth.

use super::Request;
use super::stage::{Finished, Stage, coarser, filled};
use super::update::{Drawn, Rgb, Update, What};
use super::worker::{MOST_FACTOR, Worker};
use crate::backend::View;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::metrics::{compare, difference_picture};
use crate::occlusion::MethodSetup;
use crate::param::ParamValue;
use crate::progress::unwatched;
use crate::raymarch::MapTexels;
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Interval at which finished parts of a slow picture are sent.
const PARTS: Duration = Duration::from_millis(150);
/// Edge of the smallest map of a first picture, texels.
const LEAST_MAP: i64 = 32;

/// The method with a coarser map for a coarse first picture: on a slow adapter the map takes longest.
fn preview(setup: &MethodSetup, factor: u32) -> MethodSetup {
    let mut setup = setup.clone();
    if let Some(ParamValue::Int(resolution)) = setup.params.get("resolution") {
        let coarse = (resolution / i64::from(factor)).max(resolution.min(LEAST_MAP));
        setup.params.set("resolution", ParamValue::Int(coarse));
    }
    setup
}

/// One request being served.
pub(super) struct Show<'a, 'w> {
    worker: &'a mut Worker<'w>,
    request: &'a Request,
    stage: Stage,
    coarse: HashMap<What, Frame>,
    /// A picture of this request is on the screen: from now on a newer request may cancel it.
    shown: bool,
}

impl<'a, 'w> Show<'a, 'w> {
    /// Begins to serve `request` with what `stage` has of it.
    pub fn new(worker: &'a mut Worker<'w>, request: &'a Request, stage: Stage) -> Self {
        Self {
            worker,
            request,
            stage,
            coarse: HashMap::new(),
            shown: false,
        }
    }

    /// The rendered pictures, for the next request.
    pub fn into_stage(self) -> Stage {
        self.stage
    }

    /// The methods, then the truth.
    fn wanted(&self) -> Result<Vec<(What, MethodSetup)>> {
        let methods = self.request.methods.iter().cloned().enumerate();
        let mut wanted: Vec<_> = methods.map(|(i, m)| (What::Method(i), m)).collect();
        if self.request.truth {
            wanted.push((What::Truth, MethodSetup::truth(&self.request.scene)?));
        }
        Ok(wanted)
    }

    /// Coarse pictures first, then exact ones, in the order of urgency; after a failure the others go on.
    pub fn all(&mut self) -> Result<()> {
        let wanted = self.wanted()?;
        let mut coarse = Vec::new();
        for (what, setup) in &wanted {
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
            // Finished earlier in this loop, where a method is requested twice.
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

    /// Renders the first picture, coarse where the exact one would take too long; returns whether it is exact.
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
            .prepare_full(&view, &preview(setup, factor))?;
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

    /// Renders the exact picture; sends its finished bands where it takes long.
    fn exact(&mut self, what: What, setup: &MethodSetup) -> Result<()> {
        let (scene, image) = (&self.request.scene, self.request.image);
        let view: View = self.worker.backend.view(scene, image)?;
        let prepared = self.worker.backend.prepare_full(&view, setup)?;
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
            let prepared = self.worker.backend.prepare_full(&view, setup)?;
            prepared.run(&mut unwatched)?;
            let texels = prepared.map_texels()?.map(Arc::new);
            self.send_map(index, texels);
        }
        self.send_kept(what, finished);
        Ok(())
    }

    fn send_map(&self, method: usize, texels: Option<Arc<MapTexels>>) {
        self.worker.sender.send(Update::Map {
            serial: self.request.serial,
            method,
            texels,
        });
    }

    /// Sends an exact picture and its comparison with the truth; a new truth is compared with all methods.
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

    fn send(&mut self, drawn: Drawn) {
        self.shown = true;
        let serial = self.request.serial;
        self.worker.sender.send(Update::Picture { serial, drawn });
    }

    /// Compares with the truth, if it is there, on another thread.
    fn compare(&self, method: usize, finished: &Finished) {
        let Some(truth) = self.stage.truth.clone().filter(|_| self.request.truth) else {
            return;
        };
        let (sender, frame) = (self.worker.sender.clone(), finished.frame.clone());
        let serial = self.request.serial;
        rayon::spawn(move || {
            let compared = compare(&truth, &frame).map_err(Error::from);
            let compared = compared.and_then(|comparison| {
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
