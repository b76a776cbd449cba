//! Textures and numbers from the worker's updates, by slot.

use super::app::Slot;
use crate::cost::PassTimes;
use crate::live::{Drawn, Probed, Request, Rgb, Update, What};
use crate::metrics::Comparison;
use crate::occlusion::MethodSetup;
use crate::raymarch::MapTexels;
use crate::scene::{ImageSize, Scene};
use eframe::egui;
use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::Instant;

/// Most requests whose updates are still accepted.
const REMEMBERED: usize = 256;
/// Runs in the rolling plot.
const RUNS: usize = 120;

/// Everything the window has to show for the current request, by slot.
#[derive(Default)]
pub struct Shown {
    pictures: HashMap<Slot, ShownPicture>,
    compared: HashMap<Slot, Compared>,
    expected: VecDeque<Expected>,
    /// Scene, size and method whose times are in `runs`.
    timed: Option<(Scene, ImageSize, Option<MethodSetup>)>,
    /// Everything that was requested is there.
    pub done: bool,
    /// The light map that was asked for last and whose it is; `None` inside: the method has none.
    pub map: Option<(Slot, Option<Arc<MapTexels>>)>,
    /// The last probe.
    pub probed: Option<Result<Arc<Probed>, String>>,
    /// Times of the method A, latest last, at most 120.
    pub runs: VecDeque<PassTimes>,
    /// From the last change to its first picture on the screen, ms.
    pub latency_ms: Option<f64>,
    /// When the first picture of all came.
    pub first: Option<Instant>,
    /// Updates of a batch, for the panel that runs it.
    pub batch: Vec<Update>,
}

/// A picture on the screen.
pub struct ShownPicture {
    serial: u64,
    /// What was drawn.
    pub drawn: Drawn,
    /// The same as a texture.
    pub texture: egui::TextureHandle,
}

/// Error numbers on the screen.
pub struct Compared {
    serial: u64,
    /// The numbers, and the signed difference as a texture.
    pub result: Result<(Comparison, egui::TextureHandle), String>,
}

struct Expected {
    serial: u64,
    slots: Vec<Slot>,
    since: Instant,
    seen: bool,
}

impl Shown {
    /// Registers a request that was sent; its methods belong to `slots`.
    pub fn expect(&mut self, request: &Request, slots: Vec<Slot>) {
        self.done = false;
        let timed = (
            request.scene.clone(),
            request.image,
            request.methods.first().cloned(),
        );
        if self.timed.as_ref() != Some(&timed) {
            self.runs.clear();
            self.timed = Some(timed);
        }
        self.expected.push_back(Expected {
            serial: request.serial,
            slots,
            since: Instant::now(),
            seen: false,
        });
        if self.expected.len() > REMEMBERED {
            self.expected.pop_front();
        }
    }

    /// The picture of a slot.
    pub fn picture(&self, slot: Slot) -> Option<&ShownPicture> {
        self.pictures.get(&slot)
    }

    /// Is the picture of a slot that of the last request?
    pub fn is_current(&self, slot: Slot) -> bool {
        let latest = self.expected.back().map(|e| e.serial);
        let drawn = self.pictures.get(&slot).map(|p| p.serial);
        drawn.is_some() && drawn == latest
    }

    /// Something of the last request is on the screen.
    pub fn has_first(&self) -> bool {
        self.expected.back().is_some_and(|e| e.seen)
    }

    /// Error numbers of a slot, and whether they are those of the picture that is asked for now.
    pub fn compared(&self, slot: Slot) -> Option<(&Compared, bool)> {
        let latest = self.expected.back().map(|e| e.serial);
        self.compared
            .get(&slot)
            .map(|c| (c, Some(c.serial) == latest))
    }

    /// Takes an update of the worker.
    pub fn take(&mut self, ctx: &egui::Context, update: Update) {
        match update {
            Update::Picture { serial, drawn } => self.take_picture(ctx, serial, drawn),
            Update::Compared {
                serial,
                method,
                result,
            } => {
                let Some(slot) = self.slot(serial, What::Method(method)) else {
                    return;
                };
                let result = result.map(|(comparison, difference)| {
                    let texture = texture(ctx, &format!("difference {slot:?}"), &difference);
                    (comparison, texture)
                });
                let newer = self.compared.get(&slot).is_none_or(|c| c.serial <= serial);
                if newer {
                    self.compared.insert(slot, Compared { serial, result });
                }
            }
            Update::Map {
                serial,
                method,
                texels,
            } => {
                if let Some(slot) = self.slot(serial, What::Method(method)) {
                    self.map = Some((slot, texels));
                }
            }
            Update::Times { times, .. } => self.add_run(times),
            Update::Done { serial } => {
                self.done = self.expected.back().is_some_and(|e| e.serial == serial);
            }
            Update::Probed { result, .. } => self.probed = Some(result),
            batch @ (Update::Batch(_) | Update::BatchDone(_)) => self.batch.push(batch),
            // Handled by the window itself.
            Update::Failed { .. } | Update::Shaders(_) | Update::Lost(_) => {}
        }
    }

    fn take_picture(&mut self, ctx: &egui::Context, serial: u64, drawn: Drawn) {
        let Some(slot) = self.slot(serial, drawn.what) else {
            return;
        };
        if let Some(expected) = self.expected.iter_mut().find(|e| e.serial == serial)
            && !expected.seen
        {
            expected.seen = true;
            self.first.get_or_insert_with(Instant::now);
            self.latency_ms = Some(expected.since.elapsed().as_secs_f64() * 1e3);
        }
        if slot == Slot::Side(0)
            && let Some((times, _)) = drawn.cost
        {
            // A picture that was there already is sent again with the time it took then.
            if self.runs.back() != Some(&times) {
                self.add_run(times);
            }
        }
        match self.pictures.get_mut(&slot) {
            Some(known) if known.serial > serial => {}
            Some(known) => {
                known.texture.set(image(&drawn.rgb), options());
                known.serial = serial;
                known.drawn = drawn;
            }
            None => {
                let texture = texture(ctx, &format!("picture {slot:?}"), &drawn.rgb);
                let picture = ShownPicture {
                    serial,
                    drawn,
                    texture,
                };
                self.pictures.insert(slot, picture);
            }
        }
    }

    fn add_run(&mut self, times: PassTimes) {
        self.runs.push_back(times);
        if self.runs.len() > RUNS {
            self.runs.pop_front();
        }
    }

    fn slot(&self, serial: u64, what: What) -> Option<Slot> {
        match what {
            What::Truth => Some(Slot::Truth),
            What::Method(index) => {
                let expected = self.expected.iter().find(|e| e.serial == serial)?;
                expected.slots.get(index).copied()
            }
        }
    }
}

fn image(rgb: &Rgb) -> egui::ColorImage {
    egui::ColorImage::from_rgb([rgb.width as usize, rgb.height as usize], &rgb.pixels)
}

fn texture(ctx: &egui::Context, name: &str, rgb: &Rgb) -> egui::TextureHandle {
    ctx.load_texture(name, image(rgb), options())
}

/// Pixels are shown without interpolation.
fn options() -> egui::TextureOptions {
    egui::TextureOptions::NEAREST
}
