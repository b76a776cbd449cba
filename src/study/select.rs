//! Cells by what a study says of them, and their numbers with the spread of their repeats.
//!
//! Every failure is a reason in words: a verdict or a chart repeats it, nothing is dropped silently.

use super::interval::Interval;
use crate::batch::record::{Cell, Measured, Report};
use crate::config::{Pick, Quantity, Series};
use crate::metrics::Stats;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Reports of a study's experiments by id, and its series.
#[derive(Clone, Copy)]
pub struct Records<'a> {
    /// Id of the experiment and its report, in the study's order.
    pub reports: &'a [(String, Report)],
    /// Series by name.
    pub series: &'a BTreeMap<String, Series>,
}

/// A cell that was found, with its experiment's report.
#[derive(Clone, Copy)]
pub struct Found<'a> {
    /// Id of the experiment.
    pub experiment: &'a str,
    /// Its report.
    pub report: &'a Report,
    /// The cell.
    pub cell: &'a Cell,
    /// Its numbers.
    pub numbers: &'a Measured,
}

impl<'a> Records<'a> {
    /// The report of an experiment.
    pub fn report(&self, id: &str) -> Result<(&'a str, &'a Report), String> {
        let found = self.reports.iter().find(|(name, _)| name == id);
        found
            .map(|(name, report)| (name.as_str(), report))
            .ok_or_else(|| format!("experiment `{id}` has no records"))
    }

    /// Words for a series.
    pub fn label<'n>(&self, name: &'n str) -> &'n str
    where
        'a: 'n,
    {
        let series = self.series.get(name);
        series
            .and_then(|series| series.label.as_deref())
            .unwrap_or(name)
    }

    /// Method of a series.
    pub fn method<'n>(&self, name: &'n str) -> &'n str
    where
        'a: 'n,
    {
        self.series.get(name).map_or(name, |s| s.method.as_str())
    }

    /// Every cell of a pick, failed ones included.
    fn cells(&self, pick: &Pick) -> Result<(&'a str, &'a Report, Vec<&'a Cell>), String> {
        let (experiment, report) = self.report(&pick.experiment)?;
        let series = self.series.get(&pick.series);
        let series = series.ok_or_else(|| format!("there is no series `{}`", pick.series))?;
        let fits = |cell: &&Cell| {
            cell.method == series.method && matches(cell, &series.at) && matches(cell, &pick.at)
        };
        Ok((
            experiment,
            report,
            report.cells.iter().filter(fits).collect(),
        ))
    }

    /// The one cell of a pick.
    pub fn find(&self, pick: &Pick) -> Result<Found<'a>, String> {
        let (experiment, report, cells) = self.cells(pick)?;
        let cell = match cells[..] {
            [cell] => cell,
            ref cells => {
                return Err(format!(
                    "{} cells fit {} in `{experiment}`, one is needed",
                    cells.len(),
                    self.words(pick)
                ));
            }
        };
        Ok(Found {
            experiment,
            report,
            cell,
            numbers: numbers(cell, &self.words(pick))?,
        })
    }

    /// Cells of a pick by growing value of an axis; no value twice. A failed cell is a reason, not a gap.
    pub fn along(&self, pick: &Pick, axis: &str) -> Result<Vec<(f64, Found<'a>)>, String> {
        let (experiment, report, cells) = self.cells(pick)?;
        let mut points = Vec::with_capacity(cells.len());
        for cell in cells {
            let numbers = numbers(cell, &self.words(pick))?;
            let x = value_of(cell, axis)
                .ok_or_else(|| format!("a cell of {} has no number `{axis}`", self.words(pick)))?;
            let found = Found {
                experiment,
                report,
                cell,
                numbers,
            };
            points.push((x, found));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        match points.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(format!(
                "two cells of {} have {axis} = {}",
                self.words(pick),
                pair[0].0
            )),
            None if points.is_empty() => Err(format!(
                "no cell of `{experiment}` fits {}",
                self.words(pick)
            )),
            None => Ok(points),
        }
    }

    /// A number of the study with its spread.
    pub fn quantity(&self, quantity: &Quantity) -> Result<(Interval, Vec<Found<'a>>), String> {
        let found = self.find(&quantity.of)?;
        let value = metric(&found, &quantity.metric)?;
        let Some(minus) = &quantity.minus else {
            return Ok((value, vec![found]));
        };
        let other = self.find(minus)?;
        let subtracted = metric(&other, &quantity.metric)?;
        Ok((value.minus(subtracted), vec![found, other]))
    }

    /// A pick in words: `esm at resolution = 256`.
    pub fn words(&self, pick: &Pick) -> String {
        let mut words = self.label(&pick.series).to_owned();
        for (i, (axis, value)) in pick.at.iter().enumerate() {
            let join = if i == 0 { " at " } else { ", " };
            words += &format!("{join}{} = {}", short_axis(axis), plain(value));
        }
        words
    }
}

/// An axis without the path to it.
pub fn short_axis(axis: &str) -> &str {
    axis.rsplit('/').next().unwrap_or(axis)
}

fn plain(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

fn numbers<'a>(cell: &'a Cell, words: &str) -> Result<&'a Measured, String> {
    cell.result.as_ref().ok_or_else(|| {
        let reason = cell.failed.as_deref().unwrap_or("no reason recorded");
        format!("a cell of {words} failed: {reason}")
    })
}

/// Whether a cell has these axis values.
pub fn matches(cell: &Cell, at: &Map<String, Value>) -> bool {
    at.iter().all(|(axis, value)| has(cell, axis, value))
}

fn has(cell: &Cell, axis: &str, wanted: &Value) -> bool {
    let equal = |value: &Value| match (value.as_f64(), wanted.as_f64()) {
        (Some(a), Some(b)) => a == b,
        _ => value == wanted,
    };
    match axis {
        "width" | "height" | "pixels" => value_of(cell, axis) == wanted.as_f64(),
        axis => member(cell, axis).is_some_and(equal),
    }
}

fn member<'a>(cell: &'a Cell, axis: &str) -> Option<&'a Value> {
    let members: &Map<String, Value> = match axis.starts_with('/') {
        true => &cell.scene_set,
        false => &cell.params,
    };
    members.get(axis)
}

/// Value of an axis at a cell.
pub fn value_of(cell: &Cell, axis: &str) -> Option<f64> {
    let (width, height) = (f64::from(cell.image.width), f64::from(cell.image.height));
    match axis {
        "width" => Some(width),
        "height" => Some(height),
        "pixels" => Some(width * height),
        "cloud_pixel_fraction" => cell.result.as_ref().map(|r| r.cloud_pixel_fraction),
        axis => member(cell, axis)?.as_f64(),
    }
}

/// A number of a cell. Times have the spread of their repeats, all else none.
pub fn metric(found: &Found<'_>, name: &str) -> Result<Interval, String> {
    let numbers = found.numbers;
    let (time, error, memory) = (&numbers.time_ms, &numbers.error, &numbers.memory);
    let exact = match name {
        "total_ms" => {
            let stats = found.report.clock().cost(time);
            return spread(&numbers.rounds_total_ms, stats, name);
        }
        "generate_ms" => return spread(&numbers.rounds_generate_ms, time.generate, name),
        "payload_bytes" => Some(memory.payload_bytes as f64),
        "map_bytes" => Some(memory.map_bytes as f64),
        "rel_rmse" => Some(error.rel_rmse),
        "floor_rel_rmse" => error.floor_rel_rmse,
        "bias" => Some(error.bias),
        "leak" => Some(error.leak),
        "darken" => Some(-error.darken),
        "p99_abs" => Some(error.p99_abs),
        "transmittance_rmse" => Some(error.transmittance_rmse),
        "edge_bias" => error.edge_bias,
        "flip_mean" => Some(error.flip_mean),
        "flicker" => error.flicker,
        "flicker_sun" => error.flicker_sun,
        "cloud_pixel_fraction" => Some(numbers.cloud_pixel_fraction),
        _ => return Err(format!("no number is named `{name}`")),
    };
    let missing = || format!("{} has no {name}", found.cell.method);
    exact.map(Interval::exact).ok_or_else(missing)
}

/// A time by its rounds; by its statistics where the rounds are not recorded, as with the wall clock.
fn spread(rounds: &[f64], stats: Option<Stats>, name: &str) -> Result<Interval, String> {
    let stats = stats.ok_or_else(|| format!("the adapter gives no {name}"))?;
    if rounds.is_empty() {
        let repeats = vec![stats.median; stats.n];
        return Interval::of_repeats(&repeats).map(|median| Interval {
            low: stats.min,
            high: stats.p95,
            ..median
        });
    }
    Interval::of_repeats(rounds)
}

/// Ratio of a number of two cells; device times of one view are divided round by round.
pub fn ratio(of: &Found<'_>, to: &Found<'_>, name: &str) -> Result<Interval, String> {
    let rounds = |found: &Found<'_>| match name {
        "total_ms" => found.numbers.rounds_total_ms.clone(),
        "generate_ms" => found.numbers.rounds_generate_ms.clone(),
        _ => Vec::new(),
    };
    let (a, b) = (rounds(of), rounds(to));
    let same_view = of.experiment == to.experiment && of.numbers.reference == to.numbers.reference;
    if same_view && !a.is_empty() && a.len() == b.len() && b.iter().all(|ms| *ms > 0.0) {
        let ratios: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a / b).collect();
        return Interval::of_repeats(&ratios);
    }
    metric(of, name)?.over(metric(to, name)?)
}
