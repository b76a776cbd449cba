//! One picture on the screen.

use super::caption;
use super::{Mode, Subject, navigate};
use crate::live::Where;
use crate::scene::ImageSize;
use crate::ui::app::App;
use eframe::egui::{self, Color32, Rect, Role, Sense, Stroke, pos2, vec2};

/// Height of a caption, points.
const CAPTION: f32 = 20.0;
/// Arm of the cross at a probed pixel, points.
const ARM: f32 = 6.0;
/// Smaller pictures are not drawn, points.
const LEAST: f32 = 2.0;

/// Whether there is room for a picture.
pub fn has_room(area: Rect) -> bool {
    area.is_finite() && area.width() >= LEAST && area.height() >= LEAST
}

/// Where a caption and a picture under it go in an area: (strip, picture).
pub fn arranged(area: Rect, image: ImageSize) -> (Rect, Rect) {
    let y = (area.top() + CAPTION).min(area.bottom());
    let rect = fitted(area.with_min_y(y), image);
    let strip = area.with_max_y(rect.top());
    (strip.with_min_y(rect.top() - (y - area.top())), rect)
}

/// The largest rectangle of the picture's shape, in the middle of an area.
fn fitted(area: Rect, image: ImageSize) -> Rect {
    let image = vec2(image.width.max(1) as f32, image.height.max(1) as f32);
    let room = area.size().max(vec2(0.0, 0.0));
    let scale = (room.x / image.x).min(room.y / image.y);
    Rect::from_center_size(area.center(), image * scale)
}

/// A picture under its caption.
pub fn draw(app: &mut App, ui: &mut egui::Ui, subject: Subject, area: Rect) {
    let (strip, rect) = arranged(area, app.state.image);
    caption::draw(app, ui, subject, strip);
    show(app, ui, subject, rect, rect);
}

/// The `visible` part of a picture that would fill `rect`.
pub fn show(app: &mut App, ui: &mut egui::Ui, subject: Subject, rect: Rect, visible: Rect) {
    if !has_room(visible) {
        return;
    }
    // Flicker must not end a drag: both sides are one widget.
    let place = (app.mode != Mode::Flicker).then_some(subject);
    let id = ui.scope_id().with(("picture", place));
    let response = ui.interact(visible, id, Sense::click_and_drag());
    let name = format!("picture {}", caption::name(app, subject));
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, &name));
    let painter = ui.painter_at(visible);
    match texture(app, subject) {
        Some(texture) => {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture, rect, whole, Color32::WHITE);
        }
        None => missing(app, ui, subject, visible),
    }
    if let Some(Where::Pixel(pixel)) = app.asked_here() {
        cross(&painter, rect, app.state.image, pixel);
    }
    if response.has_focus() {
        let stroke = ui.visuals().selection.stroke;
        painter.rect_stroke(visible, 0.0, stroke, egui::StrokeKind::Inside);
    }
    navigate::act(app, ui, &response, rect);
}

fn texture(app: &App, subject: Subject) -> Option<egui::TextureId> {
    match subject {
        Subject::Slot(slot) => app.shown.picture(slot).map(|p| p.texture.id()),
        Subject::Difference => {
            let (compared, _) = app.shown.compared(caption::A)?;
            let (_, texture) = compared.result.as_ref().ok()?;
            Some(texture.id())
        }
    }
}

/// An empty frame that says why it is empty.
fn missing(app: &App, ui: &mut egui::Ui, subject: Subject, visible: Rect) {
    let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter()
        .rect_stroke(visible, 0.0, stroke, egui::StrokeKind::Inside);
    let builder = egui::UiBuilder::new()
        .id_salt(("missing", subject))
        .max_rect(visible.shrink(LEAST))
        .layout(egui::Layout::centered_and_justified(
            egui::Direction::TopDown,
        ));
    let mut child = ui.new_child(builder);
    child.shrink_clip_rect(visible);
    let why = caption::missing(app, subject);
    child.add(
        egui::Label::new(why)
            .wrap()
            .selectable(false)
            .sense(Sense::empty()),
    );
}

/// A cross with a dark rim around a light one: seen on clouds and on sky.
fn cross(painter: &egui::Painter, rect: Rect, image: ImageSize, [x, y]: [u32; 2]) {
    let share = vec2(
        (x as f32 + 0.5) / image.width.max(1) as f32,
        (y as f32 + 0.5) / image.height.max(1) as f32,
    );
    let at = rect.min + share * rect.size();
    for (width, color) in [(3.0, Color32::BLACK), (1.0, Color32::WHITE)] {
        for arm in [vec2(ARM, 0.0), vec2(0.0, ARM)] {
            painter.line_segment([at - arm, at + arm], Stroke::new(width, color));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_keep_their_shape_in_any_room() {
        let image = ImageSize {
            width: 320,
            height: 180,
        };
        let room = |w, h| Rect::from_min_size(pos2(5.0, 5.0), vec2(w, h));
        let wide = fitted(room(1000.0, 180.0), image);
        assert_eq!(
            (wide.size(), wide.center()),
            (vec2(320.0, 180.0), room(1000.0, 180.0).center())
        );
        assert_eq!(fitted(room(160.0, 900.0), image).size(), vec2(160.0, 90.0));
        assert!(!has_room(fitted(room(0.0, 10.0), image)));
        assert!(!has_room(fitted(room(-3.0, -1.0), image)));
        let (strip, rect) = arranged(room(320.0, 400.0), image);
        assert_eq!((strip.height(), strip.bottom()), (CAPTION, rect.top()));
        let (strip, rect) = arranged(room(10.0, 5.0), image);
        assert_eq!((strip.height(), rect.height()), (5.0, 0.0));
    }
}
