//! Rendering backends: a device, or the f64 oracle on the CPU where there is no adapter. Both take the same steps:
//! [`Backend::view`] → [`Backend::prepare`] → [`Prepared::run`] → picture, times, counts, memory.
//!
//! Differences on the oracle: it has wall times only; a picture repeats bit for bit, so it is rendered once; map values
//! are rounded as the method's `storage` states, everything else is f64; map bytes are those that a device would
//! allocate.

mod prepared;
mod sequence;

pub use prepared::Prepared;
pub use sequence::Sequence;

use crate::cost::Counting;
use crate::cost::PassTimes;
use crate::environment::{Environment, host, program};
use crate::error::Result;
use crate::frame::Frame;
use crate::gpu::{ClockWatch, Gpu, Sources, list_adapters};
use crate::occlusion::MethodSetup;
use crate::oracle::Oracle;
use crate::progress::Progress;
use crate::provenance;
use crate::raymarch::{self, Renderer};
use crate::reconstruct;
use crate::scene::{ImageSize, Scene};
use crate::truth::{self, Truth, TruthCache};
use std::cell::RefCell;
use std::rc::Rc;

/// Requested backend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// A device; the oracle where this machine has no adapter at all.
    #[default]
    Auto,
    /// A device, or an error that names what to install.
    Gpu,
    /// The oracle.
    Cpu,
}

/// Renders views.
pub enum Backend {
    /// On a device.
    Device(Box<Renderer>),
    /// In f64 on the CPU.
    Oracle(OracleBackend),
}

/// The oracle as a backend; consecutive views of one density share its field.
#[derive(Default)]
pub struct OracleBackend {
    last: RefCell<Option<Rc<Oracle>>>,
}

/// A scene made ready, seen at one image size.
pub struct View {
    /// The scene.
    pub scene: Scene,
    /// Picture size.
    pub image: ImageSize,
    kind: ViewKind,
}

enum ViewKind {
    Device(Box<raymarch::DeviceView>),
    Oracle(Rc<Oracle>),
}

impl Backend {
    /// Opens the backend of `choice`. `adapter` is part of a device's name; where one is given, [`Choice::Auto`] does
    /// not fall back to the oracle.
    pub fn open(choice: Choice, adapter: Option<&str>) -> Result<Self> {
        let fall_back = choice == Choice::Auto && adapter.is_none() && list_adapters().is_empty();
        if choice == Choice::Cpu || fall_back {
            return Ok(Self::Oracle(OracleBackend::default()));
        }
        let renderer = Renderer::new(Gpu::new(adapter)?);
        Ok(Self::Device(Box::new(renderer)))
    }

    /// Is it the oracle?
    pub fn is_oracle(&self) -> bool {
        matches!(self, Self::Oracle(_))
    }

    /// Adapter, driver, build and host, for records.
    pub fn environment(&self) -> Environment {
        match self {
            Self::Device(renderer) => Environment::of_device(&renderer.gpu),
            Self::Oracle(_) => Environment {
                adapter: "oracle (f64, CPU)".to_owned(),
                driver: format!("{} threads, one run a cell", rayon::current_num_threads()),
                backend: Environment::ORACLE.to_owned(),
                device_type: "Cpu".to_owned(),
                commit: program(),
                host: host(),
            },
        }
    }

    /// Hash of the sources that decide a cell's numbers, 64 hexadecimal digits: those of the program and, where shaders
    /// read from a folder differ from the compiled-in ones, those shaders.
    pub fn sources(&self) -> String {
        let program = provenance::cell_sources();
        match self {
            Self::Device(renderer) if renderer.gpu.sources != Sources::embedded() => {
                let both = format!("{program} {}", renderer.gpu.sources.hash());
                blake3::hash(both.as_bytes()).to_hex().to_string()
            }
            _ => program.to_owned(),
        }
    }

    /// Seconds spent composing and compiling shaders so far.
    pub fn compile_s(&self) -> f64 {
        match self {
            Self::Device(renderer) => renderer.gpu.compile_s(),
            Self::Oracle(_) => 0.0,
        }
    }

    /// Numbers of discarded and of timed rounds, given those that an experiment asks for. The oracle has no pipelines
    /// to warm up and its pictures repeat bit for bit: one round gives everything but the spread of its wall time.
    pub fn rounds(&self, discard: u32, runs: u32) -> (u32, u32) {
        match self {
            Self::Device(_) => (discard, runs),
            Self::Oracle(_) => (0, 1),
        }
    }

    /// The device, and the watch that measures its clock; `None` on the oracle.
    pub fn watched(&self) -> Result<Option<(&Gpu, &ClockWatch)>> {
        match self {
            Self::Device(renderer) => Ok(Some((&renderer.gpu, renderer.clock_watch()?))),
            Self::Oracle(_) => Ok(None),
        }
    }

    /// Makes a scene ready for pictures of one size.
    pub fn view(&self, scene: &Scene, image: ImageSize) -> Result<View> {
        let kind = match self {
            Self::Device(renderer) => ViewKind::Device(Box::new(renderer.view(scene, image)?)),
            Self::Oracle(oracles) => {
                let mut last = oracles.last.borrow_mut();
                let oracle = Rc::new(match &*last {
                    Some(oracle) => oracle.again(scene, image)?,
                    None => Oracle::new(scene, image)?,
                });
                *last = Some(oracle.clone());
                ViewKind::Oracle(oracle)
            }
        };
        Ok(View {
            scene: scene.clone(),
            image,
            kind,
        })
    }

    /// Makes a method ready in a view of this backend, for the next frames of a sequence.
    pub fn prepare<'v>(
        &'v self,
        view: &'v View,
        setup: &MethodSetup,
        sequence: &Sequence,
    ) -> Result<Prepared<'v>> {
        Prepared::new(self, view, view, setup, sequence)
    }

    /// [`Self::prepare`] for frames in which every pixel is marched.
    pub fn prepare_full<'v>(&'v self, view: &'v View, setup: &MethodSetup) -> Result<Prepared<'v>> {
        let sequence = self.sequence(reconstruct::full(), view.image)?;
        Prepared::new(self, view, view, setup, &sequence)
    }

    /// [`Self::prepare_full`] with the light map of an earlier frame's view, where a map is filled over several frames.
    pub fn prepare_with_map_of<'v>(
        &'v self,
        earlier: &'v View,
        view: &'v View,
        setup: &MethodSetup,
    ) -> Result<Prepared<'v>> {
        let sequence = self.sequence(reconstruct::full(), view.image)?;
        Prepared::new(self, view, earlier, setup, &sequence)
    }

    /// One picture, start to end.
    pub fn render(
        &self,
        scene: &Scene,
        image: ImageSize,
        setup: &MethodSetup,
        progress: Progress,
    ) -> Result<(Frame, PassTimes)> {
        let view = self.view(scene, image)?;
        let prepared = self.prepare_full(&view, setup)?;
        let times = prepared.run(progress)?;
        Ok((prepared.picture()?, times))
    }

    /// The truth of a view: read from `cache` where it holds a complete entry of this backend, else rendered.
    pub fn truth(
        &self,
        view: &View,
        cache: Option<&TruthCache>,
        counting: Counting,
        progress: Progress,
    ) -> Result<Truth> {
        match (self, &view.kind) {
            (Self::Device(renderer), ViewKind::Device(view)) => {
                truth::on_device(renderer, view, cache, counting, progress)
            }
            (_, ViewKind::Oracle(oracle)) => truth::by_oracle(oracle, cache, progress),
            (Self::Oracle(_), ViewKind::Device(_)) => Err(prepared::stranger()),
        }
    }
}
