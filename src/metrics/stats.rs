//! Numbers of a sample of times, and flicker over a sequence of frames.

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
use crate::error::{Error, Result};
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

/// Flicker: √mean (Δₜ − Δₜ₋₁)² / mean L over consecutive frames and all values of a frame; ≥ 0, dimensionless.
///
/// `deltas` holds ΔL of each frame against its own truth ([`super::delta_rgb`]), `mean` is mean L over the truths
/// ([`super::mean_sun`]). A constant error does not flicker. NaN means "no value": a pair with one is left out, so
/// that sky does not dilute the number. Fewer than two frames, frames of different lengths, no pair with
/// values, or a mean that is not positive is an [`Error::Input`].
pub fn flicker(deltas: &[Vec<f32>], mean: f64) -> Result<f64> {
    let refuse = |problem: &str| {
        Err(Error::input(
            "flicker",
            problem,
            "Render a pan of two frames or more of a cloud.",
        ))
    };
    if !(mean.is_finite() && mean > 0.0) {
        return refuse("the truths hold no sunlight");
    }
    if deltas.windows(2).any(|pair| pair[0].len() != pair[1].len()) {
        return refuse("the frames differ in size");
    }
    let (mut sum, mut count) = (0.0, 0_u64);
    for pair in deltas.windows(2) {
        for (before, after) in pair[0].iter().zip(&pair[1]) {
            let change = f64::from(*after) - f64::from(*before);
            if change.is_finite() {
                sum += change * change;
                count += 1;
            }
        }
    }
    if count == 0 {
        return refuse("no pixel shows the cloud in two consecutive frames");
    }
    Ok((sum / count as f64).sqrt() / mean)
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
    fn constant_error_does_not_flicker_and_alternation_does() {
        assert_eq!(flicker(&vec![vec![0.3; 12]; 16], 0.5).unwrap(), 0.0);
        let alternating: Vec<Vec<f32>> = (0..16)
            .map(|t| vec![if t % 2 == 0 { 0.25 } else { -0.25 }; 12])
            .collect();
        assert_eq!(flicker(&alternating, 0.5).unwrap(), 1.0);
        // One change of 1 in two steps of two pixels: √(1/4) / 2.
        assert_eq!(
            flicker(&[vec![0.0, 0.0], vec![1.0, 0.0], vec![1.0, 0.0]], 2.0).unwrap(),
            0.25
        );
    }

    #[test]
    fn absent_values_do_not_dilute() {
        let frames = [vec![0.0, f32::NAN], vec![1.0, 5.0], vec![2.0, f32::NAN]];
        assert_eq!(flicker(&frames, 1.0).unwrap(), 1.0);
    }

    #[test]
    fn flicker_without_a_meaning_is_an_error() {
        let frame = vec![0.0; 4];
        for (deltas, mean) in [
            (vec![], 1.0),
            (vec![frame.clone()], 1.0),
            (vec![frame.clone(), vec![0.0; 3]], 1.0),
            (vec![vec![f32::NAN; 4]; 3], 1.0),
            (vec![frame.clone(); 2], 0.0),
            (vec![frame.clone(); 2], f64::NAN),
        ] {
            assert!(matches!(flicker(&deltas, mean), Err(Error::Input { .. })));
        }
    }
}
