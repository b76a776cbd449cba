//! Formats numbers for pages and charts. Small values are never rounded to 0; a missing value is "n/a".

use crate::metrics::{ErrorNumbers, Format, Metric};

/// Text for a missing number.
pub const NONE: &str = "n/a";

/// Text of a number with three significant digits, with an exponent only where it would be long otherwise.
pub fn number(value: f64) -> String {
    let size = value.abs();
    let text = if value == 0.0 {
        "0".to_owned()
    } else if !(1e-4..1e6).contains(&size) {
        format!("{value:.2e}")
    } else {
        let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    };
    text.replace('-', "−")
}

/// [`number`] or "n/a".
pub fn maybe(value: Option<f64>) -> String {
    value
        .filter(|v| v.is_finite())
        .map_or_else(|| NONE.to_owned(), number)
}

/// A number in the format that its entry in the list of numbers declares.
pub fn written(format: Format, value: f64) -> String {
    match format {
        Format::Number => number(value),
        Format::Percent => percent(value),
        Format::SignedPercent => signed_percent(value),
        Format::Integer => value.to_string(),
        Format::Count => count(value as u64),
        Format::Bytes => bytes(value as u64),
    }
}

/// An error number in the format of its metric, or "n/a".
pub fn error(metric: &Metric, numbers: &ErrorNumbers) -> String {
    let value = (metric.get)(numbers).filter(|v| v.is_finite());
    value.map_or_else(|| NONE.to_owned(), |v| written(metric.format, v))
}

/// A share as percentage with its sign: `+4.2 %` for 0.042.
pub fn signed_percent(value: f64) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    format!("{sign}{} %", number_short(value * 100.0))
}

/// A share as percentage: `4.2 %` for 0.042.
pub fn percent(value: f64) -> String {
    format!("{} %", number_short(value * 100.0))
}

/// A number with two significant digits.
fn number_short(value: f64) -> String {
    if value == 0.0 || value.abs() < 1e-2 || value.abs() >= 10.0 {
        return number(value);
    }
    let digits = (1 - value.abs().log10().floor() as i32).clamp(0, 4) as usize;
    format!("{value:.digits$}").replace('-', "−")
}

/// A time given in ms; shown in seconds from 10 s on.
pub fn ms(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(
        || NONE.to_owned(),
        |v| match v {
            10_000.0.. => format!("{} s", number(v / 1e3)),
            _ => format!("{} ms", number(v)),
        },
    )
}

/// Bytes in binary units.
pub fn bytes(value: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut size = value as f64;
    let mut unit = 0;
    while size >= 1024.0 && unit + 1 < UNITS.len() {
        size /= 1024.0;
        unit += 1;
    }
    if size.fract() == 0.0 {
        format!("{size} {}", UNITS[unit])
    } else {
        format!("{} {}", number(size), UNITS[unit])
    }
}

/// [`bytes`] of a map, or words for a method without one.
pub fn map_size(value: u64) -> String {
    match value {
        0 => "no map".to_owned(),
        _ => bytes(value),
    }
}

/// [`map_size`] of a map, followed by the bytes of the history where there is one.
pub fn memory_size(map: u64, history: u64) -> String {
    match history {
        0 => map_size(map),
        _ => format!("{} + history {}", map_size(map), bytes(history)),
    }
}

/// Counts in thousands, millions, billions.
pub fn count(value: u64) -> String {
    let v = value as f64;
    match value {
        0..10_000 => value.to_string(),
        10_000..1_000_000 => format!("{} k", number(v / 1e3)),
        1_000_000..1_000_000_000 => format!("{} M", number(v / 1e6)),
        _ => format!("{} G", number(v / 1e9)),
    }
}

/// The text cut to at most `max` characters, with an ellipsis where it was cut.
pub fn shorten(text: &str, max: usize) -> String {
    if text.chars().count() <= max {
        return text.to_owned();
    }
    let mut out: String = text.chars().take(max.saturating_sub(1)).collect();
    out.push('…');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits_and_their_sign() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(0.153_42), "0.153");
        assert_eq!(number(-12.345), "−12.3");
        assert_eq!(number(1234.5), "1234");
        assert_eq!(number(0.000_012), "1.20e−5");
        assert_eq!(maybe(None), "n/a");
        assert_eq!(signed_percent(0.042), "+4.2 %");
        assert_eq!(signed_percent(-0.3), "−30.0 %");
    }

    #[test]
    fn bytes_and_counts_name_their_unit() {
        assert_eq!(bytes(0), "0 B");
        assert_eq!(bytes(524_288), "512 KiB");
        assert_eq!(bytes(3_670_016), "3.50 MiB");
        assert_eq!(count(12_345_678), "12.3 M");
        assert_eq!(shorten("abcdef", 4), "abc…");
    }
}
