//! Banner across the window: problems that persist.

use eframe::egui;

/// The lines that are shown now, by what they are about.
#[derive(Default)]
pub struct Banners {
    shaders: Option<String>,
    said: Option<String>,
}

impl Banners {
    /// Shaders on disk were taken over, or refused.
    pub fn shaders(&mut self, outcome: Result<(), String>) {
        self.shaders = outcome.err();
    }

    /// Something failed; the next one replaces it.
    pub fn say(&mut self, message: String) {
        self.said = Some(message);
    }

    /// Both, without decoration.
    pub fn text(&self) -> String {
        let both = [&self.shaders, &self.said];
        both.into_iter()
            .flatten()
            .cloned()
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// Draws what there is.
    pub fn draw(&mut self, ui: &mut egui::Ui) {
        if let Some(problem) = &self.shaders {
            let colour = ui.visuals().error_fg_color;
            let what = "The shaders on disk do not compile; the ones before are in use.";
            ui.colored_label(colour, what);
            // The compiler points into lines, with signs that only this font has.
            ui.label(egui::RichText::new(problem).monospace().color(colour));
        }
        let Some(said) = &self.said else {
            return;
        };
        let closed = ui.horizontal_wrapped(|ui| {
            ui.colored_label(ui.visuals().error_fg_color, said);
            ui.small_button("Close").clicked()
        });
        if closed.inner {
            self.said = None;
        }
    }
}
