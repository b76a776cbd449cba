//! Explains large errors of the cost models, in sentences with numbers.

use super::{COUNTS, Cost, LARGE, MethodCost, work};
use crate::report::format::{number, percent, signed_percent};

/// Reasons for errors above 20 %: first of the one-price model, then of the method's own.
pub(super) fn why(
    cost: &MethodCost,
    cells: &[&Cost],
    errors: &[f64],
    one_price_ns: f64,
) -> Vec<String> {
    let mut why = Vec::new();
    if cost.one_price_worst.abs() > LARGE {
        let paid: Vec<String> = COUNTS
            .iter()
            .zip(cost.prices_ns)
            .filter(|(_, ns)| *ns > 0.0)
            .map(|(name, ns)| format!("{} ns a {name}", number(ns)))
            .collect();
        let counted: f64 = cells.iter().map(|c| work(c)).sum();
        let view: f64 = cells.iter().map(|c| c.counts[0]).sum();
        why.push(format!(
            "One price is off by up to {}: it counts {} ns for everything where {} takes {}, and leaves out the samples of \
             the view march, {} for each one counted.",
            signed_percent(cost.one_price_worst),
            number(one_price_ns),
            cost.method,
            paid.join(", "),
            number(view / counted)
        ));
    }
    if cost.worst.abs() > LARGE {
        why.push(own_reason(cost, cells, errors));
    }
    why
}

/// The possible cause with which the errors of the method's own model correlate most.
fn own_reason(cost: &MethodCost, cells: &[&Cost], errors: &[f64]) -> String {
    let at = |i: usize| {
        if errors[i].abs() == cost.worst.abs() {
            Some(i)
        } else {
            None
        }
    };
    let noisy = (0..cells.len())
        .find_map(at)
        .map_or(0.0, |i| cells[i].spread);
    let causes: [(&str, Vec<f64>); 4] = [
        (
            "the share of cloud pixels, as branches would that neighbouring rays take apart",
            cells.iter().map(|c| c.cloud).collect(),
        ),
        (
            "the light samples of a view sample, as marches would that end early or late",
            cells
                .iter()
                .map(|c| c.counts[1] / c.counts[0].max(1.0))
                .collect(),
        ),
        (
            "the size of the map, as caches would",
            cells.iter().map(|c| c.map_bytes.max(1.0).ln()).collect(),
        ),
        (
            "the time itself, as a fixed cost of a picture would, which no count has",
            cells.iter().map(|c| c.total_ms.ln()).collect(),
        ),
    ];
    let strongest = causes
        .iter()
        .map(|(name, values)| (*name, correlation(values, errors)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let mut text = format!(
        "Prices of its own are off by up to {}; the repeats of that cell spread by {}.",
        signed_percent(cost.worst),
        percent(noisy)
    );
    if noisy >= cost.worst.abs() {
        text += " That is no more than noise.";
    }
    if let Some((name, r)) = strongest.filter(|(_, r)| r.abs() >= 0.5) {
        text += &format!(" The errors go with {name}: correlation {r:.2}.");
    } else if let Some((_, r)) = strongest {
        text += &format!(
            " They go with none of cloud share, light samples, map size or time (|correlation| ≤ {:.2}).",
            r.abs()
        );
    }
    text
}

/// Pearson's correlation coefficient; 0 where one of the two does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| f(a - ma, b - mb)).sum()
    };
    let norm = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if norm > 0.0 {
        sum(&|a, b| a * b) / norm
    } else {
        0.0
    }
}
