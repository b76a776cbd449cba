//! The window's content and its state between frames.

use super::map::MapView;
use super::probe::Asked;
use super::shown::Shown;
use super::view::{Mode, Pane, Play};
use super::{banner, batch, controls, files, help, lower, measure, menu, remember};
use crate::config::load_scene;
use crate::config::shipped::{self, FileKind};
use crate::error::Result;
use crate::live::{Live, Request, State, Update};
use crate::occlusion::{MethodSetup, REGISTRY};
use eframe::egui;
use egui::util::undoer::Undoer;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Slot of a picture: method A or B, the truth, or a method of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Slot {
    /// The method A, or B: 0, 1.
    Side(usize),
    /// The truth.
    Truth,
    /// A method of the grid, by its place in the registry.
    Grid(usize),
}

/// The window's content; drawn by eframe, and by tests without a window.
pub struct App {
    pub(super) state: State,
    pub(super) mode: Mode,
    pub(super) pane: Pane,
    /// The sun of a day is being played.
    pub(super) play: Option<Play>,
    /// The last probe that was asked for.
    pub(super) asked: Option<Asked>,
    pub(super) map_view: MapView,
    pub(super) shown: Shown,
    pub(super) live: Live,
    pub(super) adapter: String,
    /// Scene files to choose from.
    pub(super) scenes: Vec<PathBuf>,
    /// The chosen one, while it is unchanged.
    pub(super) scene_file: Option<PathBuf>,
    /// The truth is requested: error numbers, differences.
    pub(super) want_truth: bool,
    /// Times are measured repeatedly.
    pub(super) repeat: bool,
    pub(super) undoer: Undoer<State>,
    /// State that it was opened with, for `reset`.
    pub(super) initial: State,
    pub(super) banners: banner::Banners,
    pub(super) files: files::Files,
    pub(super) batch: batch::BatchPanel,
    pub(super) memory: remember::WindowMemory,
    /// The list of keys is open.
    pub(super) help: bool,
    sent: Option<Request>,
    serial: u64,
    start: Instant,
    ending: Arc<Mutex<Option<String>>>,
}

impl App {
    /// The content of a window over a worker.
    pub fn new(live: Live, adapter: String, state: Option<State>, start: Instant) -> Result<Self> {
        let scenes = shipped::list(FileKind::Scene);
        let (state, scene_file) = match state {
            Some(state) => (state, None),
            None => {
                let first = scenes.first().cloned().unwrap_or_default();
                (State::new(load_scene(&first)?)?, Some(first))
            }
        };
        Ok(Self {
            initial: state.clone(),
            state,
            mode: Mode::default(),
            pane: Pane::default(),
            play: None,
            asked: None,
            map_view: MapView::default(),
            shown: Shown::default(),
            live,
            adapter,
            scenes,
            scene_file,
            want_truth: true,
            repeat: false,
            undoer: Undoer::default(),
            banners: banner::Banners::default(),
            files: files::Files::default(),
            batch: batch::BatchPanel::default(),
            memory: remember::WindowMemory::default(),
            help: false,
            sent: None,
            serial: 0,
            start,
            ending: Arc::default(),
        })
    }

    /// The content, with `ending` to receive the error that closes the window.
    pub(super) fn ending_in(self, ending: Arc<Mutex<Option<String>>>) -> Self {
        Self { ending, ..self }
    }

    /// Replaces what is looked at.
    pub fn show_state(&mut self, state: State) {
        self.state = state;
        self.scene_file = None;
    }

    /// Takes what the worker sent.
    fn receive(&mut self, ctx: &egui::Context) {
        let updates: Vec<Update> = self.live.updates().collect();
        for update in updates {
            match update {
                Update::Lost(problem) => {
                    let mut ending = self.ending.lock().unwrap_or_else(PoisonError::into_inner);
                    *ending = Some(problem);
                    ctx.send_viewport_cmd(egui::ViewportCommand::Close);
                }
                Update::Shaders(outcome) => self.banners.shaders(outcome),
                Update::Failed { message, .. } => {
                    self.play = None;
                    self.banners.say(message);
                }
                other => self.shown.take(ctx, other),
            }
        }
    }

    /// Slots and methods that the state and the mode need.
    fn wanted(&self) -> (Vec<Slot>, Vec<MethodSetup>) {
        let side = |i: usize| (Slot::Side(i), self.state.methods[i].clone());
        let mut wanted = vec![side(0)];
        if self.mode.shows_b() || self.pane.map_of() == Some(1) {
            wanted.push(side(1));
        }
        if self.mode == Mode::Grid {
            for (i, method) in REGISTRY.iter().enumerate() {
                // The grid shows each method as it is set in A or B, else at its defaults; A is there already.
                let id = method.info().id;
                let [a, b] = self.state.methods.each_ref();
                if method.info().is_truth() || id == a.method.info().id {
                    continue;
                }
                let own = Some(b).filter(|b| b.method.info().id == id).cloned();
                let setup = own.or_else(|| MethodSetup::defaults(id).ok());
                wanted.extend(setup.map(|setup| (Slot::Grid(i), setup)));
            }
        }
        wanted.into_iter().unzip()
    }

    /// Sends a request when something changed.
    fn request(&mut self) {
        let (slots, methods) = self.wanted();
        let request = Request {
            serial: self.serial,
            scene: self.state.scene.clone(),
            image: self.state.image,
            methods,
            truth: self.want_truth,
            map_of: self.pane.map_of(),
            repeat: self.repeat,
        };
        if self.sent.as_ref() == Some(&request) {
            return;
        }
        if self.state.scene.validate().is_err() {
            return; // a control is half-way; the panel says what is wrong
        }
        self.serial += 1;
        let request = Request {
            serial: self.serial,
            ..request
        };
        self.shown.expect(&request, slots);
        self.live.request(request.clone());
        self.sent = Some(request);
    }

    /// Sends the next request even if nothing changed.
    pub(super) fn ask_again(&mut self) {
        self.sent = None;
    }

    /// The last request, for probes.
    pub(super) fn sent(&self) -> Option<&Request> {
        self.sent.as_ref()
    }

    /// When the program was started.
    pub(super) fn start(&self) -> Instant {
        self.start
    }

    /// Draws everything.
    pub fn draw(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        self.receive(&ctx);
        menu::keys(self, &ctx);
        egui::Panel::top("menu").show(ui, |ui| menu::draw(self, ui));
        egui::Panel::top("banners")
            .show_separator_line(false)
            .resizable(false)
            .show(ui, |ui| self.banners.draw(ui));
        egui::Panel::left("controls")
            .default_size(270.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| controls::draw(self, ui));
            });
        egui::Panel::right("measure")
            .default_size(250.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| measure::draw(self, ui));
            });
        lower::draw(self, ui);
        egui::CentralPanel::default().show(ui, |ui| super::view::draw(self, ui));
        files::draw(self, &ctx);
        batch::draw(self, &ctx);
        help::draw(self, &ctx);
        self.undoer.feed_state(ctx.input(|i| i.time), &self.state);
        self.request();
        self.remember(&ctx);
    }

    pub(super) fn undo(&mut self) {
        if let Some(state) = self.undoer.undo(&self.state).cloned() {
            self.state = state;
        }
    }

    pub(super) fn redo(&mut self) {
        if let Some(state) = self.undoer.redo(&self.state).cloned() {
            self.state = state;
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.draw(ui);
    }

    fn on_exit(&mut self) {
        self.remember_at_exit();
    }
}
