//! Names and records of cells.

use super::record::{Cell, Times};
use super::rounds::Round;
use super::{Event, Observer, Task, tell};
use crate::config::{CellSpec, MatrixView};
use crate::error::{Error, Result};
use crate::metrics::summarise;
use crate::occlusion::MethodSetup;
use serde_json::json;

/// The method of a cell with its parameters.
pub(super) fn setup(spec: &CellSpec) -> Result<MethodSetup> {
    MethodSetup::of(&spec.method, &spec.params)
}

/// Statistics of each pass over the timed rounds.
pub(super) fn times(rounds: &[Round]) -> Times {
    let stats = |value: fn(&Round) -> Option<f64>| {
        summarise(&rounds.iter().filter_map(value).collect::<Vec<_>>())
    };
    Times {
        generate: stats(|round| round.times.generate),
        march: stats(|round| round.times.march),
        reconstruct: stats(|round| round.times.reconstruct),
        total: stats(|round| round.total_ms),
        wall: stats(|round| Some(round.times.wall)),
    }
}

/// One time per round, in round order, `None` for a round without it; empty where no round has it.
pub(super) fn each_round(rounds: &[Round], value: fn(&Round) -> Option<f64>) -> Vec<Option<f64>> {
    let times: Vec<_> = rounds.iter().map(value).collect();
    match times.iter().all(Option::is_none) {
        true => Vec::new(),
        false => times,
    }
}

/// A record without numbers, with its keys.
pub(super) fn bare_cell(task: &Task, view: &MatrixView, spec: &CellSpec) -> Cell {
    let environment = task.backend.environment();
    Cell {
        id: task.identity.cell(view, spec),
        backend: format!("{} {}", environment.backend, environment.device_type),
        ..planned_cell(view, spec)
    }
}

/// The record of a cell before it is measured; the measurement sets its keys.
pub fn planned_cell(view: &MatrixView, spec: &CellSpec) -> Cell {
    Cell {
        id: String::new(),
        index: spec.index,
        scene: view.scene.name.clone(),
        scene_id: String::new(),
        scene_set: view.scene_set.clone(),
        sun_elevation_deg: view.scene.sun.elevation_deg,
        method: spec.method.clone(),
        params: spec
            .params
            .iter()
            .map(|(k, v)| (k.to_owned(), json!(v)))
            .collect(),
        reconstruct: spec.reconstruct,
        backend: String::new(),
        image: view.image,
        failed: None,
        result: None,
    }
}

/// Records why a cell has no numbers, and goes on.
pub(super) fn record_failure(
    task: &Task,
    view: &MatrixView,
    spec: &CellSpec,
    error: &Error,
    observe: Observer,
) -> Result<()> {
    let cell = Cell {
        failed: Some(error.to_string()),
        ..bare_cell(task, view, spec)
    };
    task.put_cell(view, &cell)?;
    tell(observe, Event::Cell(Box::new(cell)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::PassTimes;

    fn round(generate: Option<f64>) -> Round {
        Round {
            times: PassTimes {
                generate,
                march: Some(2.0),
                refused: generate.is_none(),
                ..PassTimes::default()
            },
            total_ms: generate.map(|ms| ms + 2.0),
            ..Round::default()
        }
    }

    #[test]
    fn a_round_without_a_time_is_null_in_its_place_and_in_no_statistic() {
        let rounds = [round(Some(1.0)), round(None), round(Some(3.0))];
        let total = each_round(&rounds, |round| round.total_ms);
        assert_eq!(total, [Some(3.0), None, Some(5.0)]);
        let stats = times(&rounds).total.expect("statistics");
        assert_eq!((stats.n, stats.median), (2, 4.0));
        assert_eq!(each_round(&[round(None)], |round| round.total_ms), []);
    }
}
