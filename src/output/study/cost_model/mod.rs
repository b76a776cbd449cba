//! Cost model: times per sample, fitted to counted samples and measured times.
//!
//! The one-price model is t = c·N, N = N_light + N_look + N_map: the light samples of a secondary march, or the
//! look-ups in a map, and the samples that make the map. The model of a method has a price for each kind:
//! t = c_view·n_view + c_light·n_light + c_look·n_look + c_map·n_map, c ≥ 0, by least squares of relative errors.
//!
//! Where samples and look-ups are collinear, a method's own prices are not determined. Hence a third model, of all
//! methods at once: prices of view, light and map samples are common to all methods, the price of a look-up is the
//! method's own.
//!
//! All counts come from the shaders. Times exclude the reconstruction pass, which has no count. R² is that of the
//! times' logarithms, since the fits weigh relative errors: 1 − Σ(ln t − ln t̂)²/Σ(ln t − mean ln t)².

mod reasons;

use super::least_squares::non_negative;
use super::select::Records;
use crate::batch::record::Cell;
use serde::Serialize;
use std::collections::BTreeMap;

/// Names of the counts, in the order of [`Cost::counts`].
pub const COUNTS: [&str; 4] = ["view sample", "light sample", "look-up", "map sample"];
/// Absolute relative error above which reasons are given.
const LARGE: f64 = 0.2;
/// Smallest number of timed runs of a cell that is used.
const FEWEST_RUNS: usize = 3;
/// Smallest number of cells that a method's prices are fitted to.
const FEWEST_CELLS: usize = 6;

/// Data of one cell for the fit, and its predictions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Id of the experiment.
    pub experiment: String,
    /// Index of the cell.
    pub index: usize,
    /// Method.
    pub method: String,
    /// Numbers of view samples, light samples, look-ups, map samples.
    pub counts: [f64; 4],
    /// Measured median time, ms, without the reconstruction pass.
    pub total_ms: f64,
    /// Deviation of the minimum or the 95th percentile from the median, the larger one, over the median.
    pub spread: f64,
    /// Time predicted by the one-price model, ms.
    pub one_price_ms: f64,
    /// Time predicted by the method's own model, ms; `None` where the method has too few cells.
    pub own_ms: Option<f64>,
    /// Share of cloud pixels, 0…1.
    pub cloud: f64,
    /// Size of the map's textures, bytes.
    pub map_bytes: f64,
}

/// Cost model of one method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodCost {
    /// Method.
    pub method: String,
    /// Number of cells it was fitted to.
    pub cells: usize,
    /// Nanoseconds per view sample, light sample, look-up, map sample.
    pub prices_ns: [f64; 4],
    /// R² of the times' logarithms.
    pub r2: f64,
    /// Relative error (predicted ÷ measured − 1) of the worst cell, with its sign.
    pub worst: f64,
    /// Median of the absolute relative errors.
    pub typical: f64,
    /// Relative error of the worst cell of this method in the one-price model, with its sign.
    pub one_price_worst: f64,
    /// Median of the absolute relative errors of the one-price model on this method.
    pub one_price_typical: f64,
    /// Sentences on reasons for errors above 20 %.
    pub why: Vec<String>,
}

/// Prices of view, light and map samples common to all methods, with a price of look-ups for each method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SharedCost {
    /// Nanoseconds per view sample, light sample, map sample.
    pub samples_ns: [f64; 3],
    /// Nanoseconds per look-up, by method with look-ups.
    pub look_ups_ns: BTreeMap<String, f64>,
    /// R² of the times' logarithms.
    pub r2: f64,
    /// Median of the absolute relative errors.
    pub typical: f64,
}

/// The three models, fitted on one adapter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostModel {
    /// Nanoseconds per sample in the one-price model.
    pub one_price_ns: f64,
    /// R² of the times' logarithms in the one-price model.
    pub one_price_r2: f64,
    /// Prices that the methods share.
    pub shared: SharedCost,
    /// One entry for each method with enough cells.
    pub methods: Vec<MethodCost>,
    /// Every cell used in the fits.
    pub cells: Vec<Cost>,
}

/// Fits the models to all cells that were timed three times or more; `None` without any.
pub fn fit(records: &Records<'_>) -> Option<CostModel> {
    let mut cells = Vec::new();
    for (id, report) in records.reports {
        let clock = report.clock();
        cells.extend(report.cells.iter().filter_map(|cell| {
            let times = &cell.result.as_ref()?.time_ms;
            let rebuilt_ms = times.reconstruct.map_or(0.0, |stats| stats.median);
            cost(id, cell, clock.cost(times)?, rebuilt_ms)
        }));
    }
    model(cells)
}

fn cost(
    experiment: &str,
    cell: &Cell,
    time: crate::metrics::Stats,
    rebuilt_ms: f64,
) -> Option<Cost> {
    let numbers = cell.result.as_ref()?;
    let samples = &numbers.samples;
    let counts = [samples.view, samples.light, numbers.look_ups, samples.map];
    let cost = Cost {
        experiment: experiment.to_owned(),
        index: cell.index,
        method: cell.method.clone(),
        counts: counts.map(|n| n as f64),
        total_ms: time.median - rebuilt_ms,
        spread: (time.p95 - time.median).max(time.median - time.min) / time.median,
        one_price_ms: 0.0,
        own_ms: None,
        cloud: numbers.cloud_pixel_fraction,
        map_bytes: numbers.memory.map_bytes as f64,
    };
    let repeated = time.n >= FEWEST_RUNS;
    (repeated && cost.total_ms > 0.0 && work(&cost) > 0.0).then_some(cost)
}

/// Sample count N of the one-price model.
fn work(cost: &Cost) -> f64 {
    let [_, light, look_ups, map] = cost.counts;
    light + look_ups + map
}

/// Fits the three models and stores the predictions of the first two in the cells.
pub fn model(mut cells: Vec<Cost>) -> Option<CostModel> {
    if cells.is_empty() {
        return None;
    }
    let rows: Vec<Vec<f64>> = cells.iter().map(|c| vec![work(c) / c.total_ms]).collect();
    let price = non_negative(&rows, &vec![1.0; rows.len()])[0];
    cells
        .iter_mut()
        .for_each(|c| c.one_price_ms = price * work(c));
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
    let one_price_r2 = r2(cells.iter().map(|c| (c.total_ms, c.one_price_ms)));
    let methods = prices
        .iter()
        .map(|(method, prices)| method_cost(&cells, method, prices, price))
        .collect();
    Some(CostModel {
        one_price_ns: 1e6 * price,
        one_price_r2,
        shared: shared(&cells),
        methods,
        cells,
    })
}

/// Fits the prices of samples common to all methods and of each method's look-ups.
fn shared(cells: &[Cost]) -> SharedCost {
    let looks = |c: &&Cost| c.counts[2] > 0.0;
    let mut names: Vec<&str> = cells
        .iter()
        .filter(looks)
        .map(|c| c.method.as_str())
        .collect();
    names.sort_unstable();
    names.dedup();
    let counts = |c: &Cost| -> Vec<f64> {
        let [view, light, look_ups, map] = c.counts;
        let own = names
            .iter()
            .map(|name| if *name == c.method { look_ups } else { 0.0 });
        [view, light, map].into_iter().chain(own).collect()
    };
    let rows: Vec<Vec<f64>> = cells
        .iter()
        .map(|c| counts(c).iter().map(|n| n / c.total_ms).collect())
        .collect();
    let prices = non_negative(&rows, &vec![1.0; rows.len()]);
    let predicted = |c: &Cost| -> f64 { counts(c).iter().zip(&prices).map(|(n, p)| n * p).sum() };
    let pairs: Vec<(f64, f64)> = cells.iter().map(|c| (c.total_ms, predicted(c))).collect();
    let errors: Vec<f64> = pairs.iter().map(|(t, p)| p / t - 1.0).collect();
    let look_ups = names.iter().zip(&prices[3..]);
    SharedCost {
        samples_ns: [0, 1, 2].map(|i| 1e6 * prices[i]),
        look_ups_ns: look_ups
            .map(|(name, ms)| ((*name).to_owned(), 1e6 * ms))
            .collect(),
        r2: r2(pairs.iter().copied()),
        typical: typical(&errors),
    }
}

fn methods(cells: &[Cost]) -> Vec<String> {
    let mut names: Vec<String> = cells.iter().map(|c| c.method.clone()).collect();
    names.sort();
    names.dedup();
    names
}

fn method_cost(cells: &[Cost], method: &str, prices: &[f64], one_price: f64) -> MethodCost {
    let own: Vec<&Cost> = cells.iter().filter(|c| c.method == method).collect();
    let error = |c: &&Cost| c.own_ms.unwrap_or(0.0) / c.total_ms - 1.0;
    let one_price_error = |c: &&Cost| c.one_price_ms / c.total_ms - 1.0;
    let errors: Vec<f64> = own.iter().map(error).collect();
    let one_price_errors: Vec<f64> = own.iter().map(one_price_error).collect();
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
        one_price_worst: worst(&one_price_errors),
        one_price_typical: typical(&one_price_errors),
        why: Vec::new(),
    };
    cost.why = reasons::why(&cost, &own, &errors, 1e6 * one_price);
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

/// R² of the logarithms of (measured, predicted) times; 0 where measured times do not vary, −∞ for a prediction of 0.
fn r2(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let n = pairs.clone().count() as f64;
    let mean = pairs.clone().map(|(t, _)| t.ln()).sum::<f64>() / n;
    let total: f64 = pairs.clone().map(|(t, _)| (t.ln() - mean).powi(2)).sum();
    let left: f64 = pairs.map(|(t, p)| (t / p).ln().powi(2)).sum();
    if total > 0.0 { 1.0 - left / total } else { 0.0 }
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
            one_price_ms: 0.0,
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
        let shared = &model.shared;
        let found = [
            shared.samples_ns[0],
            shared.samples_ns[1],
            shared.samples_ns[2],
            shared.look_ups_ns["esm"],
        ];
        for (found, wanted) in found.iter().zip([3.0, 5.0, 7.0, 20.0]) {
            assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
        }
        assert!(shared.r2 > 0.999_999 && shared.look_ups_ns.len() == 1);
        assert!(model.one_price_r2 < 0.999, "one price does not fit both");
        let esm = model.methods.iter().find(|m| m.method == "esm").unwrap();
        assert!(esm.worst.abs() < 1e-9 && esm.one_price_worst.abs() > LARGE);
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
        assert!((model.one_price_ns - 4.0).abs() < 1e-9 && model.one_price_r2 > 0.999_999);
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
