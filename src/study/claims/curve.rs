//! Predicates on numbers along an axis: straight line, crossover, gain of an error.

use super::super::interval::Interval;
use super::super::select::{self, Found, Records, short_axis};
use super::{Finding, Verdict};
use crate::config::Pick;
use crate::report::format::{number, percent};

/// Fewest points that can bend.
const FEWEST_POINTS: usize = 3;

/// Growth along a straight line; with a limit for the intercept also proportionality.
pub fn straight(
    records: &Records<'_>,
    metric: &str,
    of: &Pick,
    along: &str,
    (bend, intercept): (f64, Option<f64>),
) -> Result<Finding, String> {
    let points = records.along(of, along)?;
    let cells: Vec<Found<'_>> = points.iter().map(|(_, found)| *found).collect();
    let values: Vec<(f64, Interval)> = points
        .iter()
        .map(|(x, found)| Ok((*x, select::metric(found, metric)?)))
        .collect::<Result<_, String>>()?;
    if values.len() < FEWEST_POINTS {
        return Err(format!(
            "{} points cannot tell a line from a curve",
            values.len()
        ));
    }
    let line = line(&values);
    let largest = values.iter().map(|(_, y)| y.value).fold(f64::MIN, f64::max);
    let least = values.iter().map(|(_, y)| y.value).fold(f64::MAX, f64::min);
    let range = (largest - least).max(f64::MIN_POSITIVE);
    let off = |(x, y): &(f64, Interval)| (y.value - line.0 - line.1 * x).abs();
    let noise = values
        .iter()
        .map(|(_, y)| y.half_width())
        .fold(0.0, f64::max)
        / range;
    let bent = values.iter().map(off).fold(0.0, f64::max) / range;
    let mut verdict = limited(bent, noise, bend);
    let mut text = format!(
        "{metric} of {} along {}: {} to {}, {} per unit, off a line by {} of the range (wanted ≤ {}), spread of repeats ±{}",
        records.words(of),
        short_axis(along),
        number(values[0].1.value),
        number(values[values.len() - 1].1.value),
        number(line.1),
        percent(bent),
        percent(bend),
        percent(noise)
    );
    if line.1 <= 0.0 {
        verdict = Verdict::Fails;
        text += ", and it does not grow";
    }
    if let Some(limit) = intercept {
        let share = line.0.abs() / largest;
        text += &format!(
            "; intercept {} of the largest (wanted ≤ {})",
            percent(share),
            percent(limit)
        );
        let noise = noise * range / largest;
        verdict = Verdict::all([verdict, limited(share, noise, limit)].into_iter());
    }
    Ok(Finding::new(verdict, text, &cells))
}

/// A deviation against its limit, where `noise` of it may be due to the repeats: it holds only where noise would not
/// hide more than the limit.
fn limited(deviation: f64, noise: f64, limit: f64) -> Verdict {
    Verdict::within(
        (deviation - noise).max(0.0),
        deviation.max(noise),
        (0.0, limit),
    )
}

/// Least squares: intercept and slope.
fn line(points: &[(f64, Interval)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / n;
    let mean_y = points.iter().map(|(_, y)| y.value).sum::<f64>() / n;
    let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let cross: f64 = points
        .iter()
        .map(|(x, y)| (x - mean_x) * (y.value - mean_y))
        .sum();
    let slope = cross / square;
    (mean_y - slope * mean_x, slope)
}

/// Where one series overtakes another: an interval of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing {
    /// Between two values of the axis; an end is `None` where the sweep ends before it.
    Between(Option<f64>, Option<f64>),
    /// The order changes more than once, or the wrong way.
    Tangled,
    /// Nowhere are the two told apart.
    Unclear,
}

/// The crossing of ratios that are first below 1 and then above, by growing x.
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

/// A crossover between limits.
pub fn crossover(
    records: &Records<'_>,
    metric: &str,
    (of, over): (&Pick, &Pick),
    along: &str,
    wanted: (f64, f64),
) -> Result<Finding, String> {
    let (first, second) = (records.along(of, along)?, records.along(over, along)?);
    let (mut ratios, mut cells) = (Vec::new(), Vec::new());
    for (x, a) in &first {
        let Some((_, b)) = second.iter().find(|(other, _)| other == x) else {
            return Err(format!(
                "{} has no cell at {} = {x}",
                records.words(over),
                short_axis(along)
            ));
        };
        ratios.push((*x, select::ratio(a, b, metric)?));
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
        Crossing::Tangled => "the order changes more than once".to_owned(),
        Crossing::Between(None, None) | Crossing::Unclear => {
            "the two are nowhere told apart".to_owned()
        }
    }
}

/// What an error loses between two values of an axis.
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
    let gain = before.minus(after).over(before)?;
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
