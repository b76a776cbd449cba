//! Plays the sun of a day, one hour a second.

use crate::ui::app::App;
use eframe::egui;

/// State of playing.
#[derive(Clone, Copy, Debug)]
pub struct Play {
    /// When the sun moved last, seconds of the window's clock.
    since_s: f64,
}

/// Hours of the day in a second of the window's clock.
const HOURS_A_SECOND: f64 = 1.0;
/// Largest move of the sun from picture to picture, hours.
const LONGEST_H: f64 = 0.5;
/// Smallest move, hours: smaller ones are not visible.
const SHORTEST_H: f64 = 1.0 / 60.0;

/// Help text of the button.
pub const EXPLAINED: &str = "The sun turns about the horizontal axis +z, 15° an hour, an hour a second, and jumps from \
     sunset to sunrise. It waits for the first picture of every place, and moves half an hour at most between two.";

/// Starts or stops.
pub fn toggle(app: &mut App, ctx: &egui::Context) {
    let since_s = ctx.input(|i| i.time);
    app.play = match app.play {
        Some(_) => None,
        None => Some(Play { since_s }),
    };
}

/// Moves the sun, if the picture before is there; the worker wakes the window when it is.
pub fn advance(app: &mut App, ctx: &egui::Context) {
    let Some(play) = &mut app.play else {
        return;
    };
    if !app.shown.has_first() {
        return;
    }
    let now_s = ctx.input(|i| i.time);
    let hours = ((now_s - play.since_s) * HOURS_A_SECOND).min(LONGEST_H);
    if hours < SHORTEST_H {
        ctx.request_repaint();
        return;
    }
    play.since_s = now_s;
    app.state.scene.sun = app.state.scene.sun.later(hours);
}
