//! The bar over the pictures.

use super::{Mode, choose, play};
use crate::ui::app::App;
use crate::ui::lower::{self, Lower};
use eframe::egui;

/// Draws the bar.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    ui.horizontal_wrapped(|ui| {
        for (i, mode) in Mode::ALL.into_iter().enumerate() {
            let chosen = ui.selectable_label(app.mode == mode, mode.name());
            let hint = format!("{} (key {})", explained(mode), i + 1);
            if chosen.on_hover_text(hint).clicked() {
                choose(app, mode);
            }
        }
        ui.separator();
        if app.mode == Mode::Flicker {
            flicker(app, ui);
            ui.separator();
        }
        let playing = if app.play.is_some() { "Pause" } else { "Play" };
        let hint = format!("{} (key P)", play::EXPLAINED);
        if ui.button(playing).on_hover_text(hint).clicked() {
            play::toggle(app, ui.ctx());
        }
        for tab in Lower::ALL {
            let open = app.pane.lower == Some(tab);
            let button = ui.selectable_label(open, tab.name());
            if button.on_hover_text(tab.explained()).clicked() {
                match open {
                    true => app.pane.lower = None,
                    false => lower::open(app, tab),
                }
            }
        }
    });
}

fn flicker(app: &mut App, ui: &mut egui::Ui) {
    ui.checkbox(&mut app.pane.flicker.by_itself, "Every second")
        .on_hover_text(
            "A and B in turn by themselves; without, the space bar or the button turns.",
        );
    let flip = ui
        .button("Flip")
        .on_hover_text("Show the other (key Space)");
    if flip.clicked() {
        let now_s = ui.input(|i| i.time);
        app.pane.flicker.flip(now_s);
    }
}

fn explained(mode: Mode) -> &'static str {
    match mode {
        Mode::Single => "Method A alone",
        Mode::Split => "A left of a divider, B right of it",
        Mode::SideBySide => "A and B side by side",
        Mode::Grid => "Every method, and the truth",
        Mode::Flicker => "A and B in turn",
        Mode::Difference => "The signed difference of A from the truth",
        Mode::Truth => "The truth alone",
    }
}
