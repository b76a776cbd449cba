//! What is looked at: scene, sun, clouds, medium, sampling of view rays, size of the picture.

use crate::config::load_scene;
use crate::density::ControlValue;
use crate::scene::{ImageSize, March, Scene};
use crate::ui::app::App;
use eframe::egui;

/// Image sizes on offer: 16:9, up to that of a large screen.
const SIZES: [[u32; 2]; 6] = [
    [160, 90],
    [320, 180],
    [640, 360],
    [960, 540],
    [1280, 720],
    [1920, 1080],
];

/// Draws the drop-down of scenes and everything that can change in the chosen one.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    choose(app, ui);
    size(ui, &mut app.state.image);
    let scene = &mut app.state.scene;
    section(ui, "Sun", true, |ui| sun(ui, scene));
    section(ui, "Clouds", true, |ui| clouds(ui, scene));
    section(ui, "View rays", false, |ui| march(ui, &mut scene.march));
    if let Err(problem) = scene.validate() {
        let text = format!("{}: {}", problem.pointer, problem.message);
        ui.colored_label(ui.visuals().error_fg_color, text);
    }
}

fn choose(app: &mut App, ui: &mut egui::Ui) {
    let label = ui.label("Scene");
    let mut chosen = None;
    egui::ComboBox::from_id_salt("scene")
        .selected_text(&app.state.scene.name)
        .width(ui.available_width() - 8.0)
        .truncate()
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
            app.state.scene = scene;
            app.scene_file = Some(path);
        }
        Err(error) => app.banners.say(error.to_string()),
    }
}

fn size(ui: &mut egui::Ui, image: &mut ImageSize) {
    ui.horizontal(|ui| {
        let label = ui.label("Picture");
        egui::ComboBox::from_id_salt("picture size")
            .selected_text(format!("{} × {}", image.width, image.height))
            .show_ui(ui, |ui| {
                for [width, height] in SIZES {
                    let size = ImageSize { width, height };
                    ui.selectable_value(image, size, format!("{width} × {height}"));
                }
            })
            .response
            .labelled_by(label.id)
            .on_hover_text("Size of exact pictures: what is measured. The window scales it.");
    });
}

fn section(ui: &mut egui::Ui, title: &str, open: bool, add: impl FnOnce(&mut egui::Ui)) {
    egui::CollapsingHeader::new(title)
        .default_open(open)
        .show(ui, |ui| {
            egui::Grid::new(title).num_columns(2).show(ui, add);
        });
}

/// One labelled number in a grid of two columns.
fn number<N: egui::emath::Numeric>(
    ui: &mut egui::Ui,
    name: &str,
    doc: &str,
    value: &mut N,
    range: std::ops::RangeInclusive<N>,
    unit: &str,
) {
    let label = ui.label(name).on_hover_text(doc);
    let speed = ((range.end().to_f64() - range.start().to_f64()) / 500.0).min(1.0);
    let drag = egui::DragValue::new(value)
        .range(range)
        .speed(speed)
        .suffix(unit);
    ui.add(drag).labelled_by(label.id).on_hover_text(doc);
    ui.end_row();
}

fn sun(ui: &mut egui::Ui, scene: &mut Scene) {
    let sun = &mut scene.sun;
    let doc = "Above the horizon. Or hold Ctrl and drag the picture.";
    number(
        ui,
        "elevation",
        doc,
        &mut sun.elevation_deg,
        0.1..=90.0,
        "°",
    );
    let doc = "Toward the sun: 0 is +x, 90 is +z.";
    number(
        ui,
        "azimuth",
        doc,
        &mut sun.azimuth_deg,
        -360.0..=360.0,
        "°",
    );
}

fn clouds(ui: &mut egui::Ui, scene: &mut Scene) {
    for control in scene.density.field_mut().controls() {
        let (name, doc, unit) = (&control.name, control.doc, control.unit);
        match control.value {
            ControlValue::Real(value, range) => number(ui, name, doc, value, range, unit),
            ControlValue::Whole(value, range) => number(ui, name, doc, value, range, unit),
        }
    }
    let medium = &mut scene.medium;
    let doc = "Extinction at density 1. Water cloud: 0.04–0.06 (OPAC, Hess et al. 1998).";
    let extinction = &mut medium.extinction_per_m;
    number(ui, "extinction", doc, extinction, 0.0..=1.0, " /m");
    let doc = "Single-scattering albedo.";
    number(ui, "albedo", doc, &mut medium.albedo, 0.0..=1.0, "");
}

fn march(ui: &mut egui::Ui, march: &mut March) {
    match &mut march.step_m {
        Some(step_m) => {
            let doc = "Length of a step of the view rays.";
            number(ui, "step", doc, step_m, 1e-3..=1e4, " m");
        }
        None => {
            let doc = "Samples of a view ray inside the layer.";
            let all = 1..=March::MAX_STEPS;
            number(ui, "steps", doc, &mut march.steps, all, "");
        }
    }
    let doc = "Each pixel starts its ray at its own fraction of a step: noise instead of bands.";
    let label = ui.label("jitter").on_hover_text(doc);
    ui.checkbox(&mut march.jitter, "")
        .labelled_by(label.id)
        .on_hover_text(doc);
    ui.end_row();
}
