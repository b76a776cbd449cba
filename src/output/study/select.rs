//! Selects the cells that a study's picks describe and reads their numbers with the spread of their repeats.
//!
//! Every error is a reason in words that the verdict or the chart shows; no missing number is dropped silently.

use super::interval::Interval;
use super::paired::{Block, Repeated};
use crate::batch::numbers::study_number;
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

/// A cell that has numbers, with the report of its experiment.
#[derive(Clone, Copy)]
pub struct Found<'a> {
    /// Id of the experiment.
    pub experiment: &'a str,
    /// Report of the experiment.
    pub report: &'a Report,
    /// The cell.
    pub cell: &'a Cell,
    /// Numbers of the cell.
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

    /// Label of a series, or its name where it has none.
    pub fn label<'n>(&self, name: &'n str) -> &'n str
    where
        'a: 'n,
    {
        label(self.series, name)
    }

    /// Method id of a series.
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
        let cells = report.cells.iter();
        let fitting = cells.filter(|cell| fits(cell, series, pick)).collect();
        Ok((experiment, report, fitting))
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

    /// Cells of a pick by growing value of an axis. An error where a value occurs twice, a cell failed or none fits.
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

    /// A quantity (a number of one cell, or the difference of two cells) with its spread, and the cells it is from.
    pub fn quantity(&self, quantity: &Quantity) -> Result<(Repeated, Vec<Found<'a>>), String> {
        let found = self.find(&quantity.of)?;
        let value = metric(&found, &quantity.metric)?;
        let Some(minus) = &quantity.minus else {
            return Ok((value, vec![found]));
        };
        let other = self.find(minus)?;
        let subtracted = metric(&other, &quantity.metric)?;
        Ok((value.minus(&subtracted)?, vec![found, other]))
    }

    /// A pick in words: `esm at resolution = 256`.
    pub fn words(&self, pick: &Pick) -> String {
        words(self.series, pick)
    }
}

fn label<'n>(series: &'n BTreeMap<String, Series>, name: &'n str) -> &'n str {
    let series = series.get(name);
    series
        .and_then(|series| series.label.as_deref())
        .unwrap_or(name)
}

/// A pick in words: `esm at resolution = 256`.
pub fn words(series: &BTreeMap<String, Series>, pick: &Pick) -> String {
    let mut words = label(series, &pick.series).to_owned();
    for (i, (axis, value)) in pick.at.iter().enumerate() {
        let join = if i == 0 { " at " } else { ", " };
        words += &format!("{join}{} = {}", short_axis(axis), plain(value));
    }
    words
}

/// Whether a cell belongs to a pick of a series.
pub fn fits(cell: &Cell, series: &Series, pick: &Pick) -> bool {
    cell.method == series.method && matches(cell, &series.at) && matches(cell, &pick.at)
}

/// Last segment of an axis path.
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

/// Value of an axis at a cell: size of its image in px, share of cloud pixels, scene member or parameter.
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

/// A number of a cell by its name, one of [`study_names`](crate::batch::numbers::study_names). Times have the spread of
/// their repeats; all other numbers are exact.
pub fn metric(found: &Found<'_>, name: &str) -> Result<Repeated, String> {
    let number = study_number(name).ok_or_else(|| format!("no number is named `{name}`"))?;
    if let Some(repeats) = number.repeats {
        let stats = (repeats.stats)(found.numbers, found.report.clock());
        return spread(found, (repeats.rounds)(found.numbers), stats, name);
    }
    let value = number.study_value(found.numbers);
    value
        .map(|value| Interval::exact(value).into())
        .ok_or_else(|| format!("{} has no {name}", found.cell.method))
}

/// A time by its rounds; by its minimum, median and 95th percentile where the rounds are not recorded, as with the wall
/// clock. Where a round has no time, the result cannot be paired with another cell round by round.
fn spread(
    found: &Found<'_>,
    rounds: &[Option<f64>],
    stats: Option<Stats>,
    name: &str,
) -> Result<Repeated, String> {
    let stats = stats.ok_or_else(|| format!("the adapter gives no {name}"))?;
    if rounds.is_empty() {
        let median = Interval::of_repeats(&vec![stats.median; stats.n])?;
        let range = Interval {
            low: stats.min,
            high: stats.p95,
            ..median
        };
        return Ok(range.into());
    }
    let block = Block {
        experiment: found.experiment.to_owned(),
        reference: found.numbers.reference.clone(),
        first: found.numbers.block,
    };
    let times: Vec<f64> = rounds.iter().copied().flatten().collect();
    match times.len() == rounds.len() {
        true => Repeated::of_rounds(block, times),
        false => Ok(Interval::of_repeats(&times)?.into()),
    }
}

/// Ratio `of` ÷ `to` of a number of two cells; times of the same rounds are divided round by round.
pub fn ratio(of: &Found<'_>, to: &Found<'_>, name: &str) -> Result<Repeated, String> {
    metric(of, name)?.over(&metric(to, name)?)
}

#[cfg(test)]
mod tests {
    use super::super::fixture::FixtureReport;
    use super::*;
    use crate::batch::numbers::study_names;
    use crate::metrics::METRICS;
    use serde_json::json;

    #[test]
    fn every_named_number_is_known_and_darkening_is_a_size() {
        let mut made = FixtureReport::new(&["a"]);
        let cell = made.cell("a", json!({}), &[1.0, 2.0, 3.0]);
        if let Some(result) = &mut cell.result {
            let keys = METRICS.iter().map(|metric| metric.key.to_owned());
            let all: Value = keys.map(|key| (key, json!(1))).collect();
            result.error = serde_json::from_value(all).unwrap();
            result.error.darken = -0.25;
        }
        let records = made.records();
        let pick = super::super::fixture::pick("a", json!({}));
        let found = records.find(&pick).unwrap();
        for name in study_names() {
            metric(&found, name).unwrap();
        }
        for error in METRICS {
            assert!(study_names().any(|name| name == error.key), "{error:?}");
        }
        for name in [
            "total_ms",
            "generate_ms",
            "payload_bytes",
            "map_bytes",
            "cloud_pixel_fraction",
        ] {
            assert!(study_names().any(|known| known == name), "{name}");
        }
        assert_eq!(metric(&found, "darken").unwrap().interval.value, 0.25);
        let error = metric(&found, "beauty").unwrap_err();
        assert!(error.contains("no number is named"), "{error}");
    }

    #[test]
    fn rounds_of_which_one_has_no_time_are_not_paired() {
        let mut made = FixtureReport::new(&["a", "b"]);
        made.cell("a", json!({}), &[1.0, 2.0, 3.0, 4.0, 5.0]);
        made.cell("b", json!({}), &[2.0, 4.0, 6.0, 8.0, 10.0]);
        let range = |made: &FixtureReport| {
            let records = made.records();
            let found = ["b", "a"]
                .map(|method| records.find(&super::super::fixture::pick(method, json!({}))));
            let [b, a] = found.map(Result::unwrap);
            ratio(&b, &a, "total_ms").unwrap().interval
        };
        assert_eq!((range(&made).low, range(&made).high), (2.0, 2.0));
        for cell in &mut made.reports[0].1.cells {
            let result = cell.result.as_mut().unwrap();
            result.rounds_total_ms[1] = None;
        }
        assert_eq!((range(&made).low, range(&made).high), (0.4, 10.0));
    }

    #[test]
    fn without_rounds_a_time_spans_its_statistics() {
        let mut made = FixtureReport::new(&["a"]);
        let cell = made.cell("a", json!({}), &[10.0, 12.0, 11.0, 30.0]);
        if let Some(result) = &mut cell.result {
            result.rounds_total_ms.clear();
        }
        let records = made.records();
        let pick = super::super::fixture::pick("a", json!({}));
        let time = metric(&records.find(&pick).unwrap(), "total_ms").unwrap();
        assert_eq!((time.interval.low, time.interval.high), (10.0, 30.0));
    }
}
