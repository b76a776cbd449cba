//! The right panel: times, memory and error numbers.

use super::app::{App, Slot};
use eframe::egui;

/// Draws the panel.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    ui.label(&app.adapter);
    ui.checkbox(&mut app.want_truth, "Truth and errors");
    ui.checkbox(&mut app.repeat, "Measure again and again");
    if let Some(latency_ms) = app.shown.latency_ms {
        ui.label(format!("input to picture {latency_ms:.0} ms"));
    }
    if let Some((times, memory)) = app.shown.picture(Slot::Side(0)).and_then(|p| p.drawn.cost) {
        ui.label(format!("{times:?} {memory:?}"));
    }
    if let Some((compared, current)) = app.shown.compared(Slot::Side(0)) {
        match &compared.result {
            Ok((comparison, _)) => ui.label(format!("{current} {:?}", comparison.error)),
            Err(problem) => ui.label(problem),
        };
    }
}
