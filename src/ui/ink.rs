//! The colour of a method on the window's background.

use crate::report::style::Style;
use eframe::egui::{self, Color32};

/// Share of white in a dark colour on a dark background.
const LIFT: f32 = 0.5;
/// Colours up to this luminance (of 255) are lifted.
const DARK: f32 = 110.0;

/// The colour of charts and pages; dark ones lighter where the window is dark, black as white.
pub fn ink(method: &str, visuals: &egui::Visuals) -> Color32 {
    let (r, g, b) = Style::of(method).rgb;
    let [red, green, blue] = [r, g, b].map(f32::from);
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    if !visuals.dark_mode || luminance > DARK {
        return Color32::from_rgb(r, g, b);
    }
    let share = if luminance == 0.0 { 1.0 } else { LIFT };
    let [r, g, b] = [red, green, blue].map(|c| (c + share * (255.0 - c)).round() as u8);
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dark_windows_lighten_dark_colours_only() {
        let (light, dark) = (egui::Visuals::light(), egui::Visuals::dark());
        assert_eq!(ink("truth", &light), Color32::BLACK);
        assert_eq!(ink("truth", &dark), Color32::WHITE);
        assert_eq!(ink("none", &dark), ink("none", &light));
        assert_ne!(ink("srm", &dark), ink("srm", &light));
    }
}
