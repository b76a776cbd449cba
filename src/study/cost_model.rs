//! What a sample costs: counted samples against measured times.
//!
//! The thesis's model (eqs. 3.1–3.5) has one price: t = c·N, N = N_view·N_light + N_map, where N_view·N_light are the
//! light samples of a secondary march, or the look-ups in a map. The model of a method has a price for each kind:
//! t = c_view·n_view + c_light·n_light + c_look·n_look + c_map·n_map, c ≥ 0, by least squares of relative errors.
//! All counts come from the shaders.

use super::least_squares::non_negative;
use super::select::Records;
use crate::batch::record::Cell;
use crate::report::format::{number, percent, signed_percent};
use serde::Serialize;
use std::collections::BTreeMap;

/// Names of the counts, in the order of [`Cost::counts`].
pub const COUNTS: [&str; 4] = ["view sample", "light sample", "look-up", "map sample"];
/// Relative error from which a model owes an explanation.
const LARGE: f64 = 0.2;
/// Fewest timed runs of a cell that takes part.
const FEWEST_RUNS: usize = 3;
/// Fewest cells that a method's prices are fitted to.
const FEWEST_CELLS: usize = 6;

/// A cell as the model sees it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Id of the experiment.
    pub experiment: String,
    /// Index of the cell.
    pub index: usize,
    /// Method.
    pub method: String,
    /// View samples, light samples, look-ups, map samples.
    pub counts: [f64; 4],
    /// Measured, ms.
    pub total_ms: f64,
    /// Largest |deviation| of the repeats over the median.
    pub spread: f64,
    /// By the thesis's model, ms.
    pub thesis_ms: f64,
    /// By the method's own model, ms; `None` where it has too few cells.
    pub own_ms: Option<f64>,
    /// Share of cloud pixels.
    pub cloud: f64,
    /// Bytes of its map.
    pub map_bytes: f64,
}

/// The model of one method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodCost {
    /// Method.
    pub method: String,
    /// Cells it was fitted to.
    pub cells: usize,
    /// Nanoseconds a view sample, light sample, look-up, map sample.
    pub prices_ns: [f64; 4],
    /// Share of the variance that the model explains.
    pub r2: f64,
    /// Relative error of the worst cell, with its sign.
    pub worst: f64,
    /// Median of the absolute relative errors.
    pub typical: f64,
    /// The same two numbers of the thesis's model on this method.
    pub thesis_worst: f64,
    /// Median of the thesis's absolute relative errors.
    pub thesis_typical: f64,
    /// Why a model is wrong by more than 20 %, sentences.
    pub why: Vec<String>,
}

/// Both models on one adapter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostModel {
    /// Nanoseconds a sample in the thesis's model.
    pub thesis_ns: f64,
    /// Share of the variance that it explains.
    pub thesis_r2: f64,
    /// One entry a method.
    pub methods: Vec<MethodCost>,
    /// Every cell.
    pub cells: Vec<Cost>,
}

/// The model of all cells that were timed three times or more; `None` without any.
pub fn fit(records: &Records<'_>) -> Option<CostModel> {
    let mut cells = Vec::new();
    for (id, report) in records.reports {
        let clock = report.clock();
        cells.extend(report.cells.iter().filter_map(|cell| {
            let stats = clock.cost(&cell.result.as_ref()?.time_ms)?;
            cost(id, cell, stats)
        }));
    }
    model(cells)
}

fn cost(experiment: &str, cell: &Cell, time: crate::metrics::Stats) -> Option<Cost> {
    let numbers = cell.result.as_ref()?;
    let samples = &numbers.samples;
    let counts = [samples.view, samples.light, numbers.look_ups, samples.map];
    let cost = Cost {
        experiment: experiment.to_owned(),
        index: cell.index,
        method: cell.method.clone(),
        counts: counts.map(|n| n as f64),
        total_ms: time.median,
        spread: (time.p95 - time.median).max(time.median - time.min) / time.median,
        thesis_ms: 0.0,
        own_ms: None,
        cloud: numbers.cloud_pixel_fraction,
        map_bytes: numbers.memory.map_bytes as f64,
    };
    let repeated = time.n >= FEWEST_RUNS;
    (repeated && time.median > 0.0 && work(&cost) > 0.0).then_some(cost)
}

/// N of eq. 3.5.
fn work(cost: &Cost) -> f64 {
    let [_, light, look_ups, map] = cost.counts;
    light + look_ups + map
}

/// Fits both models and keeps their predictions.
pub fn model(mut cells: Vec<Cost>) -> Option<CostModel> {
    if cells.is_empty() {
        return None;
    }
    let rows: Vec<Vec<f64>> = cells.iter().map(|c| vec![work(c) / c.total_ms]).collect();
    let price = non_negative(&rows, &vec![1.0; rows.len()])[0];
    cells.iter_mut().for_each(|c| c.thesis_ms = price * work(c));
    let mut prices = BTreeMap::new();
    for method in methods(&cells) {
        let own: Vec<&Cost> = cells.iter().filter(|c| c.method == method).collect();
        if own.len() < FEWEST_CELLS {
            continue;
        }
        let row = |c: &&Cost| c.counts.map(|n| n / c.total_ms).to_vec();
        let rows: Vec<Vec<f64>> = own.iter().map(row).collect();
        prices.insert(method, non_negative(&rows, &vec![1.0; rows.len()]));
    }
    for cell in &mut cells {
        let own = prices.get(&cell.method);
        cell.own_ms = own.map(|p| p.iter().zip(cell.counts).map(|(p, n)| p * n).sum());
    }
    let thesis_r2 = r2(cells.iter().map(|c| (c.total_ms, c.thesis_ms)));
    let methods = prices
        .iter()
        .map(|(method, prices)| method_cost(&cells, method, prices, price))
        .collect();
    Some(CostModel {
        thesis_ns: 1e6 * price,
        thesis_r2,
        methods,
        cells,
    })
}

fn methods(cells: &[Cost]) -> Vec<String> {
    let mut names: Vec<String> = cells.iter().map(|c| c.method.clone()).collect();
    names.sort();
    names.dedup();
    names
}

fn method_cost(cells: &[Cost], method: &str, prices: &[f64], thesis: f64) -> MethodCost {
    let own: Vec<&Cost> = cells.iter().filter(|c| c.method == method).collect();
    let error = |c: &&Cost| c.own_ms.unwrap_or(0.0) / c.total_ms - 1.0;
    let thesis_error = |c: &&Cost| c.thesis_ms / c.total_ms - 1.0;
    let errors: Vec<f64> = own.iter().map(error).collect();
    let thesis_errors: Vec<f64> = own.iter().map(thesis_error).collect();
    let mut prices_ns = [0.0; 4];
    prices_ns
        .iter_mut()
        .zip(prices)
        .for_each(|(ns, ms)| *ns = 1e6 * ms);
    let mut cost = MethodCost {
        method: method.to_owned(),
        cells: own.len(),
        prices_ns,
        r2: r2(own.iter().map(|c| (c.total_ms, c.own_ms.unwrap_or(0.0)))),
        worst: worst(&errors),
        typical: typical(&errors),
        thesis_worst: worst(&thesis_errors),
        thesis_typical: typical(&thesis_errors),
        why: Vec::new(),
    };
    cost.why = why(&cost, &own, &errors, 1e6 * thesis);
    cost
}

fn worst(errors: &[f64]) -> f64 {
    let larger = |a: f64, b: &f64| if b.abs() > a.abs() { *b } else { a };
    errors.iter().fold(0.0, larger)
}

fn typical(errors: &[f64]) -> f64 {
    let sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
    crate::metrics::summarise(&sizes).map_or(0.0, |s| s.median)
}

/// 1 − Σ(t − t̂)²/Σ(t − t̄)²; 0 where the times do not vary.
fn r2(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let n = pairs.clone().count() as f64;
    let mean = pairs.clone().map(|(t, _)| t).sum::<f64>() / n;
    let total: f64 = pairs.clone().map(|(t, _)| (t - mean).powi(2)).sum();
    let left: f64 = pairs.map(|(t, p)| (t - p).powi(2)).sum();
    if total > 0.0 { 1.0 - left / total } else { 0.0 }
}

/// Reasons by numbers for errors above 20 %: first for one price, then for the method's own.
fn why(cost: &MethodCost, cells: &[&Cost], errors: &[f64], thesis_ns: f64) -> Vec<String> {
    let mut why = Vec::new();
    if cost.thesis_worst.abs() > LARGE {
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
            signed_percent(cost.thesis_worst),
            number(thesis_ns),
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

/// What the errors of the method's own model go with.
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
    let per_look = |c: &Cost| (c.counts[1] + 1.0) / (c.counts[0] + 1.0);
    let causes: [(&str, Vec<f64>); 4] = [
        (
            "the share of cloud pixels (neighbouring rays that take different branches)",
            cells.iter().map(|c| c.cloud).collect(),
        ),
        (
            "light samples a view sample (marches that end early in dense cloud)",
            cells.iter().map(|c| per_look(c)).collect(),
        ),
        (
            "the size of the map (caches)",
            cells.iter().map(|c| c.map_bytes.max(1.0).ln()).collect(),
        ),
        (
            "the time itself (a fixed cost of a picture, which no count has)",
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
            " They go with none of cloud share, early ends, map size or time (|correlation| ≤ {:.2}).",
            r.abs()
        );
    }
    text
}

/// Pearson's; 0 where one of them does not vary.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(method: &str, counts: [f64; 4], total_ms: f64) -> Cost {
        Cost {
            experiment: "e".to_owned(),
            index: 0,
            method: method.to_owned(),
            counts,
            total_ms,
            spread: 0.01,
            thesis_ms: 0.0,
            own_ms: None,
            cloud: 0.5,
            map_bytes: 0.0,
        }
    }

    /// Counts that are not collinear.
    fn counts(i: u32, march: bool) -> [f64; 4] {
        let (a, b) = (f64::from(1 + i % 4), f64::from(1 + i / 4));
        if march {
            [1e6 * a, 1e6 * a * b * b, 0.0, 0.0]
        } else {
            [1e6 * a, 0.0, 1e6 * a * (1.0 + 0.3 * b), 1e6 * b * b]
        }
    }

    #[test]
    fn known_prices_are_recovered_from_counts() {
        let mut cells = Vec::new();
        let time = |n: [f64; 4], p: [f64; 4]| n.iter().zip(p).map(|(n, p)| n * p * 1e-6).sum();
        for i in 0..12 {
            let (srm, esm) = (counts(i, true), counts(i, false));
            cells.push(cell("srm", srm, time(srm, [3.0, 5.0, 0.0, 0.0])));
            cells.push(cell("esm", esm, time(esm, [3.0, 0.0, 20.0, 7.0])));
        }
        let model = model(cells).unwrap();
        let prices = |name: &str| {
            let found = model.methods.iter().find(|m| m.method == name);
            found.map(|m| m.prices_ns).unwrap()
        };
        for (found, wanted) in [
            (prices("srm"), [3.0, 5.0, 0.0, 0.0]),
            (prices("esm"), [3.0, 0.0, 20.0, 7.0]),
        ] {
            for (found, wanted) in found.iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
            }
        }
        assert!(model.methods.iter().all(|m| m.r2 > 0.999_999));
        assert!(model.thesis_r2 < 0.999, "one price does not fit both");
        let esm = model.methods.iter().find(|m| m.method == "esm").unwrap();
        assert!(esm.worst.abs() < 1e-9 && esm.thesis_worst.abs() > LARGE);
        assert_eq!(esm.why.len(), 1, "{:?}", esm.why);
    }

    #[test]
    fn one_price_fits_where_one_price_was_paid() {
        let cells: Vec<Cost> = (0..12)
            .map(|i| {
                let n = counts(i, i % 2 == 0);
                cell("m", n, 4e-6 * (n[1] + n[2] + n[3]))
            })
            .collect();
        let model = model(cells).unwrap();
        assert!((model.thesis_ns - 4.0).abs() < 1e-9 && model.thesis_r2 > 0.999_999);
        assert!(model.methods[0].why.is_empty());
    }

    #[test]
    fn what_a_model_misses_is_named_by_its_numbers() {
        let cells: Vec<Cost> = (0..12)
            .map(|i| {
                let n = counts(i, true);
                let mut cell = cell("srm", n, 5e-6 * n[1] * (1.0 + 0.08 * f64::from(i)));
                cell.cloud = f64::from(i) / 12.0;
                cell
            })
            .collect();
        let model = model(cells).unwrap();
        let text = model.methods[0].why.join(" ");
        assert!(text.contains("correlation"), "{text}");
        assert!(super::model(Vec::new()).is_none());
    }
}
