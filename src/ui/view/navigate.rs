//! Moves camera and sun by gestures and keys. All pictures show one scene: they move together.

use crate::live::Where;
use crate::scene::ImageSize;
use crate::ui::app::App;
use crate::ui::probe;
use eframe::egui::{self, Key, PointerButton, Pos2, Rect, Response};

/// Speed with Shift.
const FASTER: f64 = 5.0;
/// Degrees of an orbit while the pointer crosses the picture's height.
const ORBIT_DEG: f64 = 180.0;
/// Degrees that the sun moves for the same drag.
const SUN_DEG: f64 = 90.0;
/// Paces that the camera slides for the same drag.
const SLIDE_PACES: f64 = 4.0;
/// Paces per point of the wheel.
const WHEEL_PACES: f64 = 1.0 / 160.0;
/// Longest frame time that counts for flying, seconds.
const LONGEST_S: f32 = 0.25;

/// Handles input on a picture that would fill `rect`.
pub fn act(app: &mut App, ui: &egui::Ui, response: &Response, rect: Rect) {
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    drag(app, ui, response, rect);
    if response.hovered() {
        wheel(app, ui);
    }
    if response.has_focus() {
        let arrows = egui::EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..Default::default()
        };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, arrows));
        fly(app, ui.ctx());
    }
    if let Some(pixel) = clicked(app, ui, response, rect) {
        probe::ask(app, Where::Pixel(pixel));
    }
}

/// The pixel that was clicked; by keyboard the middle one.
fn clicked(app: &App, ui: &egui::Ui, response: &Response, rect: Rect) -> Option<[u32; 2]> {
    if !response.clicked() {
        return None;
    }
    let at = if response.clicked_by(PointerButton::Primary) {
        response.interact_pointer_pos()?
    } else if ui.input(|i| i.key_pressed(Key::Space)) {
        return None;
    } else {
        rect.center()
    };
    Some(pixel(at, rect, app.state.image))
}

/// The pixel at a place of the picture.
pub fn pixel(at: Pos2, rect: Rect, image: ImageSize) -> [u32; 2] {
    let share = (at - rect.min) / rect.size();
    let index = |share: f32, size: u32| {
        let index = (f64::from(share) * f64::from(size)).floor();
        (index.max(0.0) as u32).min(size.saturating_sub(1))
    };
    [index(share.x, image.width), index(share.y, image.height)]
}

fn drag(app: &mut App, ui: &egui::Ui, response: &Response, rect: Rect) {
    let delta = response.drag_delta();
    if delta == egui::Vec2::ZERO || rect.height() <= 0.0 {
        return;
    }
    let [x, y] = [delta.x, delta.y].map(|d| f64::from(d / rect.height()));
    let scene = &mut app.state.scene;
    let modifiers = ui.input(|i| i.modifiers);
    let orbits = modifiers.alt || response.dragged_by(PointerButton::Middle);
    if modifiers.command || modifiers.ctrl {
        scene.sun = scene.sun.dragged(x * SUN_DEG, -y * SUN_DEG);
    } else if orbits {
        scene.camera = scene.camera.orbited(-x * ORBIT_DEG, y * ORBIT_DEG);
    } else if response.dragged_by(PointerButton::Secondary) {
        let slide_m = SLIDE_PACES * scene.pace_m();
        scene.camera = scene.camera.moved([-x * slide_m, y * slide_m, 0.0]);
    } else {
        // The direction under the pointer stays there.
        let fov_deg = scene.camera.fov_y_deg;
        scene.camera = scene.camera.turned(-x * fov_deg, y * fov_deg);
    }
}

fn wheel(app: &mut App, ui: &egui::Ui) {
    let (points, faster) = ui.input(|i| {
        let turned = i.smooth_scroll_delta();
        (f64::from(turned.x + turned.y), i.modifiers.shift)
    });
    if points != 0.0 {
        let scene = &mut app.state.scene;
        let pace_m = scene.pace_m() * if faster { FASTER } else { 1.0 };
        let forward_m = points * WHEEL_PACES * pace_m;
        scene.camera = scene.camera.moved([0.0, 0.0, forward_m]);
    }
}

/// Flies as long as keys are held.
pub fn fly(app: &mut App, ctx: &egui::Context) {
    let (direction, seconds, faster) = ctx.input(|i| {
        let any = |keys: &[Key]| f64::from(u8::from(keys.iter().any(|k| i.key_down(*k))));
        let direction = [
            any(&[Key::D, Key::ArrowRight]) - any(&[Key::A, Key::ArrowLeft]),
            any(&[Key::E]) - any(&[Key::Q]),
            any(&[Key::W, Key::ArrowUp]) - any(&[Key::S, Key::ArrowDown]),
        ];
        let plain = !(i.modifiers.ctrl || i.modifiers.command || i.modifiers.alt);
        let direction = if plain { direction } else { [0.0; 3] };
        let seconds = f64::from(i.stable_dt.min(LONGEST_S));
        (direction, seconds, i.modifiers.shift)
    });
    if direction == [0.0; 3] {
        return;
    }
    let scene = &mut app.state.scene;
    let way_m = scene.pace_m() * seconds * if faster { FASTER } else { 1.0 };
    scene.camera = scene.camera.moved(direction.map(|d| d * way_m));
    ctx.request_repaint();
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{pos2, vec2};

    #[test]
    fn pixels_are_those_under_the_pointer_and_never_outside() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(64.0, 36.0));
        let image = ImageSize {
            width: 320,
            height: 180,
        };
        assert_eq!(pixel(pos2(10.0, 20.0), rect, image), [0, 0]);
        assert_eq!(pixel(pos2(42.1, 38.1), rect, image), [160, 90]);
        assert_eq!(pixel(pos2(500.0, -3.0), rect, image), [319, 0]);
        let nothing = Rect::from_min_size(pos2(10.0, 20.0), vec2(0.0, 0.0));
        let [x, y] = pixel(pos2(11.0, 21.0), nothing, image);
        assert!(x < 320 && y < 180);
    }
}
