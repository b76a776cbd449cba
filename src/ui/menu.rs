//! The menu bar and the keys of the whole window.

use super::app::App;
use super::files::Purpose;
use super::help::Keys;
use eframe::egui::{self, Key, KeyboardShortcut, Modifiers, ThemePreference};
use egui::text_selection::LabelSelectionState;

/// Keys of this module.
pub const KEYS: Keys = &[
    ("Ctrl+O", "Open a scene or an experiment"),
    ("Ctrl+S", "Save what is shown as an experiment"),
    ("Ctrl+C", "Copy the picture of A"),
    ("Ctrl+Z", "Undo"),
    ("Ctrl+Shift+Z, Ctrl+Y", "Redo"),
    ("Ctrl+Q", "Quit"),
    ("?, F1", "This list"),
    ("Escape", "Close what lies over the pictures"),
];

const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
const COPY: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::C);
const QUIT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Q);
const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: KeyboardShortcut =
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
const REDO_TOO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);

/// Draws the bar.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(app, ui));
        ui.menu_button("Edit", |ui| edit(app, ui));
        ui.menu_button("View", view);
        ui.menu_button("Help", |ui| {
            if ui.button("Keys").clicked() {
                app.help = true;
            }
        });
    });
}

/// An entry with its keys.
fn entry(ui: &mut egui::Ui, text: &str, shortcut: Option<KeyboardShortcut>) -> bool {
    let button = egui::Button::new(text);
    let button = match shortcut {
        Some(shortcut) => button.shortcut_text(ui.ctx().format_shortcut(&shortcut)),
        None => button,
    };
    ui.add(button).clicked()
}

fn file(app: &mut App, ui: &mut egui::Ui) {
    let ctx = ui.ctx().clone();
    if entry(ui, "Open…", Some(OPEN)) {
        app.ask(&ctx, Purpose::Open);
    }
    if entry(ui, "Save state…", Some(SAVE)) {
        app.ask(&ctx, Purpose::SaveState);
    }
    if entry(ui, "Save scene…", None) {
        app.ask(&ctx, Purpose::SaveScene);
    }
    ui.separator();
    if entry(ui, "Export picture…", None) {
        app.export(&ctx);
    }
    if entry(ui, "Copy picture", Some(COPY)) {
        app.copy_picture(&ctx);
    }
    ui.separator();
    let idle = !app.batch.is_running();
    ui.add_enabled_ui(idle, |ui| {
        if entry(ui, "Run batch…", None) {
            app.ask(&ctx, Purpose::Batch);
        }
    });
    ui.separator();
    if entry(ui, "Quit", Some(QUIT)) {
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

fn edit(app: &mut App, ui: &mut egui::Ui) {
    let (can_undo, can_redo) = (
        app.undoer.has_undo(&app.state),
        app.undoer.has_redo(&app.state),
    );
    ui.add_enabled_ui(can_undo, |ui| {
        if entry(ui, "Undo", Some(UNDO)) {
            app.undo();
        }
    });
    ui.add_enabled_ui(can_redo, |ui| {
        if entry(ui, "Redo", Some(REDO)) {
            app.redo();
        }
    });
    if entry(ui, "Reset", None) {
        app.state = app.initial.clone();
    }
}

fn view(ui: &mut egui::Ui) {
    let mut theme = ui.ctx().options(|o| o.theme_preference);
    ui.radio_value(&mut theme, ThemePreference::Dark, "Dark");
    ui.radio_value(&mut theme, ThemePreference::Light, "Light");
    ui.radio_value(&mut theme, ThemePreference::System, "As the system");
    ui.ctx().set_theme(theme);
}

/// Acts on the keys of the whole window.
pub fn keys(app: &mut App, ctx: &egui::Context) {
    let pressed = |shortcut| ctx.input_mut(|i| i.consume_shortcut(&shortcut));
    if pressed(OPEN) {
        app.ask(ctx, Purpose::Open);
    }
    if pressed(SAVE) {
        app.ask(ctx, Purpose::SaveState);
    }
    if pressed(QUIT) {
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }
    if ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::F1)) {
        app.help = !app.help;
    }
    let escape = ctx.input(|i| i.key_pressed(Key::Escape));
    if escape {
        app.files.close();
    }
    // While text is edited, the keys below belong to it.
    if ctx.text_edit_focused() {
        return;
    }
    // With more modifiers first: the others ignore shift.
    if pressed(REDO) || pressed(REDO_TOO) {
        app.redo();
    }
    if pressed(UNDO) {
        app.undo();
    }
    if ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Questionmark)) {
        app.help = !app.help;
    }
    let copies = ctx.input(|i| i.events.iter().any(|e| matches!(e, egui::Event::Copy)));
    let selected = ctx.with_plugin(|labels: &mut LabelSelectionState| labels.has_selection());
    if copies && selected != Some(true) {
        app.copy_picture(ctx);
    }
    if escape {
        app.help = false;
        app.batch.close();
    }
}
