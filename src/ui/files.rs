//! Files that are opened and saved. The system's dialog runs on a thread of its own; where there is none a path can be
//! typed, and files can be dropped on the window.

use super::app::{App, Slot};
use super::batch::REPORTS;
use crate::error::Result;
use crate::frame::{Frame, write_frame, write_png};
use crate::live::{Rgb, State};
use eframe::egui;
use std::future::Future;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// A dialog that closes faster than a person can was never shown.
const NO_DIALOG: Duration = Duration::from_millis(400);

/// What a path is asked for.
#[derive(Clone)]
pub enum Purpose {
    /// To open a scene or an experiment.
    Open,
    /// To write the state as an experiment.
    SaveState,
    /// To write the scene alone.
    SaveScene,
    /// To write a picture, linear or as shown.
    Export(Arc<Frame>, Arc<Rgb>),
    /// To run an experiment.
    Batch,
}

impl Purpose {
    fn title(&self) -> &'static str {
        match self {
            Self::Open => "Open a scene or an experiment",
            Self::SaveState => "Save the state as an experiment",
            Self::SaveScene => "Save the scene",
            Self::Export(..) => "Export the picture of A (.exr linear, .png as shown)",
            Self::Batch => "Run an experiment",
        }
    }

    /// What a file to be written is called; `None` for one to be read.
    fn default_name(&self, scene: &str) -> Option<String> {
        match self {
            Self::Open | Self::Batch => None,
            Self::SaveState => Some(format!("{scene}-state.json")),
            Self::SaveScene => Some(format!("{scene}.json")),
            Self::Export(..) => Some(format!("{scene}.exr")),
        }
    }

    fn extensions(&self) -> &'static [&'static str] {
        match self {
            Self::Export(..) => &["exr", "png"],
            _ => &["json"],
        }
    }
}

/// Dialogs and writes under way.
#[derive(Default)]
pub struct Files {
    dialog: Option<Dialog>,
    typed: Option<(Purpose, String)>,
    writes: Vec<Receiver<Result<PathBuf>>>,
}

struct Dialog {
    purpose: Purpose,
    since: Instant,
    answer: Receiver<Option<PathBuf>>,
}

impl Files {
    /// Closes the field for a path.
    pub fn close(&mut self) {
        self.typed = None;
    }
}

impl App {
    /// Asks for a path in the system's dialog.
    pub(super) fn ask(&mut self, ctx: &egui::Context, purpose: Purpose) {
        if self.files.dialog.is_some() {
            return;
        }
        let dialog = rfd::AsyncFileDialog::new()
            .set_title(purpose.title())
            .add_filter("occlab", purpose.extensions());
        let answer = match purpose.default_name(&self.state.scene.name) {
            None => answer(ctx, dialog.pick_file()),
            Some(name) => answer(ctx, dialog.set_file_name(name).save_file()),
        };
        self.files.dialog = Some(Dialog {
            purpose,
            since: Instant::now(),
            answer,
        });
    }

    /// Asks for a path in a field of the window itself.
    pub fn ask_for_typed_path(&mut self, purpose: Purpose) {
        let name = purpose.default_name(&self.state.scene.name);
        self.files.typed = Some((purpose, name.unwrap_or_default()));
    }

    /// Asks where to export the picture of A.
    pub(super) fn export(&mut self, ctx: &egui::Context) {
        if let Some((frame, rgb)) = self.exact_picture() {
            self.ask(ctx, Purpose::Export(frame, rgb));
        }
    }

    /// Puts the picture of A into the clipboard, as shown.
    pub(super) fn copy_picture(&mut self, ctx: &egui::Context) {
        if let Some((_, rgb)) = self.exact_picture() {
            let size = [rgb.width as usize, rgb.height as usize];
            ctx.copy_image(egui::ColorImage::from_rgb(size, &rgb.pixels));
        }
    }

    /// The exact picture of A; a message where it is not there yet.
    fn exact_picture(&mut self) -> Option<(Arc<Frame>, Arc<Rgb>)> {
        let drawn = self.shown.picture(Slot::Side(0)).map(|p| &p.drawn);
        let found = drawn.filter(|d| d.is_exact());
        let found = found.map(|d| (d.frame.clone(), d.rgb.clone()));
        if found.is_none() {
            let what = match drawn {
                Some(_) => {
                    "Only a coarse picture of A is there yet: try again when it is finished."
                }
                None => "There is no picture of A yet.",
            };
            self.banners.say(what.to_owned());
        }
        found
    }

    /// Acts on a path that was asked for.
    fn chosen(&mut self, ctx: &egui::Context, purpose: Purpose, path: PathBuf) {
        let outcome = match purpose {
            Purpose::Open => self.open_file(&path),
            Purpose::SaveState => self.state.save(&with_extension(path, "json")),
            Purpose::SaveScene => self.state.save_scene(&with_extension(path, "json")),
            Purpose::Export(frame, rgb) => {
                self.files.writes.push(write(ctx, path, frame, rgb));
                Ok(())
            }
            Purpose::Batch => self.start_batch(&path, Path::new(REPORTS)),
        };
        if let Err(error) = outcome {
            self.banners.say(error.to_string());
        }
    }

    /// Shows what a scene or experiment file says.
    pub fn open_file(&mut self, path: &Path) -> Result<()> {
        let state = State::load(path)?;
        self.initial = state.clone();
        self.show_state(state);
        Ok(())
    }
}

/// Takes answers and outcomes, and draws the field for a path.
pub fn draw(app: &mut App, ctx: &egui::Context) {
    take_answer(app, ctx);
    let dropped = ctx.input(|i| i.raw.dropped_files.first().map(|f| f.path().to_owned()));
    if let Some(path) = dropped {
        app.chosen(ctx, Purpose::Open, path);
    }
    let mut failed = None;
    app.files.writes.retain(|write| match write.try_recv() {
        Ok(Err(error)) => {
            failed = Some(error.to_string());
            false
        }
        Err(TryRecvError::Empty) => true,
        Ok(Ok(_)) | Err(TryRecvError::Disconnected) => false,
    });
    if let Some(problem) = failed {
        app.banners.say(problem);
    }
    draw_typed(app, ctx);
}

fn take_answer(app: &mut App, ctx: &egui::Context) {
    let Some(dialog) = &app.files.dialog else {
        return;
    };
    let path = match dialog.answer.try_recv() {
        Err(TryRecvError::Empty) => return,
        // The dialog's thread panicked: there is no dialog.
        Err(TryRecvError::Disconnected) => None,
        Ok(path) => path,
    };
    let Some(Dialog { purpose, since, .. }) = app.files.dialog.take() else {
        return;
    };
    match path {
        Some(path) => app.chosen(ctx, purpose, path),
        None if since.elapsed() < NO_DIALOG => app.ask_for_typed_path(purpose),
        None => {}
    }
}

fn draw_typed(app: &mut App, ctx: &egui::Context) {
    let Some((purpose, mut path)) = app.files.typed.take() else {
        return;
    };
    let (mut open, mut done, mut cancelled) = (true, false, false);
    egui::Window::new(purpose.title())
        .id(egui::Id::unique("typed path"))
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(ctx, |ui| {
            let label = ui.label("File");
            let field = egui::TextEdit::singleline(&mut path).desired_width(420.0);
            let field = ui.add(field).labelled_by(label.id);
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            ui.horizontal(|ui| {
                let ready = !path.trim().is_empty();
                let clicked = ui.add_enabled(ready, egui::Button::new("OK")).clicked();
                done = ready && (clicked || entered);
                cancelled = ui.button("Cancel").clicked();
            });
            if !field.has_focus() && ui.memory(|m| m.focused().is_none()) && !done {
                field.request_focus();
            }
        });
    if done {
        app.chosen(ctx, purpose, PathBuf::from(path.trim()));
    } else if open && !cancelled {
        app.files.typed = Some((purpose, path));
    }
}

/// Waits for a dialog on a thread of its own.
fn answer<F>(ctx: &egui::Context, dialog: F) -> Receiver<Option<PathBuf>>
where
    F: Future<Output = Option<rfd::FileHandle>> + Send + 'static,
{
    let (send, receive) = channel();
    let ctx = ctx.clone();
    std::thread::spawn(move || {
        let path = pollster::block_on(dialog).map(|file| file.path().to_owned());
        // The receiver is gone when the window was closed meanwhile.
        let _ = send.send(path);
        ctx.request_repaint();
    });
    receive
}

/// Writes a picture on a thread of its own: large ones take a while.
fn write(
    ctx: &egui::Context,
    path: PathBuf,
    frame: Arc<Frame>,
    rgb: Arc<Rgb>,
) -> Receiver<Result<PathBuf>> {
    let (send, receive) = channel();
    let ctx = ctx.clone();
    std::thread::spawn(move || {
        let path = with_extension(path, "exr");
        let outcome = if path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"))
        {
            write_png(&path, rgb.width, rgb.height, &rgb.pixels)
        } else if path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("exr"))
        {
            write_frame(&path, &frame)
        } else {
            Err(crate::Error::input(
                path.display().to_string(),
                "neither .exr nor .png",
                "Name a file with one of these endings.",
            ))
        };
        let _ = send.send(outcome.map(|()| path));
        ctx.request_repaint();
    });
    receive
}

/// The path, with this extension if it has none.
fn with_extension(path: PathBuf, extension: &str) -> PathBuf {
    if path.extension().is_some() {
        path
    } else {
        path.with_extension(extension)
    }
}
