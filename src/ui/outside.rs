//! Access to the window's content from outside.

use super::app::{App, Slot};
use super::view::Mode;
use crate::live::{Drawn, State};
use eframe::egui;

impl App {
    /// What is looked at.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// How it is compared.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Compares in another way.
    pub fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
    }

    /// Text of the banner; empty when there is none.
    pub fn messages(&self) -> String {
        self.banners.text()
    }

    /// Is everything that was asked for on the screen?
    pub fn is_done(&self) -> bool {
        self.shown.done
    }

    /// The picture of the method A or B (0, 1), and the texture that shows it.
    pub fn picture(&self, side: usize) -> Option<(&Drawn, egui::TextureId)> {
        self.shown(Slot::Side(side))
    }

    /// The picture of the truth, and the texture that shows it.
    pub fn truth(&self) -> Option<(&Drawn, egui::TextureId)> {
        self.shown(Slot::Truth)
    }

    fn shown(&self, slot: Slot) -> Option<(&Drawn, egui::TextureId)> {
        let picture = self.shown.picture(slot)?;
        Some((&picture.drawn, picture.texture.id()))
    }
}
