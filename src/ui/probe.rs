//! T(d) of every method along one light column, as a chart.

use super::app::App;
use super::ink::ink;
use super::lower::{self, Lower};
use crate::live::{Probed, Where};
use crate::occlusion::{MethodSetup, REGISTRY};
use crate::probe::MethodCurve;
use crate::scene::{ImageSize, Scene};
use eframe::egui;
use egui_plot::{Corner, Legend, Line, LineStyle, MarkerShape, Plot, PlotPoints, Points, VLine};

/// A probe that was asked for.
pub struct Asked {
    /// Where.
    at: Where,
    /// Names of the curves.
    names: Vec<String>,
    /// The view that was clicked on.
    view: (Scene, ImageSize),
}

impl App {
    /// Where the last probe was, if its view is still the one that is looked at.
    pub(super) fn asked_here(&self) -> Option<Where> {
        let asked = self.asked.as_ref()?;
        let (scene, image) = &asked.view;
        (*scene == self.state.scene && *image == self.state.image).then_some(asked.at)
    }
}

/// Asks for the curves at a place and opens their panel.
pub fn ask(app: &mut App, at: Where) {
    let Some(request) = app.sent() else {
        return;
    };
    let (names, methods) = methods(&app.state.methods).into_iter().unzip();
    app.live.probe(request, methods, at);
    app.asked = Some(Asked {
        at,
        names,
        view: (request.scene.clone(), request.image),
    });
    app.shown.probed = None;
    app.pane.lower = Some(Lower::Probe);
}

/// Every method but the truth, in the order of the registry: as A and B have it, else at its defaults.
fn methods(sides: &[MethodSetup; 2]) -> Vec<(String, MethodSetup)> {
    let mut all = Vec::new();
    for method in REGISTRY {
        let id = method.info().id;
        let [a, b] = sides.each_ref().map(|s| s.method.info().id == id);
        match (a, b) {
            _ if method.info().is_truth() => {}
            (true, true) if sides[0] == sides[1] => {
                all.push((format!("{id} (A, B)"), sides[0].clone()));
            }
            (false, false) => {
                all.extend(MethodSetup::defaults(id).map(|setup| (id.to_owned(), setup)));
            }
            _ => {
                for (letter, setup) in ["A", "B"].iter().zip(sides) {
                    if setup.method.info().id == id {
                        all.push((format!("{id} ({letter})"), setup.clone()));
                    }
                }
            }
        }
    }
    all
}

/// Draws the panel.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    let probed = app.shown.probed.clone();
    ui.horizontal_wrapped(|ui| {
        lower::tabs(app, ui);
        let Some(asked) = &app.asked else {
            ui.label("Click a cloud in a picture, or a column of the light map.");
            return;
        };
        let place = match asked.at {
            Where::Pixel([x, y]) => format!("Pixel {x}, {y}"),
            Where::Column([u, v], ..) => format!("Map column {u:.3}, {v:.3}"),
        };
        let earlier = if app.asked_here().is_some() {
            ""
        } else {
            " of an earlier view"
        };
        if !matches!(probed, Some(Err(_))) {
            ui.label(format!("{place}{earlier}"));
        }
        match &probed {
            None => {
                ui.label("computing…");
            }
            Some(Err(problem)) => {
                ui.colored_label(ui.visuals().error_fg_color, problem);
            }
            Some(Ok(probed)) => {
                let copy = ui.button("Copy CSV");
                let hint = "The curves as a table: depth, extinction, truth, one column a method";
                if copy.on_hover_text(hint).clicked() {
                    ui.ctx().copy_text(probed.probe.csv());
                }
                for note in notes(probed) {
                    ui.label(note);
                }
            }
        }
    });
    let (Some(asked), Some(Ok(probed))) = (&app.asked, &probed) else {
        ui.take_available_space();
        return;
    };
    if ui.available_width() >= 16.0 && ui.available_height() >= 16.0 {
        chart(ui, &asked.names, probed);
    }
}

/// Optical depth of the column, depth of the point seen, and what the marks of the curves mean.
fn notes(probed: &Probed) -> Vec<String> {
    let probe = &probed.probe;
    // −ln 1 would be −0.
    let tau = probe.truth.last().copied().unwrap_or(1.0).ln().abs();
    let mut notes = vec![format!("τ = {tau:.2}")];
    if let Some(seen_m) = probed.seen_m {
        notes.push(format!("seen at {seen_m:.0} m"));
    }
    let has = |test: fn(&MethodCurve) -> bool| probe.curves.iter().any(test);
    if has(|c| c.outside.contains(&true)) {
        notes.push("× outside the truth's range".to_owned());
    }
    if has(|c| c.clamped_from.is_some()) {
        notes.push("diamond: τ_max sets in".to_owned());
    }
    notes
}

/// Height from which a chart has room for its legend, points.
const LEGEND: f32 = 190.0;

fn chart(ui: &mut egui::Ui, names: &[String], probed: &Probed) {
    let probe = &probed.probe;
    let visuals = ui.visuals().clone();
    let longest_m = probe.depths_m.last().copied().unwrap_or(0.0);
    let points = |values: &[f64]| -> PlotPoints<'static> {
        let pairs = probe.depths_m.iter().zip(values);
        pairs
            .filter(|(_, t)| t.is_finite())
            .map(|(d, t)| [*d, *t])
            .collect()
    };
    let mut chart = Plot::new("probe");
    if ui.available_height() >= LEGEND {
        let legend = Legend::default().position(Corner::LeftBottom);
        let legend = legend.text_style(egui::TextStyle::Small);
        chart = chart.legend(legend.follow_insertion_order(true));
    }
    let response = chart
        .x_axis_label("depth d inside the layer from its sun side (m)")
        .y_axis_label("T(d)")
        .default_x_bounds(0.0, longest_m)
        .default_y_bounds(0.0, 1.05)
        .allow_scroll(false)
        .show(ui, |plot| {
            let truth = ink("truth", &visuals);
            plot.line(
                Line::new("truth", points(&probe.truth))
                    .color(truth)
                    .width(4.0),
            );
            for (name, curve) in names.iter().zip(&probe.curves) {
                let color = ink(curve.method, &visuals);
                let dashed = name.ends_with("(B)");
                let style = if dashed {
                    LineStyle::dashed_dense()
                } else {
                    LineStyle::Solid
                };
                let line = Line::new(name.clone(), points(&curve.transmittance));
                plot.line(line.color(color).width(2.0).style(style));
                for points in marks(name, &probe.depths_m, curve) {
                    plot.points(points.color(color));
                }
            }
            if let Some(seen_m) = probed.seen_m {
                let seen = VLine::new("the point seen", seen_m);
                let color = visuals.weak_text_color();
                plot.vline(seen.color(color).style(LineStyle::dashed_loose()));
            }
        });
    let label = "chart of transmittance over depth";
    let info = || egui::WidgetInfo::labeled(egui::Role::Figure, true, label);
    response.response.widget_info(info);
}

/// Depths of a curve between two of its marks.
const MARKED: usize = 8;

/// Marks where a curve is outside the truth's range, and where its clamp sets in; in the legend under the curve's name.
fn marks(name: &str, depths_m: &[f64], curve: &MethodCurve) -> Vec<Points<'static>> {
    let point = |i: usize| [depths_m[i], curve.transmittance[i]];
    let outside = (0..depths_m.len()).filter(|i| curve.outside[*i]);
    let outside: Vec<_> = outside.step_by(MARKED).map(point).collect();
    let mut marks = Vec::new();
    if !outside.is_empty() {
        let points = Points::new(name.to_owned(), outside);
        marks.push(points.shape(MarkerShape::Cross).radius(4.0));
    }
    if let Some(from) = curve.clamped_from {
        let points = Points::new(name.to_owned(), vec![point(from)]);
        marks.push(points.shape(MarkerShape::Diamond).radius(7.0).filled(false));
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_asked_once_and_both_sides_as_they_are_set() {
        let setup = |id| MethodSetup::defaults(id).unwrap();
        let names = |sides: &[MethodSetup; 2]| -> Vec<String> {
            methods(sides).into_iter().map(|(name, _)| name).collect()
        };
        let infos = REGISTRY.iter().map(|method| method.info());
        let asked = infos.filter(|info| !info.is_truth());
        let named: Vec<String> = asked
            .map(|info| match info.id {
                "srm" => "srm (A)".to_owned(),
                "bsm" => "bsm (B)".to_owned(),
                id => id.to_owned(),
            })
            .collect();
        assert_eq!(names(&[setup("srm"), setup("bsm")]), named);
        assert_eq!(names(&[setup("fom"), setup("fom")])[3], "fom (A, B)");
        let other = setup("fom").with("order", "5").unwrap();
        let both = names(&[setup("fom"), other]);
        assert_eq!(both[3..5], ["fom (A)", "fom (B)"]);
        let truths = names(&[setup("truth"), setup("truth")]);
        assert_eq!(truths.len(), named.len());
    }
}
