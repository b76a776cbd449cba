//! Checks a study before its experiments run: every pick must match cells of the expanded matrices, every number must
//! have a known name.

use super::select;
use crate::batch::numbers::{study_names, study_number};
use crate::batch::planned_cell;
use crate::batch::record::Cell;
use crate::config::{Evidence, Matrix, Pick, Quantity, Question, Study, Test, suggestion};
use crate::error::{Error, Result};
use serde_json::{Map, Value};

/// Rejects a study that asks for a cell or a number that its experiments cannot have; `matrices` are in the order of
/// the experiments.
pub fn check(study: &Study, matrices: &[Matrix]) -> Result<()> {
    let cells = |matrix: &Matrix| {
        let views = matrix.views.iter();
        let cells = views.flat_map(|v| v.cells.iter().map(move |spec| planned_cell(v, spec)));
        cells.collect()
    };
    let planned = Planned {
        study,
        cells: matrices.iter().map(cells).collect(),
    };
    planned.claims()?;
    planned.charts_and_tables()?;
    planned.errata()?;
    planned.guide()
}

/// A study with the planned cells of each experiment.
struct Planned<'a> {
    study: &'a Study,
    cells: Vec<Vec<Cell>>,
}

impl Planned<'_> {
    fn claims(&self) -> Result<()> {
        for claim in &self.study.claims {
            for part in &claim.checks {
                let place = format!("claim {}, “{}”", claim.id, part.says);
                self.test(&place, &part.test)?;
            }
        }
        Ok(())
    }

    fn test(&self, place: &str, test: &Test) -> Result<()> {
        match test {
            Test::Range { of, .. } => self.quantity(place, of),
            Test::Ratio { of, to, .. } => {
                self.quantity(place, of)?;
                self.quantity(place, to)
            }
            Test::Order { metric, ascending } => {
                self.metric(place, metric)?;
                ascending
                    .iter()
                    .flatten()
                    .try_for_each(|pick| self.one(place, pick))
            }
            Test::Straight {
                metric, of, along, ..
            } => self.curve(place, metric, of, along),
            Test::Crossover {
                metric,
                of,
                over,
                along,
                ..
            } => {
                self.curve(place, metric, of, along)?;
                self.curve(place, metric, over, along)
            }
            Test::Gain {
                metric,
                of,
                along,
                from,
                to,
                ..
            } => {
                self.curve(place, metric, of, along)?;
                [from, to].into_iter().try_for_each(|x| {
                    let at = Map::from_iter([(along.clone(), Value::from(*x))]);
                    self.one(place, &with(of, &at))
                })
            }
            Test::Unmeasured { .. } => Ok(()),
        }
    }

    fn charts_and_tables(&self) -> Result<()> {
        for chart in &self.study.charts {
            let place = format!("chart `{}`", chart.id);
            let metrics = [Some(&chart.metric), chart.also.as_ref()];
            for metric in metrics.into_iter().flatten() {
                for series in &chart.series {
                    let pick = pick(&chart.experiment, series, &chart.at);
                    self.curve(&place, metric, &pick, &chart.along)?;
                }
            }
            if let Some(unit) = &chart.relative_to {
                let pick = pick(&chart.experiment, unit, &Map::new());
                self.some(&place, &pick)?;
            }
        }
        for table in &self.study.tables {
            let place = format!("table `{}`", table.id);
            let metrics = table.metrics.iter();
            metrics
                .map(|column| &column.metric)
                .chain(table.rows.iter().flat_map(|row| row.published.keys()))
                .try_for_each(|metric| self.metric(&place, metric))?;
            for row in &table.rows {
                self.one(&place, &pick(&table.experiment, &row.series, &row.at))?;
            }
        }
        Ok(())
    }

    fn errata(&self) -> Result<()> {
        for erratum in &self.study.errata {
            let place = format!("erratum “{}”", erratum.place);
            match &erratum.evidence {
                Evidence::Number { measured, .. } => self.quantity(&place, measured)?,
                Evidence::Cells { printed, meant } => {
                    self.quantity(&place, printed)?;
                    self.quantity(&place, meant)?;
                }
                Evidence::Truths {
                    experiment,
                    printed,
                    meant,
                    limit,
                } => {
                    for set in [printed, meant, limit] {
                        let found = self
                            .experiment(experiment)
                            .iter()
                            .any(|cell| set.iter().all(|(k, v)| cell.scene_set.get(k) == Some(v)));
                        if !found {
                            let set = Value::from(set.clone());
                            return Err(self.error(&place, format!("no view has {set}")));
                        }
                    }
                }
                Evidence::Text { .. } => {}
            }
        }
        Ok(())
    }

    fn guide(&self) -> Result<()> {
        for question in &self.study.guide {
            match question {
                Question::Along {
                    title,
                    metric,
                    experiment,
                    along,
                    series,
                    at,
                    ..
                } => {
                    for name in series {
                        let place = format!("question “{title}”");
                        self.curve(&place, metric, &pick(experiment, name, at), along)?;
                    }
                }
                Question::Within {
                    title,
                    metric,
                    experiment,
                    series,
                    at,
                    budget,
                    ..
                } => {
                    let place = format!("question “{title}”");
                    let metrics = [Some(metric), budget.as_ref()];
                    for metric in metrics.into_iter().flatten() {
                        self.metric(&place, metric)?;
                    }
                    for name in series {
                        self.one(&place, &pick(experiment, name, at))?;
                    }
                }
            }
        }
        Ok(())
    }

    fn quantity(&self, place: &str, quantity: &Quantity) -> Result<()> {
        self.metric(place, &quantity.metric)?;
        let picks = [Some(&quantity.of), quantity.minus.as_ref()];
        picks
            .into_iter()
            .flatten()
            .try_for_each(|pick| self.one(place, pick))
    }

    fn curve(&self, place: &str, metric: &str, of: &Pick, along: &str) -> Result<()> {
        self.metric(place, metric)?;
        let fitting = self.some(place, of)?;
        let measured = study_number(along).is_some();
        match measured || fitting.iter().all(|c| select::value_of(c, along).is_some()) {
            true => Ok(()),
            false => {
                let problem = format!("cells of {} have no number `{along}`", self.words(of));
                Err(self.error(place, problem))
            }
        }
    }

    fn some(&self, place: &str, of: &Pick) -> Result<Vec<&Cell>> {
        let fitting = self.fitting(of);
        match fitting.is_empty() {
            true => Err(self.error(place, format!("no cell fits {}", self.words(of)))),
            false => Ok(fitting),
        }
    }

    fn one(&self, place: &str, pick: &Pick) -> Result<()> {
        match self.fitting(pick).len() {
            1 => Ok(()),
            n => {
                let problem = format!("{n} cells fit {}, one is needed", self.words(pick));
                Err(self.error(place, problem))
            }
        }
    }

    fn metric(&self, place: &str, name: &str) -> Result<()> {
        if study_number(name).is_some() {
            return Ok(());
        }
        let hint = suggestion(name, study_names());
        let known = study_names().collect::<Vec<_>>().join(", ");
        Err(Error::input(
            format!("study `{}`, {place}", self.study.name),
            format!("no number is named `{name}`"),
            format!("{hint}Known are {known}."),
        ))
    }

    fn experiment(&self, id: &str) -> &[Cell] {
        let index = self.study.experiments.iter().position(|e| e.id == id);
        index.map_or(&[], |i| &self.cells[i])
    }

    fn fitting(&self, pick: &Pick) -> Vec<&Cell> {
        let series = self.study.series.get(&pick.series);
        let cells = self.experiment(&pick.experiment).iter();
        cells
            .filter(|cell| series.is_some_and(|series| select::fits(cell, series, pick)))
            .collect()
    }

    fn words(&self, pick: &Pick) -> String {
        let words = select::words(&self.study.series, pick);
        format!("{words} in `{}`", pick.experiment)
    }

    fn error(&self, place: &str, problem: String) -> Error {
        let source = format!(
            "study `{}`, profile {}, {place}",
            self.study.name, self.study.profile
        );
        let remedy = "Correct `series` or `at`, or add the values to the experiment's matrix.";
        Error::input(source, problem, remedy)
    }
}

fn pick(experiment: &str, series: &str, at: &Map<String, Value>) -> Pick {
    Pick {
        experiment: experiment.to_owned(),
        series: series.to_owned(),
        at: at.clone(),
    }
}

fn with(pick: &Pick, at: &Map<String, Value>) -> Pick {
    let mut pick = pick.clone();
    pick.at.extend(at.clone());
    pick
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{expand, load_study};
    use crate::reconstruct::Registry;
    use std::path::Path;

    fn shipped(profile: &str) -> (Study, Vec<Matrix>) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/studies/m.json");
        let study = load_study(&path, profile).unwrap();
        let matrix = |e: &crate::config::StudyExperiment| expand(&e.experiment, &Registry).unwrap();
        let matrices = study.experiments.iter().map(matrix).collect();
        (study, matrices)
    }

    #[test]
    fn the_shipped_study_finds_every_cell_that_it_asks_for_in_both_profiles() {
        for profile in ["quick", "full"] {
            let (study, matrices) = shipped(profile);
            check(&study, &matrices).unwrap();
        }
    }

    #[test]
    fn what_no_cell_can_answer_is_refused_with_its_place() {
        let refused = |edit: &dyn Fn(&mut Study), words: [&str; 2]| {
            let (mut study, matrices) = shipped("quick");
            edit(&mut study);
            let error = check(&study, &matrices).unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)), "{error}");
        };
        refused(
            &|s| s.charts[0].metric = "total_s".to_owned(),
            ["chart `memory-stored`", "total_ms"],
        );
        refused(
            &|s| s.charts[0].along = "resolutions".to_owned(),
            ["chart `memory-stored`", "`resolutions`"],
        );
        refused(
            &|s| {
                let rows = &mut s.tables[0].rows;
                rows[0].at.insert("steps".to_owned(), 11.into());
            },
            ["table `", "0 cells fit"],
        );
        refused(
            &|s| {
                let series = s.series.get_mut("srm10").unwrap();
                series.method = "srn".to_owned();
            },
            ["claim M", "0 cells fit srm 10 steps"],
        );
    }
}
