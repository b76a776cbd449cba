//! The reconstructions that an experiment lists, checked against the registered ones.

use super::experiment::Experiment;
use super::methods::MethodCatalogue;
use crate::error::Result;
use crate::scene::ReconstructionInfo;
use serde_json::{Value, json};

/// Everything that the configuration names by an id: methods and reconstructions.
pub trait Catalogue: MethodCatalogue {
    /// All reconstructions, in the order of lists and menus.
    fn reconstructions(&self) -> Vec<&'static ReconstructionInfo>;
}

/// Name of the schema's definition.
pub(super) const DEFINITION: &str = "Reconstruct";

/// The ids that an experiment lists, [`ReconstructionInfo::FULL`] where it lists none; never empty.
pub(super) fn check(
    experiment: &Experiment,
    catalogue: &dyn Catalogue,
) -> Result<Vec<&'static ReconstructionInfo>> {
    let (document, known) = (experiment.document(), catalogue.reconstructions());
    let by_id = |id: &str| known.iter().find(|info| info.id == id).copied();
    let mut chosen = Vec::new();
    for (place, value) in &experiment.reconstruct {
        let Some(info) = value.as_str().and_then(by_id) else {
            return Err(document.misfit(place, value, &definition(&known)));
        };
        if chosen.contains(&info) {
            return Err(document.error(place, "it is listed twice", "Name each of them once."));
        }
        chosen.push(info);
    }
    if experiment.reconstruct.is_empty() {
        chosen.extend(by_id(ReconstructionInfo::FULL));
    }
    if !experiment.ghosting.is_empty() && chosen.iter().all(|info| info.history.is_none()) {
        return Err(no_ghosting(experiment, &chosen, &known));
    }
    Ok(chosen)
}

/// The error for `ghosting` where no reconstruction uses earlier frames: there is no ghosting to measure.
fn no_ghosting(
    experiment: &Experiment,
    chosen: &[&ReconstructionInfo],
    known: &[&ReconstructionInfo],
) -> crate::error::Error {
    let ids: Vec<String> = chosen.iter().map(|r| format!("`{}`", r.id)).collect();
    let problem = format!("every cell is {}, which has none", ids.join(" or "));
    let other = known.iter().find(|info| info.history.is_some());
    let add = other.map(|info| format!("Add `\"reconstruct\": \"{}\"`, or remove", info.id));
    let remedy = format!("{} `ghosting`.", add.as_deref().unwrap_or("Remove"));
    let document = experiment.document();
    document.error_at_key("/ghosting", problem, remedy)
}

/// Schema of the id of a reconstruction.
pub(super) fn definition(known: &[&ReconstructionInfo]) -> Value {
    let one = |info: &&ReconstructionInfo| json!({"type": "string", "const": info.id, "description": info.doc});
    let all: Vec<Value> = known.iter().map(one).collect();
    json!({"oneOf": all, "description": "From frames to a picture."})
}

/// Schema description of the experiment's member `reconstruct`.
pub(super) fn description(known: &[&ReconstructionInfo]) -> String {
    let one = |info: &&ReconstructionInfo| format!("`{}`, {}", info.id, info.brief);
    let all: Vec<String> = known.iter().map(one).collect();
    let default = ReconstructionInfo::FULL;
    format!(
        "How pictures come about: {}. Absent: `{default}`.",
        all.join("; ")
    )
}
