//! The panel under the pictures: curves along a light column, or a light map.

use super::app::App;
use super::{map, probe};
use eframe::egui;

/// Content of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Lower {
    /// T(d) along a light column.
    Probe,
    /// The light map of a method.
    Map,
}

/// Largest share of the window's height.
const MOST: f32 = 0.6;
/// Smallest height where there is room for it, points.
const LEAST: f32 = 140.0;

impl Lower {
    /// All tabs, in the order of the bar.
    pub const ALL: [Self; 2] = [Self::Probe, Self::Map];

    /// Name on the bar.
    pub fn name(self) -> &'static str {
        match self {
            Self::Probe => "Probe",
            Self::Map => "Light map",
        }
    }

    /// Help text of the tab.
    pub fn explained(self) -> &'static str {
        match self {
            Self::Probe => "Transmittance of every method along the light through a clicked pixel",
            Self::Map => "What the light map of A or B holds",
        }
    }
}

/// Draws the panel if it is open.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    let Some(lower) = app.pane.lower else {
        return;
    };
    let most = (ui.available_height() * MOST).max(1.0);
    egui::Panel::bottom("lower")
        .default_size(260.0)
        .size_range(LEAST.min(most)..=most)
        .resizable(true)
        .show(ui, |ui| match lower {
            Lower::Probe => probe::draw(app, ui),
            Lower::Map => map::draw(app, ui),
        });
}

/// Opens a tab; that of light maps on a side that has one.
pub fn open(app: &mut App, lower: Lower) {
    let has_map = |side: usize| {
        let setup = &app.state.methods[side];
        let plan = setup.method.plan(&setup.params);
        plan.is_ok_and(|plan| plan.map_values().is_some())
    };
    let side = app.pane.map_side.min(1);
    if lower == Lower::Map && !has_map(side) && has_map(1 - side) {
        app.pane.map_side = 1 - side;
    }
    app.pane.lower = Some(lower);
}

/// The tabs, at the start of the first line of either.
pub fn tabs(app: &mut App, ui: &mut egui::Ui) {
    for lower in Lower::ALL {
        let chosen = app.pane.lower == Some(lower);
        let tab = ui.selectable_label(chosen, lower.name());
        if tab.on_hover_text(lower.explained()).clicked() {
            open(app, lower);
        }
    }
    let close = ui.small_button("Close");
    if close.on_hover_text("Close this panel").clicked() {
        app.pane.lower = None;
    }
    ui.separator();
}
