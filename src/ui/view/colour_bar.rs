//! A bar of colours with numbers under it.

use eframe::egui::{self, Align2, Color32, Mesh, Rect, Shape, pos2};

/// Height of the colours, points.
const COLOURS: f32 = 12.0;
/// The widest bar, points.
const WIDEST: f32 = 480.0;

/// Draws `stops`, positions from −1 to 1 and sRGB, across `area`, with `labels` from left to right at their positions.
/// Labels between the first and the last are left out where they do not fit.
pub fn draw(ui: &egui::Ui, area: Rect, stops: &[(f32, [u8; 3])], labels: &[(f32, String)]) {
    if !super::picture::has_room(area) {
        return;
    }
    let painter = ui.painter_at(area);
    let half = (area.width().min(WIDEST) / 2.0).floor();
    let colours = Rect::from_x_y_ranges(
        area.center().x - half..=area.center().x + half,
        area.top()..=(area.top() + COLOURS).min(area.bottom()),
    );
    let x = |position: f32| colours.center().x + position * half;
    let mut mesh = Mesh::default();
    for (position, [r, g, b]) in stops {
        let color = Color32::from_rgb(*r, *g, *b);
        mesh.colored_vertex(pos2(x(*position), colours.top()), color);
        mesh.colored_vertex(pos2(x(*position), colours.bottom()), color);
    }
    for i in 1..stops.len() as u32 {
        let left = 2 * (i - 1);
        mesh.add_triangle(left, left + 1, left + 2);
        mesh.add_triangle(left + 1, left + 2, left + 3);
    }
    painter.add(Shape::mesh(mesh));
    let color = ui.visuals().text_color();
    let font = egui::TextStyle::Body.resolve(ui.style());
    let last = labels.len().saturating_sub(1);
    let place = |i: usize| {
        let (position, text) = &labels[i];
        let anchor = match i {
            0 => Align2::LEFT_TOP,
            i if i == last => Align2::RIGHT_TOP,
            _ => Align2::CENTER_TOP,
        };
        let galley = painter.layout_no_wrap(text.clone(), font.clone(), color);
        let at = pos2(x(*position), colours.bottom() + 2.0);
        (anchor.anchor_size(at, galley.size()), galley)
    };
    let mut taken: Vec<Rect> = Vec::new();
    let ends = [0, last].into_iter().take(labels.len());
    for i in ends.chain(1..last) {
        let (rect, galley) = place(i);
        if taken.iter().all(|t| !t.expand(4.0).intersects(rect)) {
            painter.galley(rect.min, galley, color);
            taken.push(rect);
        }
    }
}
