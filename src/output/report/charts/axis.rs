//! Axis of a chart: maps values to positions, and places round ticks.

use super::super::format::{bytes, number};
use super::super::view::distinct;

/// Mapping from values to positions on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// From 0.
    Linear,
    /// Logarithmic; zeros have a separate position before the scale.
    Log,
    /// Logarithmic with a tick at each value, for axes with few values; zeros as with `Log`.
    LogAtValues,
    /// Logarithmic with ticks at powers of two; zeros as with `Log`.
    Bytes,
}

/// Specification of an axis without its range.
#[derive(Clone, Debug)]
pub struct AxisSpec {
    /// Quantity and unit.
    pub title: String,
    /// Mapping from values to positions.
    pub scale: Scale,
    /// Tick label of zero on a logarithmic axis.
    pub zero: &'static str,
    /// Fixed end of a linear axis; `None`: a little beyond the largest value.
    pub end: Option<f64>,
}

impl AxisSpec {
    /// An axis whose range follows from its values.
    pub fn new(title: impl Into<String>, scale: Scale) -> Self {
        Self {
            title: title.into(),
            scale,
            zero: "0",
            end: None,
        }
    }

    /// A linear axis that ends at `end`; larger values are drawn there.
    pub fn up_to(title: &str, end: f64) -> Self {
        Self {
            end: Some(end),
            ..Self::new(title, Scale::Linear)
        }
    }

    /// The axis with the range of these values.
    pub fn over(&self, values: &[f64]) -> Axis {
        match (self.scale, self.end) {
            (Scale::Linear, Some(end)) => self.linear(end),
            (Scale::Linear, None) => {
                let finite = values.iter().copied().filter(|v| v.is_finite());
                self.linear(1.05 * finite.fold(0.0, f64::max))
            }
            _ => self.logarithmic(values),
        }
    }

    fn linear(&self, end: f64) -> Axis {
        Axis {
            title: self.title.clone(),
            scale: self.scale,
            lo: 0.0,
            hi: if end > 0.0 { end } else { 1.0 },
            zero: None,
            marked: Vec::new(),
        }
    }

    fn logarithmic(&self, values: &[f64]) -> Axis {
        let base = |v: &f64| match self.scale {
            Scale::Bytes => v.log2(),
            _ => v.log10(),
        };
        let positive = values.iter().filter(|v| **v > 0.0 && v.is_finite());
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut lo, mut hi) = positive
            .clone()
            .map(base)
            .fold(ends, |(l, h), v| (l.min(v), h.max(v)));
        if lo > hi {
            (lo, hi) = (0.0, 1.0);
        }
        let least = match self.scale {
            Scale::Bytes => 2.0,
            _ => 0.6,
        };
        let pad = (0.06 * (hi - lo)).max((least - (hi - lo)) / 2.0);
        let marked = match self.scale {
            Scale::LogAtValues => distinct(positive.copied()),
            _ => Vec::new(),
        };
        Axis {
            title: self.title.clone(),
            scale: self.scale,
            lo: lo - pad,
            hi: hi + pad,
            zero: values
                .iter()
                .any(|v| *v <= 0.0)
                .then(|| self.zero.to_owned()),
            marked,
        }
    }
}

/// An axis with its range. A logarithmic axis has a separate position for zero when there are zeros.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub title: String,
    scale: Scale,
    lo: f64,
    hi: f64,
    zero: Option<String>,
    /// Values with ticks, instead of round numbers.
    marked: Vec<f64>,
}

/// A tick: position, label and priority (0 is highest).
#[derive(Clone, Debug)]
pub struct Tick {
    /// Position, 0 to 1.
    pub at: f64,
    /// Text beside the tick.
    pub text: String,
    /// Labels of a smaller rank win where there is no room for all.
    pub rank: u8,
}

/// Rank of ticks that get a label only where there are few others.
pub const CROWDED: u8 = 3;

/// Share of a logarithmic axis reserved for zero, and position of zero, both 0…1 along the axis.
const ZERO: (f64, f64) = (0.14, 0.06);

impl Axis {
    /// Position of a value, 0 to 1.
    pub fn at(&self, value: f64) -> f64 {
        let place = match self.scale {
            Scale::Linear => value,
            _ if value <= 0.0 => return ZERO.1,
            Scale::Log | Scale::LogAtValues => value.log10(),
            Scale::Bytes => value.log2(),
        };
        let share = ((place - self.lo) / (self.hi - self.lo)).clamp(0.0, 1.0);
        if self.zero.is_some() {
            ZERO.0 + (1.0 - ZERO.0) * share
        } else {
            share
        }
    }

    /// Position, 0 to 1, where the part reserved for zero ends, if the axis has one.
    pub fn break_at(&self) -> Option<f64> {
        self.zero.as_ref().map(|_| ZERO.0)
    }

    /// All ticks in range, with rank.
    pub fn ticks(&self) -> Vec<Tick> {
        let mut out: Vec<Tick> = match self.scale {
            _ if !self.marked.is_empty() => self.marked_ticks(),
            Scale::Linear => self.linear_ticks(),
            Scale::Log | Scale::LogAtValues => self.decade_ticks(),
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

    fn axis(scale: Scale, values: &[f64]) -> Axis {
        AxisSpec::new("t", scale).over(values)
    }

    #[test]
    fn log_axis_orders_values_and_keeps_zero_apart() {
        let axis = axis(Scale::Log, &[0.0, 0.01, 0.1, 1.0]);
        assert!(axis.at(0.0) < ZERO.0 && axis.at(0.01) > ZERO.0);
        assert!(axis.at(0.01) < axis.at(0.1) && axis.at(0.1) < axis.at(1.0));
        assert!(axis.ticks().iter().any(|t| t.text == "0.1" && t.rank == 0));
    }

    #[test]
    fn narrow_and_empty_ranges_still_have_ticks() {
        for values in [&[0.5][..], &[], &[3.0, 3.1]] {
            assert!(axis(Scale::Log, values).ticks().len() >= 3);
        }
        assert!(axis(Scale::Linear, &[]).ticks().len() >= 3);
        assert!(axis(Scale::Bytes, &[1024.0]).ticks().len() >= 2);
    }
}
