//! The left panel: scene, methods and their parameters.

mod methods;

use super::app::App;
use crate::config::load_scene;
use crate::live::State;
use eframe::egui;

/// Draws the panel.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    scene(app, ui);
    let [a, b] = &mut app.state.methods;
    ui.separator();
    methods::draw(ui, "Method A", a);
    ui.separator();
    methods::draw(ui, "Method B", b);
}

fn scene(app: &mut App, ui: &mut egui::Ui) {
    let label = ui.label("Scene");
    let name = app.state.scene.name.clone();
    let mut chosen = None;
    egui::ComboBox::from_id_salt("scene")
        .selected_text(name)
        .width(ui.available_width() - 8.0)
        .show_ui(ui, |ui| {
            for path in &app.scenes {
                let name = path.file_stem().unwrap_or_default().to_string_lossy();
                let current = app.scene_file.as_ref() == Some(path);
                if ui.selectable_label(current, name).clicked() {
                    chosen = Some(path.clone());
                }
            }
        })
        .response
        .labelled_by(label.id);
    let Some(path) = chosen else {
        return;
    };
    match load_scene(&path) {
        Ok(scene) => {
            app.state = State {
                scene,
                ..app.state.clone()
            };
            app.scene_file = Some(path);
        }
        Err(error) => app.banners.say(error.to_string()),
    }
}
