//! Method settings of an experiment, checked against what the methods declare.

use super::experiment::{Experiment, MethodEntry};
use super::{locate, suggest};
use crate::error::Result;
use crate::occlusion::param::{ParamSpec, ParamValue, Params};

/// What the configuration must know of the methods.
pub trait MethodCatalogue {
    /// Ids of all methods, in the order they are listed to people.
    fn ids(&self) -> Vec<&str>;
    /// Declared parameters of a method; `None` for an unknown id.
    fn params(&self, id: &str) -> Option<Vec<&'static ParamSpec>>;
}

/// A method with its checked axes.
pub(super) struct MethodAxes {
    pub id: String,
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

    /// Setting `n` of `count`: the first parameter in the file is the slowest.
    pub fn setting(&self, mut n: usize) -> Params {
        let mut params = self.defaults.clone();
        for (name, values) in self.axes.iter().rev() {
            params.set(name, values[n % values.len()]);
            n /= values.len();
        }
        params
    }
}

/// Checks every entry: known method, known parameters, allowed values.
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
    Ok(MethodAxes {
        id: entry.id.clone(),
        defaults: Params::defaults(specs.into_iter()),
        axes,
    })
}

fn quoted(names: &[&str]) -> String {
    names
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ")
}
