//! A number with the range its repeats leave open.

use crate::report::format::number;
use serde::Serialize;

/// low ≤ value ≤ high: the median and the extremes of the repeats, or arithmetic on such.
///
/// The range from the smallest to the largest of n repeats holds the true median with probability 1 − 2^(1−n): 75 % for
/// 3 runs, 94 % for 5, 99.6 % for 9.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Smallest plausible value.
    pub low: f64,
    /// Median.
    pub value: f64,
    /// Largest plausible value.
    pub high: f64,
}

impl Interval {
    /// A number without spread.
    pub fn exact(value: f64) -> Self {
        Self {
            low: value,
            value,
            high: value,
        }
    }

    /// Difference, each at its worst.
    pub fn minus(self, other: Self) -> Self {
        Self {
            low: self.low - other.high,
            value: self.value - other.value,
            high: self.high - other.low,
        }
    }

    /// Quotient of a number by a positive one, each at its worst; a reason where the divisor may be 0.
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
