//! The middle of the window: the pictures.

use super::app::{App, Slot};
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
    /// Every way, in the order of the bar.
    pub const ALL: [Self; 7] = [
        Self::Single,
        Self::Split,
        Self::SideBySide,
        Self::Grid,
        Self::Flicker,
        Self::Difference,
        Self::Truth,
    ];

    /// Its name on the bar.
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

    /// Can it be drawn without the truth?
    pub fn needs_truth(self) -> bool {
        matches!(self, Self::Difference | Self::Truth)
    }
}

/// What the middle remembers between frames.
#[derive(Clone, Debug)]
pub struct Pane {
    /// Place of the divider of [`Mode::Split`], 0…1.
    pub divider: f32,
    /// Method whose light map is open.
    pub map: Option<usize>,
}

impl Default for Pane {
    fn default() -> Self {
        Self {
            divider: 0.5,
            map: None,
        }
    }
}

impl Pane {
    /// Index of the method whose light map is wanted.
    pub fn map_of(&self) -> Option<usize> {
        self.map
    }
}

/// Draws the bar and the pictures.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    ui.horizontal(|ui| {
        for mode in Mode::ALL {
            ui.selectable_value(&mut app.mode, mode, mode.name());
        }
    });
    let slot = if app.mode == Mode::Truth {
        Slot::Truth
    } else {
        Slot::Side(0)
    };
    if let Some(picture) = app.shown.picture(slot) {
        let image = egui::Image::new(&picture.texture)
            .fit_to_exact_size(ui.available_size())
            .maintain_aspect_ratio(true);
        ui.add(image);
    } else {
        ui.spinner();
    }
}
