//! Checks of values, and the message for an invalid one: its place in the scene and what is allowed.

use crate::error::Error;

/// An invalid value, located by JSON pointer inside the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// JSON pointer, e.g. `/sun/elevation_deg`.
    pub pointer: String,
    /// What is wrong and what is allowed.
    pub message: String,
}

impl Problem {
    /// A problem at `pointer`.
    pub fn new(pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            pointer: pointer.into(),
            message: message.into(),
        }
    }

    /// As a library error for the file `place`.
    pub fn at(self, place: &str) -> Error {
        Error::input(
            format!("{place}, at {}", self.pointer),
            self.message,
            "Correct the value; `occlab schema` prints what is allowed.",
        )
    }
}

/// Largest magnitude allowed of a radiance, a density or a distance: products of a few of them stay finite in the
/// device's f32, which ends at 3.4e38.
pub const MAX_MAGNITUDE: f64 = 1e12;

/// `value` must be finite and satisfy `ok`.
pub fn check(
    pointer: &str,
    value: f64,
    allowed: &str,
    ok: impl Fn(f64) -> bool,
) -> Result<(), Problem> {
    if value.is_finite() && ok(value) {
        return Ok(());
    }
    Err(Problem::new(
        pointer,
        format!("the value is {value}, allowed is {allowed}"),
    ))
}

/// Every component must be finite and satisfy `ok`.
pub fn check_all(
    pointer: &str,
    values: &[f64],
    allowed: &str,
    ok: impl Fn(f64) -> bool + Copy,
) -> Result<(), Problem> {
    values
        .iter()
        .try_for_each(|v| check(pointer, *v, allowed, ok))
}
