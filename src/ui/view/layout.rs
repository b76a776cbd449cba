//! Layout of the pictures in each mode.

use super::caption::{self, A};
use super::{Mode, Subject, colour_bar, picture};
use crate::frame::FALSE_COLOUR_STOPS;
use crate::metrics::DIFF_SCALE;
use crate::occlusion::{MethodInfo, REGISTRY};
use crate::scene::ImageSize;
use crate::ui::app::{App, Slot};
use eframe::egui::{self, Key, Rect, Role, Sense, pos2, vec2};
use std::time::Duration;

/// Between two pictures, points.
const GAP: f32 = 6.0;
/// Width of the divider where it can be taken, points.
const HANDLE: f32 = 12.0;
/// Height of the colour bar and its numbers, points.
const SCALE: f32 = 38.0;
/// Steps of the divider by keyboard: small, and with Shift.
const STEPS: [f32; 2] = [0.01, 0.1];

/// Draws the pictures of the chosen mode.
pub fn draw(app: &mut App, ui: &mut egui::Ui, area: Rect) {
    match app.mode {
        Mode::Single => picture::draw(app, ui, Subject::Slot(A), area),
        Mode::Truth => picture::draw(app, ui, Subject::Slot(Slot::Truth), area),
        Mode::Split => split(app, ui, area),
        Mode::SideBySide => side_by_side(app, ui, area),
        Mode::Grid => grid(app, ui, area),
        Mode::Flicker => flicker(app, ui, area),
        Mode::Difference => difference(app, ui, area),
    }
}

/// Both halves of an area with a gap between.
fn halves(area: Rect) -> [Rect; 2] {
    let half = (GAP / 2.0).min(area.width() / 2.0);
    let (left, right) = area.split_left_right_at_fraction(0.5);
    [
        left.with_max_x(left.right() - half),
        right.with_min_x(right.left() + half),
    ]
}

fn side_by_side(app: &mut App, ui: &mut egui::Ui, area: Rect) {
    for (side, half) in halves(area).into_iter().enumerate() {
        picture::draw(app, ui, Subject::Slot(Slot::Side(side)), half);
    }
}

fn flicker(app: &mut App, ui: &mut egui::Ui, area: Rect) {
    let now_s = ui.input(|i| i.time);
    if let Some(wait_s) = app.pane.flicker.advance(now_s) {
        let wait = Duration::from_secs_f64(wait_s.max(0.0));
        ui.ctx().request_repaint_after(wait);
    }
    let side = app.pane.flicker.side;
    picture::draw(app, ui, Subject::Slot(Slot::Side(side)), area);
}

fn split(app: &mut App, ui: &mut egui::Ui, area: Rect) {
    let (strip, rect) = picture::arranged(area, app.state.image);
    let x = rect.left() + app.pane.divider.clamp(0.0, 1.0) * rect.width();
    let parts = [rect.with_max_x(x), rect.with_min_x(x)];
    for (side, (strip, part)) in halves(strip).into_iter().zip(parts).enumerate() {
        let subject = Subject::Slot(Slot::Side(side));
        caption::draw(app, ui, subject, strip);
        picture::show(app, ui, subject, rect, part);
    }
    if picture::has_room(rect) {
        divider(app, ui, rect, x);
    }
}

fn divider(app: &mut App, ui: &mut egui::Ui, rect: Rect, x: f32) {
    let handle = Rect::from_center_size(pos2(x, rect.center().y), vec2(HANDLE, rect.height()));
    let response = ui
        .interact(
            handle,
            ui.scope_id().with("divider"),
            Sense::click_and_drag(),
        )
        .on_hover_and_drag_cursor(egui::CursorIcon::ResizeHorizontal);
    if let Some(at) = response
        .interact_pointer_pos()
        .filter(|_| response.dragged())
    {
        app.pane.divider = ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
    }
    if response.clicked() {
        response.request_focus();
    }
    if response.has_focus() {
        let arrows = egui::EventFilter {
            horizontal_arrows: true,
            ..Default::default()
        };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, arrows));
        let by: f32 = ui.input(|i| i.events.iter().map(step).sum());
        app.pane.divider = (app.pane.divider + by).clamp(0.0, 1.0);
    }
    let place = f64::from(app.pane.divider);
    response.widget_info(|| {
        let mut info = egui::WidgetInfo::slider(true, place, "divider between A and B");
        info.role = Role::Splitter;
        info
    });
    let painter = ui.painter_at(rect.expand2(vec2(HANDLE, 0.0)));
    let active = response.hovered() || response.dragged() || response.has_focus();
    for (width, color) in [
        (if active { 5.0 } else { 3.0 }, egui::Color32::BLACK),
        (if active { 3.0 } else { 1.0 }, egui::Color32::WHITE),
    ] {
        painter.vline(x, rect.y_range(), egui::Stroke::new(width, color));
    }
}

/// Change of the divider by a key.
fn step(event: &egui::Event) -> f32 {
    let egui::Event::Key {
        key,
        pressed: true,
        modifiers,
        ..
    } = event
    else {
        return 0.0;
    };
    let step = STEPS[usize::from(modifiers.shift)];
    match key {
        Key::ArrowLeft => -step,
        Key::ArrowRight => step,
        _ => 0.0,
    }
}

/// Subjects of the grid: every method in the order of the registry; A as A.
fn cells(app: &App) -> Vec<Subject> {
    let a = app.state.methods[0].method.info();
    let slot = |(i, info): (usize, &MethodInfo)| match info.id {
        _ if info.is_truth() => Slot::Truth,
        id if id == a.id => A,
        _ => Slot::Grid(i),
    };
    let infos = REGISTRY.iter().map(|method| method.info());
    let mut cells: Vec<_> = infos.enumerate().map(slot).map(Subject::Slot).collect();
    // The truth may have been chosen as A.
    if a.is_truth() {
        cells.push(Subject::Slot(A));
    }
    cells
}

/// Columns with which `count` pictures become largest.
fn columns(count: usize, area: Rect, image: ImageSize) -> usize {
    let size = |columns: usize| {
        let cell = cell(0, columns, count, area);
        let (_, rect) = picture::arranged(cell, image);
        rect.width()
    };
    let better = |best: usize, columns| {
        if size(columns) > size(best) {
            columns
        } else {
            best
        }
    };
    (1..=count).fold(1, better)
}

fn cell(index: usize, columns: usize, count: usize, area: Rect) -> Rect {
    let rows = count.div_ceil(columns);
    let size = area.size() / vec2(columns as f32, rows as f32);
    let at = vec2((index % columns) as f32, (index / columns) as f32);
    let rect = Rect::from_min_size(area.min + at * size, size);
    let gap = (GAP / 2.0).min(size.min_elem() / 4.0);
    rect.shrink(gap)
}

fn grid(app: &mut App, ui: &mut egui::Ui, area: Rect) {
    let cells = cells(app);
    let columns = columns(cells.len(), area, app.state.image);
    for (i, subject) in cells.iter().enumerate() {
        let cell = cell(i, columns, cells.len(), area);
        let (strip, rect) = picture::arranged(cell, app.state.image);
        caption::draw_short(app, ui, *subject, strip);
        picture::show(app, ui, *subject, rect, rect);
    }
}

fn difference(app: &mut App, ui: &mut egui::Ui, area: Rect) {
    let above = area.with_max_y((area.bottom() - SCALE).max(area.top()));
    picture::draw(app, ui, Subject::Difference, above);
    let (_, rect) = picture::arranged(above, app.state.image);
    let labels = [
        (-1.0, format!("−{DIFF_SCALE} (too dark)")),
        (0.0, "0, in mean sun-lit luminance".to_owned()),
        (1.0, format!("+{DIFF_SCALE} (too bright)")),
    ];
    let bar = area.with_min_y((rect.bottom() + GAP).min(area.bottom()));
    colour_bar::draw(ui, bar, &FALSE_COLOUR_STOPS, &labels);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_uses_the_room_there_is() {
        let image = ImageSize {
            width: 320,
            height: 180,
        };
        let room = |w, h| Rect::from_min_size(pos2(0.0, 0.0), vec2(w, h));
        assert_eq!(columns(7, room(2000.0, 300.0), image), 7);
        assert_eq!(columns(7, room(300.0, 2000.0), image), 1);
        assert_eq!(columns(7, room(0.0, 0.0), image), 1);
        let last = cell(6, 3, 7, room(900.0, 600.0));
        assert!(room(900.0, 600.0).contains_rect(last));
    }
}
