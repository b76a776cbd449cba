//! Keys of the picture area: their table for the help, and their actions.

use super::{Mode, choose, play};
use crate::ui::app::App;
use eframe::egui::{self, Key, Modifiers};

/// Keys and gestures, and what they do.
pub const KEYS: &[(&str, &str)] = &[
    (
        "1 … 7",
        "Single, Split, A | B, Grid, Alternation, Difference, Truth",
    ),
    ("Space", "Flicker: show the other method"),
    ("P", "Play or pause the day"),
    ("W A S D, arrows", "Fly forward, left, back, right"),
    ("E, Q", "Fly up, down"),
    ("Shift", "Fly five times as fast"),
    ("Drag", "Turn the head"),
    ("Alt-drag, middle drag", "Orbit about the target"),
    ("Right drag", "Slide sideways, up and down"),
    ("Wheel", "Fly forward, back"),
    ("Ctrl-drag", "Move the sun"),
    (
        "Click",
        "Probe T(d) along the light through the cloud there",
    ),
    (
        "Enter",
        "Probe the middle of the picture that has the focus",
    ),
    (
        "Left, right",
        "Move the divider that has the focus; with Shift in larger steps",
    ),
];

const MODES: [Key; 7] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
];

/// Does what the pressed keys say, unless they are being typed into a field.
pub fn act(app: &mut App, ui: &egui::Ui) {
    let ctx = ui.ctx();
    if ctx.text_edit_focused() || !ui.is_enabled() {
        return;
    }
    for (mode, key) in Mode::ALL.into_iter().zip(MODES) {
        if pressed(ctx, key) {
            choose(app, mode);
        }
    }
    // Where something has the focus, the space bar is a click on it.
    let nothing_focused = ctx.memory(|m| m.focused().is_none());
    if app.mode == Mode::Flicker && nothing_focused && pressed(ctx, Key::Space) {
        let now_s = ctx.input(|i| i.time);
        app.pane.flicker.flip(now_s);
    }
    if pressed(ctx, Key::P) {
        play::toggle(app, ctx);
    }
    if nothing_focused {
        super::navigate::fly(app, ctx);
    }
}

fn pressed(ctx: &egui::Context, key: Key) -> bool {
    ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key))
}
