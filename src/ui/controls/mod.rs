//! The left panel: scene, methods and their parameters.

mod methods;
mod scene;

use super::app::App;
use eframe::egui;

/// Draws the panel.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    let [a, b] = &mut app.state.methods;
    methods::draw(ui, "Method A", a);
    ui.separator();
    methods::draw(ui, "Method B", b);
    ui.separator();
    scene::draw(app, ui);
}
