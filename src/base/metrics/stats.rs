//! Summary statistics of a sample of times.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Five numbers of a sample of times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stats {
    /// Median.
    pub median: f64,
    /// Smallest.
    pub min: f64,
    /// 95th percentile (nearest rank).
    pub p95: f64,
    /// Standard deviation / mean.
    pub cv: f64,
    /// Number of samples.
    pub n: usize,
}
use crate::frame::nearest_rank;

/// Summarises a sample (times in ms, or any unit); `None` when it is empty or holds a NaN or an infinity.
///
/// Median: middle value, mean of the two middle ones when n is even. p95: nearest rank (Hyndman & Fan, "Sample
/// Quantiles in Statistical Packages", The American Statistician 50(4), 1996, definition 1). cv: standard deviation
/// with n − 1 divided by the mean, ≥ 0 for positive samples, 0 when n = 1 or the mean is 0.
pub fn summarise(values: &[f64]) -> Option<Stats> {
    let n = values.len();
    if n == 0 || !values.iter().all(|v| v.is_finite()) {
        return None;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mean = sorted.iter().sum::<f64>() / n as f64;
    let squared: f64 = sorted.iter().map(|v| (v - mean).powi(2)).sum();
    let deviation = (squared / (n - 1).max(1) as f64).sqrt();
    Some(Stats {
        median: (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0,
        min: sorted[0],
        cv: if mean == 0.0 { 0.0 } else { deviation / mean },
        p95: nearest_rank(&mut sorted, 0.95)?,
        n,
    })
}

/// How repeats changed from the first third of a sample to the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thirds {
    /// Median of the last third over that of the first, less 1.
    pub change: f64,
    /// The medians differ by no more than twice the larger of both thirds' median absolute deviations.
    pub agree: bool,
}

/// Compares the thirds of a sample in the order in which it was taken; `None` with fewer than three values a third, whose
/// spread is not known, and where a value is not positive.
pub fn thirds(values: &[f64]) -> Option<Thirds> {
    let third = values.len() / 3;
    if third < 3 || !values.iter().all(|v| v.is_finite() && *v > 0.0) {
        return None;
    }
    let parts = [&values[..third], &values[values.len() - third..]];
    let median = |values: &[f64]| summarise(values).map(|stats| stats.median);
    let [first, last] = [median(parts[0])?, median(parts[1])?];
    let deviation = |part: &[f64], from: f64| {
        let sizes: Vec<f64> = part.iter().map(|v| (v - from).abs()).collect();
        median(&sizes)
    };
    let deviations = [deviation(parts[0], first)?, deviation(parts[1], last)?];
    Some(Thirds {
        change: last / first - 1.0,
        agree: (last - first).abs() <= 2.0 * deviations[0].max(deviations[1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_even_and_single_samples() {
        let odd = summarise(&[3.0, 1.0, 2.0]).unwrap();
        assert_eq!(
            (odd.median, odd.min, odd.p95, odd.cv, odd.n),
            (2.0, 1.0, 3.0, 0.5, 3)
        );
        assert_eq!(summarise(&[4.0, 1.0, 2.0, 3.0]).unwrap().median, 2.5);
        let one = summarise(&[7.0]).unwrap();
        assert_eq!(
            (one.median, one.min, one.p95, one.cv, one.n),
            (7.0, 7.0, 7.0, 0.0, 1)
        );
        assert_eq!(summarise(&[0.0, 0.0]).unwrap().cv, 0.0);
    }

    #[test]
    fn p95_is_the_nearest_rank() {
        let twenty: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(summarise(&twenty).unwrap().p95, 19.0);
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(summarise(&hundred).unwrap().p95, 95.0);
    }

    #[test]
    fn no_summary_of_nothing_or_nonsense() {
        assert_eq!(summarise(&[]), None);
        assert_eq!(summarise(&[1.0, f64::NAN]), None);
        assert_eq!(summarise(&[f64::INFINITY]), None);
    }

    #[test]
    fn thirds_of_a_drift_differ_and_those_of_noise_agree() {
        let drift: Vec<f64> = (0..12).map(|i| 10.0 + f64::from(i)).collect();
        let drifting = thirds(&drift).unwrap();
        assert_eq!(
            (drifting.change, drifting.agree),
            (19.5 / 11.5 - 1.0, false)
        );
        let noise = [
            10.0, 12.0, 11.0, 10.5, 40.0, 10.0, 9.0, 11.5, 10.2, 12.5, 9.5, 11.1,
        ];
        let steady = thirds(&noise).unwrap();
        assert!(steady.agree && steady.change.abs() < 0.1);
        let mut one_spike = drift.clone();
        one_spike[1] = 40.0;
        assert!(!thirds(&one_spike).unwrap().agree, "a spike hides no drift");
        assert_eq!(
            thirds(&noise[..8]),
            None,
            "two values a third have no middle"
        );
        assert_eq!(thirds(&[0.0; 9]), None);
    }
}
