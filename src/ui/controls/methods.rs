//! A method and its parameters, drawn from what the registry declares of them.

use crate::occlusion::{MethodSetup, REGISTRY};
use crate::param::{ParamKind, ParamSpec, ParamValue};
use eframe::egui;

/// Height at which the menu of methods shows all of them without scrolling, points.
const MENU_HEIGHT: f32 = 480.0;

/// A drop-down of the registry and a control for each parameter of the chosen method that applies.
pub fn draw(ui: &mut egui::Ui, title: &str, setup: &mut MethodSetup) {
    let label = ui.strong(title);
    let info = setup.method.info();
    egui::ComboBox::from_id_salt(title)
        .height(MENU_HEIGHT)
        .selected_text(format!("{} – {}", info.id, info.title))
        .width(ui.available_width() - 8.0)
        .show_ui(ui, |ui| {
            for method in REGISTRY {
                let other = method.info();
                let text = format!("{} – {}", other.id, other.title);
                let label = ui.selectable_label(other.id == info.id, text);
                if label.on_hover_text(other.citation).clicked()
                    && other.id != info.id
                    && let Ok(fresh) = MethodSetup::defaults(other.id)
                {
                    *setup = fresh;
                }
            }
        })
        .response
        .labelled_by(label.id)
        .on_hover_text(info.citation);
    egui::Grid::new((title, "parameters"))
        .num_columns(2)
        .show(ui, |ui| {
            let specs = setup.method.info().specs();
            for spec in specs {
                if spec.applies_at(&setup.params) && is_offered(spec, setup) {
                    parameter(ui, title, spec, setup);
                    ui.end_row();
                }
            }
        });
}

/// Whether a parameter is shown. One whose options only reproduce a source is shown where it is not at its default.
fn is_offered(spec: &ParamSpec, setup: &MethodSetup) -> bool {
    spec.is_everyday() || setup.params.get(spec.name) != Some(spec.default_value())
}

/// Options in a menu: everyday ones, and the present value where it is none of them.
fn offered(spec: &ParamSpec, value: &'static str) -> impl Iterator<Item = &'static str> {
    let printed = spec.printed(value).map(|p| p.option);
    spec.everyday_options().chain(printed)
}

fn parameter(ui: &mut egui::Ui, title: &str, spec: &'static ParamSpec, setup: &mut MethodSetup) {
    let Some(value) = setup.params.get(spec.name) else {
        return;
    };
    let doc = format!(
        "{}\n{}{}, default {}{}",
        spec.whole_doc(),
        spec.range_text(),
        if spec.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", spec.unit)
        },
        spec.default_value(),
        match spec.applies.words() {
            Some(condition) => format!(". Applies where {condition}."),
            None => String::new(),
        }
    );
    let label = ui.label(spec.name).on_hover_text(&doc);
    let new = match (value, spec.kind) {
        (ParamValue::Int(mut v), ParamKind::Int { min, max, .. }) => {
            let speed = (v as f64 * 0.02).max(0.1);
            let drag = egui::DragValue::new(&mut v).range(min..=max).speed(speed);
            ui.add(suffixed(drag, spec))
                .labelled_by(label.id)
                .on_hover_text(doc);
            ParamValue::Int(v)
        }
        (ParamValue::Float(mut v), ParamKind::Float { min, max, .. }) => {
            let speed = (v.abs() * 0.01).max(1e-3);
            let drag = egui::DragValue::new(&mut v).range(min..=max).speed(speed);
            ui.add(suffixed(drag, spec))
                .labelled_by(label.id)
                .on_hover_text(doc);
            ParamValue::Float(v)
        }
        (ParamValue::Choice(v), ParamKind::Choice { .. }) => {
            let mut chosen = v;
            egui::ComboBox::from_id_salt((title, spec.name))
                .selected_text(v)
                .show_ui(ui, |ui| {
                    for option in offered(spec, v) {
                        ui.selectable_value(&mut chosen, option, option);
                    }
                })
                .response
                .labelled_by(label.id)
                .on_hover_text(doc);
            ParamValue::Choice(chosen)
        }
        (other, _) => other,
    };
    setup.params.set(spec.name, new);
    let default = spec.default_value();
    if new != default
        && ui
            .small_button("Reset")
            .on_hover_text(format!("Back to {default}"))
            .clicked()
    {
        setup.params.set(spec.name, default);
    }
}

fn suffixed<'a>(drag: egui::DragValue<'a>, spec: &ParamSpec) -> egui::DragValue<'a> {
    if spec.unit.is_empty() {
        drag
    } else {
        drag.suffix(format!(" {}", spec.unit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_only_reproduces_a_source_is_offered_where_it_is_chosen_already() {
        let fom = MethodSetup::defaults("fom").unwrap();
        let spec = |name: &str| fom.method.info().specs().find(|s| s.name == name).unwrap();
        let options = |value| offered(spec("sampling"), value).collect::<Vec<_>>();
        assert_eq!(options("end"), ["midpoint", "end"]);
        assert_eq!(options("quadratic"), ["midpoint", "end", "quadratic"]);
        assert!(is_offered(spec("sampling"), &fom) && is_offered(spec("order"), &fom));
        assert!(!is_offered(spec("sines"), &fom));
        let printed = fom.clone().with("sines", "first").unwrap();
        assert!(is_offered(spec("sines"), &printed));
    }
}
