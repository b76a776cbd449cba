//! Parser for a number of bytes as users write it.

use super::LIMIT_VARIABLE;
use crate::error::{Error, Result};

/// `4GiB`, `500 MB`, `1.5 TiB`, a number of bytes, or `none`.
pub(super) fn parse(text: &str) -> Result<u64> {
    bytes(&text.trim().to_ascii_lowercase()).ok_or_else(|| {
        Error::input(
            LIMIT_VARIABLE,
            format!("`{text}` is no size"),
            "Write bytes, or a number with KiB, MiB, GiB or TiB, e.g. 4GiB; `none` for no limit.",
        )
    })
}

fn bytes(text: &str) -> Option<u64> {
    if text == "none" {
        return Some(u64::MAX);
    }
    let end = text
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let factor: f64 = match unit.trim_start() {
        "" | "b" => 1.0,
        "k" | "kib" => 1024.0,
        "m" | "mib" => 1024f64.powi(2),
        "g" | "gib" => 1024f64.powi(3),
        "t" | "tib" => 1024f64.powi(4),
        "kb" => 1e3,
        "mb" => 1e6,
        "gb" => 1e9,
        "tb" => 1e12,
        _ => return None,
    };
    let value = number.parse::<f64>().ok()? * factor;
    // A conversion from f64 stops at the largest number, which means no limit.
    value.is_finite().then_some(value as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_as_people_write_them() {
        for (text, expected) in [
            ("0", 0),
            ("123456", 123_456),
            ("10 B", 10),
            ("4GiB", 4 << 30),
            (" 4 gib ", 4 << 30),
            ("4g", 4 << 30),
            ("1.5 MiB", 3 << 19),
            ("500MB", 500_000_000),
            ("2TiB", 2 << 40),
            ("none", u64::MAX),
            ("99999999 TiB", u64::MAX),
        ] {
            assert_eq!(parse(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn what_is_no_size_is_refused_with_the_variable_and_an_example() {
        for text in [
            "much",
            "4 parsecs",
            "-1",
            "GiB",
            "4GiB2",
            "1.2.3",
            "nan",
            "inf",
            "1e3",
            "٤",
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.starts_with("OCCLAB_CACHE_LIMIT: "), "{message}");
            assert!(
                message.contains(text) && message.contains("4GiB"),
                "{message}"
            );
        }
    }
}
