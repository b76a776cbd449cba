//! Viewer of light maps: one value of the texels at a time, as an image.

use super::app::{App, Slot};
use super::lower;
use super::map_grid::{Shape, metres, texel_at, texel_m};
use super::probe;
use super::view::colour_bar;
use crate::frame::{FALSE_COLOUR_STOPS, false_colour, is_nonfinite};
use crate::live::Where;
use crate::occlusion::MethodSetup;
use crate::raymarch::MapTexels;
use eframe::egui::{self, Color32, Rect, Role, Sense, vec2};
use std::sync::Arc;

/// State of the viewer.
pub struct MapView {
    /// The value of a texel that is shown.
    value: usize,
    /// Which of several rectangles is shown, the nearest first.
    cascade: usize,
    colours: Colours,
    shape: Shape,
    /// Draw the lines of the shape over the map.
    grid: bool,
    painted: Option<Painted>,
}

impl Default for MapView {
    fn default() -> Self {
        Self {
            value: 0,
            cascade: 0,
            colours: Colours::default(),
            shape: Shape::default(),
            grid: true,
            painted: None,
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Colours {
    #[default]
    Grey,
    False,
}

/// A texture, and what it was made from.
struct Painted {
    texels: Arc<MapTexels>,
    value: usize,
    cascade: usize,
    colours: Colours,
    /// Least and largest finite value.
    range: Option<[f32; 2]>,
    texture: egui::TextureHandle,
}

/// From black to white.
const GREYS: [(f32, [u8; 3]); 2] = [(-1.0, [0; 3]), (1.0, [255; 3])];
/// Edge of the largest texture; larger maps are subsampled.
const LARGEST: u32 = 2048;
/// Width of the colour bar, and height with its numbers, points.
const SCALE: [f32; 2] = [260.0, 32.0];
/// Lines over the map: seen on grey and on the false colours.
const LINES: egui::Stroke = egui::Stroke {
    width: 1.0,
    color: Color32::from_rgba_premultiplied(0, 130, 50, 160),
};

/// Draws the panel.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    let side = app.pane.map_side.min(1);
    let setup = app.state.methods[side].clone();
    let map = app
        .shown
        .map
        .clone()
        .filter(|(slot, _)| *slot == Slot::Side(side));
    let texels = map.as_ref().and_then(|(_, texels)| texels.clone());
    ui.horizontal_wrapped(|ui| {
        lower::tabs(app, ui);
        for (side, letter) in ["A", "B"].into_iter().enumerate() {
            ui.selectable_value(&mut app.pane.map_side, side, letter)
                .on_hover_text(format!("The map of the method {letter}"));
        }
        ui.label(setup.method.info().id);
        if let Some(texels) = &texels {
            choices(&mut app.map_view, ui, &setup, texels);
        }
    });
    let Some(texels) = texels else {
        let why = match map {
            Some(_) => "This method has no light map.",
            None => "Waiting for the exact picture, with which the map comes",
        };
        ui.label(why);
        ui.take_available_space();
        return;
    };
    let last = (texels.values_a_texel as usize).saturating_sub(1);
    let value = app.map_view.value.min(last);
    app.map_view.paint(ui.ctx(), &texels, value);
    if ui.available_width() >= 16.0 && ui.available_height() >= 16.0 {
        picture(app, ui, &setup);
    }
}

fn choices(view: &mut MapView, ui: &mut egui::Ui, setup: &MethodSetup, texels: &MapTexels) {
    let names = names(setup, texels.values_a_texel as usize);
    let value = view.value.min(names.len() - 1);
    let label = ui.label("Value");
    egui::ComboBox::from_id_salt("map value")
        .selected_text(&names[value])
        .show_ui(ui, |ui| {
            for (i, name) in names.iter().enumerate() {
                ui.selectable_value(&mut view.value, i, name);
            }
        })
        .response
        .labelled_by(label.id)
        .on_hover_text("Which of the values of a texel");
    let cascades = texels.rectangles.len();
    view.cascade = view.cascade.min(cascades.saturating_sub(1));
    if cascades > 1 {
        for i in 0..cascades {
            ui.selectable_value(&mut view.cascade, i, format!("Cascade {}", i + 1))
                .on_hover_text("1 is the rectangle nearest to the camera");
        }
        ui.separator();
    }
    ui.selectable_value(&mut view.colours, Colours::Grey, "Grey")
        .on_hover_text("Black is the least finite value, white the largest");
    ui.selectable_value(&mut view.colours, Colours::False, "False colour")
        .on_hover_text("Blue is the least finite value, red the largest");
    ui.separator();
    for shape in Shape::ALL {
        ui.selectable_value(&mut view.shape, shape, shape.name())
            .on_hover_text(shape.explained());
    }
    ui.checkbox(&mut view.grid, "Texel grid")
        .on_hover_text("Lines that show where texels are small");
}

/// Names of the values of a texel; numbers for those that the method does not name.
fn names(setup: &MethodSetup, count: usize) -> Vec<String> {
    let named = setup.method.value_names(&setup.params).unwrap_or_default();
    let numbered = (named.len()..count.max(1)).map(|i| format!("value {i}"));
    let named = named.into_iter().take(count);
    named.chain(numbered).collect()
}

impl MapView {
    /// Makes the texture if it would differ from the one there is.
    fn paint(&mut self, ctx: &egui::Context, texels: &Arc<MapTexels>, value: usize) {
        let same = |p: &Painted| {
            Arc::ptr_eq(&p.texels, texels)
                && (p.value, p.cascade, p.colours) == (value, self.cascade, self.colours)
        };
        if self.painted.as_ref().is_some_and(same) {
            return;
        }
        let largest = LARGEST.min(ctx.input(|i| i.max_texture_side) as u32);
        let range = range(texels, value);
        let image = image(texels, [self.cascade, value], range, self.colours, largest);
        let options = egui::TextureOptions::NEAREST;
        self.painted = Some(Painted {
            texels: texels.clone(),
            value,
            cascade: self.cascade,
            colours: self.colours,
            range,
            texture: ctx.load_texture("light map", image, options),
        });
    }
}

/// Least and largest finite value.
fn range(texels: &MapTexels, value: usize) -> Option<[f32; 2]> {
    let values = texels.values.iter().skip(value);
    let finite = values
        .step_by(texels.values_a_texel as usize)
        .filter(|v| !is_nonfinite(**v));
    finite.fold(None, |range, v| match range {
        None => Some([*v, *v]),
        Some([least, most]) => Some([least.min(*v), most.max(*v)]),
    })
}

/// One value of a cascade at an edge of `largest` pixels or less, v downward; magenta where a value is not finite.
fn image(
    texels: &MapTexels,
    [cascade, value]: [usize; 2],
    range: Option<[f32; 2]>,
    colours: Colours,
    largest: u32,
) -> egui::ColorImage {
    let step = texels.resolution.div_ceil(largest.max(1)).max(1);
    let edge = texels.resolution.div_ceil(step);
    let [least, most] = range.unwrap_or([0.0, 0.0]);
    let position = |v: f32| {
        if is_nonfinite(v) {
            f32::NAN
        } else if most > least {
            ((f64::from(v) - f64::from(least)) / (f64::from(most) - f64::from(least)) * 2.0 - 1.0)
                as f32
        } else {
            0.0
        }
    };
    let first = cascade as u32 * texels.resolution;
    let texel = |i: u32| texels.texel([i % edge * step, first + i / edge * step])[value];
    let positions: Vec<f32> = (0..edge * edge).map(|i| position(texel(i))).collect();
    let mut pixels = false_colour(edge, edge, &positions, 1.0);
    if colours == Colours::Grey {
        for (pixel, position) in pixels.chunks_exact_mut(3).zip(&positions) {
            if !is_nonfinite(*position) {
                pixel.fill((127.5 * (position + 1.0)).round() as u8);
            }
        }
    }
    egui::ColorImage::from_rgb([edge as usize; 2], &pixels)
}

/// The map at the left, its description at the right.
fn picture(app: &mut App, ui: &mut egui::Ui, setup: &MethodSetup) {
    let Some(painted) = &app.map_view.painted else {
        return;
    };
    let area = ui.available_rect_before_wrap();
    ui.allocate_rect(area, Sense::hover());
    let map = &painted.texels.rectangles[painted.cascade];
    let shape = app.map_view.shape;
    let beside = match shape {
        Shape::Stored => 0.0,
        Shape::Plane => (SCALE[0] + 8.0).min(area.width() / 2.0),
    };
    let room = area.size() - vec2(beside, 0.0);
    let rect = Rect::from_min_size(area.min, shape.size(map, room));
    let response = ui.interact(rect, ui.scope_id().with("light map"), Sense::click());
    let name = format!("light map of {}", setup.method.info().id);
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, &name));
    let painter = ui.painter_at(rect);
    painter.add(shape.mesh(map, painted.texture.id(), rect));
    let resolution = painted.texels.resolution;
    let ([across_u, across_v], lines) = shape.lines(map, resolution);
    if app.map_view.grid {
        for u in across_u {
            painter.vline(rect.left() + rect.width() * u as f32, rect.y_range(), LINES);
        }
        for v in across_v {
            painter.hline(rect.x_range(), rect.top() + rect.height() * v as f32, LINES);
        }
    }
    if response.has_focus() {
        let stroke = ui.visuals().selection.stroke;
        painter.rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Inside);
    }
    let pointed = response.hover_pos().or(response.interact_pointer_pos());
    let share = (pointed.unwrap_or(rect.center()) - rect.min) / rect.size();
    let uv = shape.uv(map, [share.x, share.y].map(f64::from));
    let texel = texel_at(uv, resolution);
    let builder = egui::UiBuilder::new()
        .id_salt("about the map")
        .max_rect(area.with_min_x((rect.right() + 8.0).min(area.right())));
    let mut beside = ui.new_child(builder);
    beside.shrink_clip_rect(area);
    let lines = app.map_view.grid.then_some(lines);
    about(&mut beside, painted, lines, pointed.map(|_| texel));
    if response.clicked() {
        let middle = texel.map(|i| (f64::from(i) + 0.5) / f64::from(resolution));
        // The probe counts in the whole rectangle, which is the last one.
        let whole = painted.texels.rectangles.last();
        let middle = whole.and_then(|whole| whole.uv(map.column_origin(middle)));
        // A method whose map is shown has the parameters of maps.
        if let Some((middle, fit)) = middle.zip(setup.map_fit().ok()) {
            probe::ask(app, Where::Column(middle, resolution, fit));
        }
    }
}

fn about(ui: &mut egui::Ui, painted: &Painted, lines: Option<String>, texel: Option<[u32; 2]>) {
    let texels = &painted.texels;
    let edge = texels.resolution;
    ui.label(format!(
        "{edge} × {edge} texels of {} values",
        texels.values_a_texel
    ));
    let map = &texels.rectangles[painted.cascade];
    if map.depth_m > 0.0 {
        let [u, v] = map.extent_m.map(metres);
        ui.label(format!("{u} × {v}, perpendicular to the sun"));
    }
    if let Some(lines) = lines {
        ui.label(lines);
    }
    let lost = texels.nonfinite();
    if lost > 0 {
        ui.colored_label(
            ui.visuals().error_fg_color,
            format!("{lost} values are not finite (magenta)"),
        );
    }
    if let Some([least, most]) = painted.range {
        let size = vec2(SCALE[0].min(ui.available_width()), SCALE[1]);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let labels = [(-1.0, number(least)), (1.0, number(most))];
        let stops: &[_] = match painted.colours {
            Colours::Grey => &GREYS,
            Colours::False => &FALSE_COLOUR_STOPS,
        };
        colour_bar::draw(ui, rect, stops, &labels);
    } else {
        ui.label("No value is finite.");
    }
    match texel {
        Some([u, v]) => {
            let first = painted.cascade as u32 * edge;
            let value = texels.texel([u, first + v])[painted.value];
            let [u_m, v_m] = texel_m(map, [u, v], edge).map(metres);
            ui.label(format!("texel {u}, {v}, {u_m} × {v_m}: {}", number(value)));
        }
        None => {
            ui.label("Point at a texel to read it, click it to probe its column.");
        }
    }
}

/// Four decimals, as a power of ten where the number is very large or small.
fn number(value: f32) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) || !value.is_finite() {
        format!("{value:.4}")
    } else {
        format!("{value:.4e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MapRectangle;
    use glam::DVec3;

    fn texels() -> MapTexels {
        MapTexels {
            resolution: 2,
            values_a_texel: 2,
            values: vec![9.0, 1.0, 9.0, 3.0, 9.0, f32::NAN, 9.0, 2.0],
            rectangles: vec![MapRectangle {
                u_axis: DVec3::X,
                v_axis: DVec3::Z,
                origin_m: [0.0; 2],
                extent_m: [1.0; 2],
                depth_m: 1.0,
                warp: None,
            }],
        }
    }

    #[test]
    fn values_span_the_colours_and_what_is_not_finite_is_magenta() {
        let texels = texels();
        assert_eq!(range(&texels, 1), Some([1.0, 3.0]));
        let of = |colours| image(&texels, [0, 1], range(&texels, 1), colours, 2048).pixels;
        let grey = [
            Color32::BLACK,
            Color32::WHITE,
            Color32::from_rgb(255, 0, 255),
        ];
        assert_eq!(of(Colours::Grey)[..3], grey);
        assert_eq!(of(Colours::False)[0], Color32::from_rgb(5, 48, 97));
        assert_eq!(of(Colours::False)[3], Color32::WHITE);
        let small = image(&texels, [0, 1], None, Colours::Grey, 1);
        assert_eq!(small.size, [1, 1]);
        let level = image(&texels, [0, 0], range(&texels, 0), Colours::Grey, 2048);
        assert_eq!(level.pixels[0], Color32::from_rgb(128, 128, 128));
    }

    #[test]
    fn values_have_their_methods_names() {
        let of = |id, count| names(&MethodSetup::defaults(id).unwrap(), count);
        assert_eq!(of("bsm", 3)[2], "largest optical depth");
        assert_eq!(of("esm", 1), ["front z"]);
        assert_eq!(of("fom", 9)[..4], ["a0", "a1", "b1", "a2"]);
        assert_eq!(of("fom", 9)[6..], ["b3", "value 7", "value 8"]);
        assert_eq!(of("srm", 0).len(), 1);
    }
}
