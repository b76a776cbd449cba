//! An axis: values to positions, and the ticks that people expect on it.

use super::super::format::{bytes, number};
use super::super::view::distinct;

/// How values are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    Linear,
    Log,
    /// Logarithmic with ticks at powers of two.
    Bytes,
}

/// An axis with its range. A logarithmic axis keeps a separate place for zero when there are zeros.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub title: String,
    scale: Scale,
    lo: f64,
    hi: f64,
    zero: Option<String>,
    /// Values that get the ticks instead of round numbers.
    marked: Vec<f64>,
}

/// A tick: where, what is written there, and how much it matters (0 most).
#[derive(Clone, Debug)]
pub struct Tick {
    /// Position, 0 to 1.
    pub at: f64,
    /// Its text.
    pub text: String,
    /// Labels of a smaller rank win where there is no room for all.
    pub rank: u8,
}

/// Rank of ticks that get a label only on a short axis, where the others are few.
pub const CROWDED: u8 = 3;

/// Share of the axis that the place of zero takes, and where in it zero lies.
const ZERO: (f64, f64) = (0.14, 0.06);

impl Axis {
    /// A logarithmic axis over `values`; zeros are drawn at a place of their own, labelled `zero`.
    pub fn log(title: &str, zero: &str, values: impl Iterator<Item = f64> + Clone) -> Self {
        Self::logarithmic(title, Scale::Log, zero, values)
    }

    /// A logarithmic axis with its ticks at the very values.
    pub fn log_at(title: &str, values: impl Iterator<Item = f64> + Clone) -> Self {
        Self {
            marked: distinct(values.clone().filter(|v| *v > 0.0)),
            ..Self::log(title, "0", values)
        }
    }

    /// A logarithmic axis of bytes.
    pub fn bytes(title: &str, zero: &str, values: impl Iterator<Item = f64> + Clone) -> Self {
        Self::logarithmic(title, Scale::Bytes, zero, values)
    }

    fn logarithmic(
        title: &str,
        scale: Scale,
        zero: &str,
        values: impl Iterator<Item = f64> + Clone,
    ) -> Self {
        let base = |v: f64| {
            if scale == Scale::Bytes {
                v.log2()
            } else {
                v.log10()
            }
        };
        let positive = values
            .clone()
            .filter(|v| *v > 0.0 && v.is_finite())
            .map(base);
        let (mut lo, mut hi) = positive.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        if lo > hi {
            (lo, hi) = (0.0, 1.0);
        }
        let least = if scale == Scale::Bytes { 2.0 } else { 0.6 };
        let pad = (0.06 * (hi - lo)).max((least - (hi - lo)) / 2.0);
        let zero = values.clone().any(|v| v <= 0.0).then(|| zero.to_owned());
        Self {
            title: title.to_owned(),
            scale,
            lo: lo - pad,
            hi: hi + pad,
            zero,
            marked: Vec::new(),
        }
    }

    /// A linear axis from 0 past the largest of `values`.
    pub fn from_zero(title: &str, values: impl Iterator<Item = f64>) -> Self {
        let hi = values.filter(|v| v.is_finite()).fold(0.0, f64::max);
        let hi = if hi > 0.0 { hi * 1.05 } else { 1.0 };
        Self {
            title: title.to_owned(),
            scale: Scale::Linear,
            lo: 0.0,
            hi,
            zero: None,
            marked: Vec::new(),
        }
    }

    /// Position of a value, 0 to 1.
    pub fn at(&self, value: f64) -> f64 {
        let place = match self.scale {
            Scale::Linear => value,
            _ if value <= 0.0 => return ZERO.1,
            Scale::Log => value.log10(),
            Scale::Bytes => value.log2(),
        };
        let share = ((place - self.lo) / (self.hi - self.lo)).clamp(0.0, 1.0);
        if self.zero.is_some() {
            ZERO.0 + (1.0 - ZERO.0) * share
        } else {
            share
        }
    }

    /// Where the place of zero ends, if the axis has one.
    pub fn break_at(&self) -> Option<f64> {
        self.zero.as_ref().map(|_| ZERO.0)
    }

    /// All ticks in range, with rank.
    pub fn ticks(&self) -> Vec<Tick> {
        let mut out: Vec<Tick> = match self.scale {
            _ if !self.marked.is_empty() => self.marked_ticks(),
            Scale::Linear => self.linear_ticks(),
            Scale::Log => self.decade_ticks(),
            Scale::Bytes => self.binary_ticks(),
        };
        out.extend(self.zero.as_ref().map(|text| Tick {
            at: ZERO.1,
            text: text.clone(),
            rank: 0,
        }));
        out
    }

    fn marked_ticks(&self) -> Vec<Tick> {
        let tick = |value: &f64| Tick {
            at: self.at(*value),
            text: short_number(*value),
            rank: 0,
        };
        self.marked.iter().map(tick).collect()
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let raw = self.hi / 5.0;
        let decade = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .iter()
            .map(|m| m * decade)
            .find(|s| *s >= raw)
            .unwrap_or(raw);
        let tick = |i: u32| {
            let value = f64::from(i) * step;
            Tick {
                at: self.at(value),
                text: short_number(value),
                rank: 0,
            }
        };
        (0..=10)
            .take_while(|i| f64::from(*i) * step <= self.hi)
            .map(tick)
            .collect()
    }

    fn decade_ticks(&self) -> Vec<Tick> {
        let mut out = Vec::new();
        for decade in self.lo.floor() as i32..=self.hi.ceil() as i32 {
            for digit in 1..10u8 {
                let value = f64::from(digit) * 10f64.powi(decade);
                if value.log10() >= self.lo && value.log10() <= self.hi {
                    let rank = match digit {
                        1 => 0,
                        2 | 5 => 1,
                        3 | 7 => 2,
                        _ => CROWDED,
                    };
                    out.push(Tick {
                        at: self.at(value),
                        text: short_number(value),
                        rank,
                    });
                }
            }
        }
        out
    }

    fn binary_ticks(&self) -> Vec<Tick> {
        let powers = self.lo.ceil().max(0.0) as u32..=self.hi.floor().clamp(0.0, 62.0) as u32;
        powers
            .map(|power| {
                let value = 1u64 << power;
                let rank = match power {
                    p if p % 10 == 0 => 0,
                    p if p % 2 == 0 => 1,
                    _ => 2,
                };
                Tick {
                    at: self.at(value as f64),
                    text: bytes(value),
                    rank,
                }
            })
            .collect()
    }
}

/// A round number without trailing zeros.
fn short_number(value: f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    if rounded == 0.0 && value != 0.0 {
        number(value)
    } else {
        rounded.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_axis_orders_values_and_keeps_zero_apart() {
        let axis = Axis::log("error", "0", [0.0, 0.01, 0.1, 1.0].into_iter());
        assert!(axis.at(0.0) < ZERO.0 && axis.at(0.01) > ZERO.0);
        assert!(axis.at(0.01) < axis.at(0.1) && axis.at(0.1) < axis.at(1.0));
        assert!(axis.ticks().iter().any(|t| t.text == "0.1" && t.rank == 0));
    }

    #[test]
    fn narrow_and_empty_ranges_still_have_ticks() {
        for values in [vec![0.5], vec![], vec![3.0, 3.1]] {
            let axis = Axis::log("t", "0", values.into_iter());
            assert!(axis.ticks().len() >= 3);
        }
        assert!(Axis::from_zero("t", [].into_iter()).ticks().len() >= 3);
        assert!(Axis::bytes("b", "0", [1024.0].into_iter()).ticks().len() >= 2);
    }
}
