//! The middle of the window: a bar, and the pictures in one of seven arrangements.

mod bar;
mod caption;
pub mod colour_bar;
mod keys;
mod layout;
mod navigate;
mod picture;
mod play;

pub use keys::KEYS;
pub use play::Play;

use super::app::{App, Slot};
use super::lower::Lower;
use eframe::egui;

/// How pictures are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// A alone.
    #[default]
    Single,
    /// A left of a divider, B right of it.
    Split,
    /// A and B side by side.
    SideBySide,
    /// Every method.
    Grid,
    /// A and B in turn.
    Flicker,
    /// The signed difference of A from the truth.
    Difference,
    /// The truth alone.
    Truth,
}

impl Mode {
    /// Every arrangement, in the order of the bar.
    pub const ALL: [Self; 7] = [
        Self::Single,
        Self::Split,
        Self::SideBySide,
        Self::Grid,
        Self::Flicker,
        Self::Difference,
        Self::Truth,
    ];

    /// Name on the bar.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "Single",
            Self::Split => "Split",
            Self::SideBySide => "A | B",
            Self::Grid => "Grid",
            Self::Flicker => "Flicker",
            Self::Difference => "Difference",
            Self::Truth => "Truth",
        }
    }

    /// Is the method B on the screen?
    pub fn shows_b(self) -> bool {
        matches!(self, Self::Split | Self::SideBySide | Self::Flicker)
    }

    /// Does it show nothing without the truth?
    pub fn needs_truth(self) -> bool {
        matches!(self, Self::Difference | Self::Truth)
    }
}

/// State of the picture area between frames.
#[derive(Clone, Debug)]
pub struct Pane {
    /// Place of the divider of [`Mode::Split`], 0…1.
    pub divider: f32,
    /// What is open under the pictures.
    pub lower: Option<Lower>,
    /// The side, 0 or 1, whose light map is shown there.
    pub map_side: usize,
    /// State of [`Mode::Flicker`].
    pub flicker: Alternation,
}

/// A and B in turn.
#[derive(Clone, Copy, Debug)]
pub struct Alternation {
    /// The side on the screen.
    pub side: usize,
    /// The side changes once a second without a key.
    pub by_itself: bool,
    /// When it changed last, seconds of the window's clock.
    since_s: f64,
}

/// How long a side of [`Mode::Flicker`] stays, seconds.
const FLICKER_S: f64 = 1.0;

impl Default for Pane {
    fn default() -> Self {
        Self {
            divider: 0.5,
            lower: None,
            map_side: 0,
            flicker: Alternation {
                side: 0,
                by_itself: true,
                since_s: 0.0,
            },
        }
    }
}

impl Pane {
    /// Index of the method whose light map is wanted.
    pub fn map_of(&self) -> Option<usize> {
        (self.lower == Some(Lower::Map)).then_some(self.map_side)
    }
}

impl Alternation {
    /// Shows the other side.
    pub fn flip(&mut self, now_s: f64) {
        self.side = 1 - self.side.min(1);
        self.since_s = now_s;
    }

    /// Flips when it is due; returns the seconds until the next flip.
    fn advance(&mut self, now_s: f64) -> Option<f64> {
        if !self.by_itself {
            return None;
        }
        if now_s - self.since_s >= FLICKER_S {
            self.flip(now_s);
        }
        Some(FLICKER_S - (now_s - self.since_s))
    }
}

/// Subject of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Subject {
    /// What the worker drew for a slot.
    Slot(Slot),
    /// The method A minus the truth.
    Difference,
}

/// Draws the bar and the pictures.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    keys::act(app, ui);
    play::advance(app, ui.ctx());
    bar::draw(app, ui);
    let area = ui.available_rect_before_wrap();
    if !picture::has_room(area) {
        return;
    }
    ui.allocate_rect(area, egui::Sense::hover());
    layout::draw(app, ui, area);
}

/// Chooses an arrangement; the truth is rendered if it shows nothing without.
fn choose(app: &mut App, mode: Mode) {
    app.mode = mode;
    app.want_truth |= mode.needs_truth();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flicker_changes_once_a_second_unless_it_is_held() {
        let mut flicker = Pane::default().flicker;
        assert_eq!(flicker.advance(0.25), Some(0.75));
        assert_eq!((flicker.advance(1.5), flicker.side), (Some(1.0), 1));
        flicker.flip(1.75);
        assert_eq!((flicker.advance(2.0), flicker.side), (Some(0.75), 0));
        flicker.by_itself = false;
        assert_eq!((flicker.advance(9.0), flicker.side), (None, 0));
    }
}
