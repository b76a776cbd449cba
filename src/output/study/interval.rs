//! Interval arithmetic on medians with order-statistics confidence intervals.

use crate::metrics::summarise;
use crate::report::format::number;
use serde::Serialize;

/// low ≤ value ≤ high: a median of repeats with a confidence interval of the true median, or the result of interval
/// arithmetic on such; in the unit of the number. For the wall clock: minimum, median and 95th percentile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Smallest plausible value.
    pub low: f64,
    /// Median.
    pub value: f64,
    /// Largest plausible value.
    pub high: f64,
}

/// Least probability that an interval contains the true median, where there are enough repeats.
pub const CONFIDENCE: f64 = 0.93;
/// Smallest number of repeats that an interval is computed from.
const FEWEST: usize = 3;

impl Interval {
    /// Median of repeats with an order-statistics confidence interval: the narrowest pair of equal ranks from both ends
    /// that contains the true median with a probability of at least 93 % (David & Nagaraja 2003, § 7.1); for 3 or 4
    /// repeats the extremes, which contain it with 75 and 88 %. The error says that there are fewer than 3.
    pub fn of_repeats(values: &[f64]) -> Result<Self, String> {
        Self::of_repeats_at(values, CONFIDENCE)
    }

    /// [`Self::of_repeats`] with the probability `confidence`, 0…1; the extremes where the repeats are too few for it.
    pub fn of_repeats_at(values: &[f64], confidence: f64) -> Result<Self, String> {
        let n = values.len();
        let stats = summarise(values).filter(|_| n >= FEWEST);
        let stats =
            stats.ok_or_else(|| format!("{n} timed runs tell no spread, {FEWEST} would"))?;
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let outer = outer_ranks(n, confidence);
        Ok(Self {
            low: sorted[outer],
            value: stats.median,
            high: sorted[n - 1 - outer],
        })
    }

    /// A number without spread.
    pub fn exact(value: f64) -> Self {
        Self {
            low: value,
            value,
            high: value,
        }
    }

    /// Difference by interval arithmetic.
    pub fn minus(self, other: Self) -> Self {
        Self {
            low: self.low - other.high,
            value: self.value - other.value,
            high: self.high - other.low,
        }
    }

    /// Quotient by interval arithmetic; an error where the divisor's interval reaches 0 or less.
    pub fn over(self, other: Self) -> Result<Self, String> {
        if other.low <= 0.0 {
            return Err(format!("the divisor may be 0 ({other})"));
        }
        let least = if self.low < 0.0 {
            other.low
        } else {
            other.high
        };
        let most = if self.high < 0.0 {
            other.high
        } else {
            other.low
        };
        Ok(Self {
            low: self.low / least,
            value: self.value / other.value,
            high: self.high / most,
        })
    }

    /// Interval of the absolute value.
    pub fn size(self) -> Self {
        let (low, high) = (self.low.abs(), self.high.abs());
        let spans = self.low <= 0.0 && self.high >= 0.0;
        Self {
            low: if spans { 0.0 } else { low.min(high) },
            value: self.value.abs(),
            high: low.max(high),
        }
    }

    /// Half of the range.
    pub fn half_width(&self) -> f64 {
        0.5 * (self.high - self.low)
    }
}

impl std::fmt::Display for Interval {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.low == self.high {
            return f.write_str(&number(self.value));
        }
        write!(
            f,
            "{} [{}, {}]",
            number(self.value),
            number(self.low),
            number(self.high)
        )
    }
}

/// How many of n sorted repeats can be left out at each end: k such that 1 − 2·P(B(n, ½) ≤ k) ≥ `confidence`, or 0.
fn outer_ranks(n: usize, confidence: f64) -> usize {
    let mut probability = 0.5_f64.powi(i32::try_from(n).unwrap_or(i32::MAX));
    let (mut below, mut outer) = (0.0, 0);
    for k in 0..n / 2 {
        below += probability;
        if 1.0 - 2.0 * below < confidence {
            break;
        }
        outer = k;
        probability *= (n - k) as f64 / (k + 1) as f64;
    }
    outer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_repeats_leave_out_what_they_can() {
        // Binomial: n = 15 leaves 3 at each end (96.5 %), 4 would leave 88.2 %.
        for (n, outer) in [(3, 0), (5, 0), (7, 0), (8, 0), (9, 1), (15, 3), (21, 5)] {
            assert_eq!(outer_ranks(n, CONFIDENCE), outer, "{n}");
        }
        // 2 at each end would leave 99.26 %.
        assert_eq!(outer_ranks(15, 0.993), 1);
        let values: Vec<f64> = (1..=15).rev().map(f64::from).collect();
        let interval = Interval::of_repeats(&values).unwrap();
        assert_eq!(
            (interval.low, interval.value, interval.high),
            (4.0, 8.0, 12.0)
        );
        assert!(Interval::of_repeats(&[1.0, 2.0]).is_err());
    }

    #[test]
    fn quotients_are_taken_at_their_worst() {
        let of = |low, value, high| Interval { low, value, high };
        let ratio = of(-2.0, 1.0, 4.0).over(of(1.0, 2.0, 4.0)).unwrap();
        assert_eq!(ratio, of(-2.0, 0.5, 4.0));
        assert!(of(1.0, 1.0, 1.0).over(of(0.0, 1.0, 2.0)).is_err());
        assert_eq!(of(-3.0, -2.0, -1.0).size(), of(1.0, 2.0, 3.0));
        assert_eq!(of(-3.0, -2.0, 1.0).size(), of(0.0, 2.0, 3.0));
        assert_eq!(
            of(1.0, 2.0, 3.0).minus(of(0.5, 1.0, 2.0)),
            of(-1.0, 1.0, 2.5)
        );
    }
}
