//! Method settings of an experiment, checked against what the methods declare.

use super::experiment::{Experiment, MethodEntry};
use super::{locate, suggest};
use crate::error::Result;
use crate::param::{ParamSpec, ParamValue, Params};

/// Ids and parameters of the methods, as the configuration needs them.
pub trait MethodCatalogue {
    /// Ids of all methods, in the order of lists and menus.
    fn ids(&self) -> Vec<&str>;
    /// Declared parameters of a method; `None` for an unknown id.
    fn params(&self, id: &str) -> Option<Vec<&'static ParamSpec>>;
}

/// A method with its checked axes.
pub(super) struct MethodAxes {
    pub id: String,
    specs: Vec<&'static ParamSpec>,
    defaults: Params,
    axes: Vec<(&'static str, Vec<ParamValue>)>,
}

impl MethodAxes {
    /// Number of settings, saturating.
    pub fn count(&self) -> usize {
        self.axes
            .iter()
            .fold(1, |n, (_, values)| n.saturating_mul(values.len()))
    }

    /// Notes on listed parameters that have no effect at some settings, or at any.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for spec in self.specs.iter().filter(|spec| self.lists(spec.name)) {
            let (Some(of), Some(condition)) = (spec.applies.decided_by(), spec.applies.words())
            else {
                continue;
            };
            let (id, name) = (&self.id, spec.name);
            let (applies, idle): (Vec<_>, Vec<_>) =
                self.values(of).partition(|value| spec.applies.at(*value));
            if applies.is_empty() {
                notes.push(format!(
                    "{id}: `{name}` has no effect: it applies where {condition}"
                ));
            } else if !idle.is_empty() {
                notes.push(format!(
                    "{id}: `{name}` applies where {condition}; elsewhere its values are one setting"
                ));
            }
        }
        notes
    }

    fn lists(&self, name: &str) -> bool {
        self.axes.iter().any(|(axis, _)| *axis == name)
    }

    /// The values that a parameter takes: those listed, or its default.
    fn values(&self, name: &str) -> impl Iterator<Item = ParamValue> {
        let listed = self.axes.iter().find(|(axis, _)| *axis == name);
        let listed = listed.map(|(_, values)| values.clone());
        listed
            .unwrap_or_else(|| self.defaults.get(name).into_iter().collect())
            .into_iter()
    }

    /// Setting `n` of `count`: the first parameter in the file varies slowest. Complete: parameters that do not apply
    /// included.
    pub fn setting(&self, mut n: usize) -> Params {
        let mut params = self.defaults.clone();
        for (name, values) in self.axes.iter().rev() {
            params.set(name, values[n % values.len()]);
            n /= values.len();
        }
        params
    }

    /// The parameters of a setting that apply.
    pub fn applying(&self, setting: &Params) -> Params {
        setting.applying(self.specs.iter().copied())
    }
}

/// Checks the method settings: known method, known parameters, allowed values.
pub(super) fn check(
    experiment: &Experiment,
    catalogue: &dyn MethodCatalogue,
) -> Result<Vec<MethodAxes>> {
    experiment
        .methods
        .iter()
        .map(|entry| check_entry(experiment, entry, catalogue))
        .collect()
}

fn check_entry(
    experiment: &Experiment,
    entry: &MethodEntry,
    catalogue: &dyn MethodCatalogue,
) -> Result<MethodAxes> {
    let document = experiment.document();
    let Some(specs) = catalogue.params(&entry.id) else {
        let ids = catalogue.ids();
        let remedy = format!(
            "{}Methods are {}.",
            suggest::sentence(&entry.id, ids.iter().copied()),
            quoted(&ids)
        );
        return Err(document.error(
            &entry.id_place,
            format!("there is no method `{}`", entry.id),
            remedy,
        ));
    };
    let mut axes = Vec::with_capacity(entry.params.len());
    for (name, values) in &entry.params {
        let Some(spec) = specs.iter().find(|spec| spec.name == name) else {
            let names: Vec<&str> = specs.iter().map(|spec| spec.name).collect();
            let pointer = format!("{}{}", entry.place, locate::step(name));
            let known = if names.is_empty() {
                "It has none.".to_owned()
            } else {
                format!("Its parameters are {}.", quoted(&names))
            };
            let remedy = format!("{}{known}", suggest::sentence(name, names));
            return Err(document.error_at_key(
                &pointer,
                format!("`{}` has no parameter `{name}`", entry.id),
                remedy,
            ));
        };
        let parse = |(place, value): &(String, serde_json::Value)| {
            spec.parse(value).map_err(|problem| {
                document.error(place, problem, "Give one allowed value or a list of them.")
            })
        };
        axes.push((spec.name, values.iter().map(parse).collect::<Result<_>>()?));
    }
    let axes = MethodAxes {
        id: entry.id.clone(),
        defaults: Params::defaults(specs.iter().copied()),
        specs,
        axes,
    };
    check_effect(experiment, entry, &axes)?;
    Ok(axes)
}

/// Refuses several values of a parameter that has no effect at any setting: they would be measured as one.
fn check_effect(experiment: &Experiment, entry: &MethodEntry, axes: &MethodAxes) -> Result<()> {
    for (name, values) in &axes.axes {
        let Some(spec) = axes.specs.iter().find(|spec| spec.name == *name) else {
            continue;
        };
        let (Some(of), Some(condition)) = (spec.applies.decided_by(), spec.applies.words()) else {
            continue;
        };
        if values.len() < 2 || axes.values(of).any(|value| spec.applies.at(value)) {
            continue;
        }
        let given: Vec<String> = axes.values(of).map(|value| value.to_string()).collect();
        let problem = format!(
            "`{name}` has no effect: it applies where {condition}, and `{of}` is {}",
            given.join(", ")
        );
        let pointer = format!("{}{}", entry.place, locate::step(name));
        let remedy = format!("Leave it out, or set {condition} too.");
        return Err(experiment
            .document()
            .error_at_key(&pointer, problem, remedy));
    }
    Ok(())
}

fn quoted(names: &[&str]) -> String {
    names
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ")
}
