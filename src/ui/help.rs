//! Every key, as a window.

use super::app::App;
use super::{menu, view};
use eframe::egui;

/// Keys and what they do.
pub type Keys = &'static [(&'static str, &'static str)];

/// One table a part of the window.
const TABLES: &[(&str, Keys)] = &[("Pictures", view::KEYS), ("Files and changes", menu::KEYS)];

/// Draws the window while it is open.
pub fn draw(app: &mut App, ctx: &egui::Context) {
    let mut open = app.help;
    egui::Window::new("Keys")
        .open(&mut open)
        .collapsible(false)
        .auto_sized()
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(ctx, |ui| {
            let height = ctx.content_rect().height() - 80.0;
            let scroll = egui::ScrollArea::vertical().max_height(height);
            scroll.show(ui, tables);
        });
    app.help = open;
}

fn tables(ui: &mut egui::Ui) {
    for (title, keys) in TABLES {
        ui.strong(*title);
        egui::Grid::new(title).num_columns(2).show(ui, |ui| {
            for (key, what) in *keys {
                ui.monospace(*key);
                ui.label(*what);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
    }
}
