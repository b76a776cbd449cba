//! Predicates on numbers along an axis: straight line, crossover of two series, relative decrease of an error.

use super::super::interval::{CONFIDENCE, Interval};
use super::super::paired::without_drift;
use super::super::select::{self, Found, Records, short_axis};
use super::{Finding, Verdict};
use crate::config::Pick;
use crate::report::format::{number, percent};

/// Smallest number of points from which a line can be told from a curve.
const FEWEST_POINTS: usize = 3;

/// Tests that a number grows along a straight line: `bend` is the limit of the largest residual over the range of the
/// values. With a limit for the intercept, as a share of the largest value, also tests proportionality. The drift that
/// cells of the same rounds share is removed first.
pub fn straight(
    records: &Records<'_>,
    metric: &str,
    of: &Pick,
    along: &str,
    (bend, intercept): (f64, Option<f64>),
) -> Result<Finding, String> {
    let points = records.along(of, along)?;
    let cells: Vec<Found<'_>> = points.iter().map(|(_, found)| *found).collect();
    if cells.len() < FEWEST_POINTS {
        return Err(format!(
            "{} points cannot tell a line from a curve",
            cells.len()
        ));
    }
    let numbers = cells.iter().map(|found| select::metric(found, metric));
    let numbers = without_drift(numbers.collect::<Result<_, String>>()?)?;
    let axis = points.iter().map(|(x, _)| *x);
    let values: Vec<(f64, Interval)> = axis.zip(numbers.iter().map(|n| n.interval)).collect();
    let line = FittedLine::through(&values);
    let ends = [values[0].1.value, values[values.len() - 1].1.value];
    let largest = values.iter().map(|(_, y)| y.value).fold(f64::MIN, f64::max);
    let least = values.iter().map(|(_, y)| y.value).fold(f64::MAX, f64::min);
    let range = (largest - least).max(f64::MIN_POSITIVE);
    let noise = values.iter().map(|(_, y)| y.half_width());
    let noise = noise.fold(0.0, f64::max) / range;
    let bent = values
        .iter()
        .map(|point| line.off(point))
        .fold(0.0, f64::max)
        / range;
    let mut verdicts = vec![limited(bent, noise, bend), growing(line.slope)];
    let mut text = format!(
        "{metric} of {} along {}: {} to {}, {} per unit, off a line by {} of the range (wanted ≤ {}), spread of repeats ±{}",
        records.words(of),
        short_axis(along),
        number(ends[0]),
        number(ends[1]),
        line.slope,
        percent(bent),
        percent(bend),
        percent(noise)
    );
    if let Some(limit) = intercept {
        let share = line.intercept.size().over(Interval::exact(largest))?;
        text += &format!(
            "; intercept {share} of the largest (wanted ≤ {})",
            number(limit)
        );
        verdicts.push(Verdict::within(share.low, share.high, (0.0, limit)));
    }
    if cells
        .iter()
        .any(|c| c.numbers.reference != cells[0].numbers.reference)
    {
        text += "; the pictures were timed one after the other, what the machine did between them is in no spread";
    }
    let verdict = Verdict::all(verdicts.iter().copied());
    Ok(Finding::new(verdict, text, &cells))
}

/// Tests that a slope is positive over its whole interval.
fn growing(slope: Interval) -> Verdict {
    if slope.low > 0.0 {
        Verdict::Holds
    } else if slope.high <= 0.0 {
        Verdict::Fails
    } else {
        Verdict::Undecidable
    }
}

/// Tests a deviation against its limit, where up to `noise` of it may be due to the spread of the repeats. Undecidable
/// where the noise alone exceeds the limit.
fn limited(deviation: f64, noise: f64, limit: f64) -> Verdict {
    Verdict::within(
        (deviation - noise).max(0.0),
        deviation.max(noise),
        (0.0, limit),
    )
}

/// Least-squares line. The points' errors are taken as independent: their half-widths, weighted as in the fit, are
/// added in quadrature.
struct FittedLine {
    intercept: Interval,
    slope: Interval,
}

impl FittedLine {
    fn through(points: &[(f64, Interval)]) -> Self {
        let n = points.len() as f64;
        let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / n;
        let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        let slope = |x: f64| (x - mean_x) / square;
        Self {
            intercept: weighted(points, |x| 1.0 / n - mean_x * slope(x)),
            slope: weighted(points, slope),
        }
    }

    /// Absolute residual of a point.
    fn off(&self, (x, y): &(f64, Interval)) -> f64 {
        (y.value - self.intercept.value - self.slope.value * x).abs()
    }
}

/// Σ weight(x)·y, with half-width √Σ(weight(x)·half-width)².
fn weighted(points: &[(f64, Interval)], weight: impl Fn(f64) -> f64) -> Interval {
    let value: f64 = points.iter().map(|(x, y)| weight(*x) * y.value).sum();
    let square: f64 = points
        .iter()
        .map(|(x, y)| (weight(*x) * y.half_width()).powi(2))
        .sum();
    Interval {
        low: value - square.sqrt(),
        value,
        high: value + square.sqrt(),
    }
}

/// Where the ratio of two series passes 1: an interval of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing {
    /// Between two values of the axis; an end is `None` where the sweep ends before it.
    Between(Option<f64>, Option<f64>),
    /// The order changes more than once, or the wrong way.
    Tangled,
    /// The interval of the ratio contains 1 at every value of the axis.
    Unclear,
}

/// Crossing of ratios, by growing x, that are first below 1 and then above.
pub fn crossing(ratios: &[(f64, Interval)]) -> Crossing {
    let below = |(_, r): &&(f64, Interval)| r.high < 1.0;
    let above = |(_, r): &&(f64, Interval)| r.low > 1.0;
    let last_below = ratios.iter().rfind(below).map(|p| p.0);
    let first_above = ratios.iter().find(above).map(|p| p.0);
    match (last_below, first_above) {
        (None, None) => Crossing::Unclear,
        (Some(low), Some(high)) if low > high => Crossing::Tangled,
        (low, high) => Crossing::Between(low, high),
    }
}

/// Tests that the ratio of two series, first below 1, crosses 1 between two values of the axis.
pub fn crossover(
    records: &Records<'_>,
    metric: &str,
    (of, over): (&Pick, &Pick),
    along: &str,
    wanted: (f64, f64),
) -> Result<Finding, String> {
    let (first, second) = (records.along(of, along)?, records.along(over, along)?);
    let (mut ratios, mut cells) = (Vec::new(), Vec::new());
    // One comparison for each value of the axis: Bonferroni correction.
    let confidence = 1.0 - (1.0 - CONFIDENCE) / first.len() as f64;
    for (x, a) in &first {
        let Some((_, b)) = second.iter().find(|(other, _)| other == x) else {
            return Err(format!(
                "{} has no cell at {} = {x}",
                records.words(over),
                short_axis(along)
            ));
        };
        let ratio = select::ratio(a, b, metric)?;
        ratios.push((*x, ratio.range_at(confidence)?));
        cells.extend([*a, *b]);
    }
    let crossing = crossing(&ratios);
    let verdict = match crossing {
        Crossing::Unclear => Verdict::Undecidable,
        Crossing::Tangled => Verdict::Fails,
        Crossing::Between(low, high) => Verdict::within(
            low.unwrap_or(f64::NEG_INFINITY),
            high.unwrap_or(f64::INFINITY),
            wanted,
        ),
    };
    let listed: Vec<String> = ratios
        .iter()
        .map(|(x, r)| format!("{} at {}", r, number(*x)))
        .collect();
    let text = format!(
        "{}; {metric} of {} ÷ {}: {}; wanted between {} and {}",
        place(crossing, ratios[0].0, ratios[ratios.len() - 1].0),
        records.words(of),
        records.words(over),
        listed.join(", "),
        number(wanted.0),
        number(wanted.1)
    );
    Ok(Finding::new(verdict, text, &cells))
}

fn place(crossing: Crossing, first: f64, last: f64) -> String {
    match crossing {
        Crossing::Between(Some(low), Some(high)) => {
            format!("crosses between {} and {}", number(low), number(high))
        }
        Crossing::Between(Some(low), None) => format!(
            "no crossing up to {}: still below at {}",
            number(last),
            number(low)
        ),
        Crossing::Between(None, Some(high)) => format!(
            "above from {} on, the sweep begins at {}",
            number(high),
            number(first)
        ),
        Crossing::Tangled => "the order changes the other way round, or more than once".to_owned(),
        Crossing::Between(None, None) | Crossing::Unclear => {
            "the two are nowhere told apart".to_owned()
        }
    }
}

/// Tests that an error decreases by at most a share of itself (`at_most`) between two values of an axis.
pub fn gain(
    records: &Records<'_>,
    metric: &str,
    (of, along): (&Pick, &str),
    (from, to): (f64, f64),
    at_most: f64,
) -> Result<Finding, String> {
    let points = records.along(of, along)?;
    let at = |x: f64| {
        let found = points.iter().find(|(value, _)| *value == x);
        found.map(|(_, found)| *found).ok_or_else(|| {
            format!(
                "{} has no cell at {} = {x}",
                records.words(of),
                short_axis(along)
            )
        })
    };
    let cells = [at(from)?, at(to)?];
    let (before, after) = (
        select::metric(&cells[0], metric)?,
        select::metric(&cells[1], metric)?,
    );
    let gain = before.minus(&after)?.over(&before)?.interval;
    let (before, after) = (before.interval, after.interval);
    let text = format!(
        "{metric} of {} at {} = {from}: {before}, at {to}: {after}, gain {} (wanted ≤ {})",
        records.words(of),
        short_axis(along),
        percent(gain.value),
        percent(at_most)
    );
    let verdict = Verdict::within(gain.low, gain.high, (f64::NEG_INFINITY, at_most));
    Ok(Finding::new(verdict, text, &cells))
}
