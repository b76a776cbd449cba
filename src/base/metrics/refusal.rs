//! Why pictures cannot be compared, as types: the caller of a comparison decides what follows from each reason.

use crate::error::Error;

/// The reference shows nothing whose error could be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlit {
    /// No cloud pixel.
    NoCloud,
    /// Cloud pixels without sunlight on them: relative errors have no scale.
    NoSunlight,
}

/// Reason for which [`super::compare`] refuses two pictures.
#[derive(Debug)]
pub enum Incomparable {
    /// There is nothing to measure.
    Unlit(Unlit),
    /// Channels of the reference, of 8 a pixel, that are NaN or infinite: it cannot serve as truth.
    NotFinite(u64),
    /// Broken pictures, or pictures of different sizes.
    Unfit(Error),
}

impl From<Unlit> for Error {
    fn from(unlit: Unlit) -> Self {
        let problem = match unlit {
            Unlit::NoCloud => "no pixel has an opacity above 0.01, so there is nothing to measure",
            Unlit::NoSunlight => {
                "no sunlight on its cloud pixels, so relative errors have no scale"
            }
        };
        Self::input(
            "the reference",
            problem,
            "Point the camera at a sun-lit cloud.",
        )
    }
}

impl From<Incomparable> for Error {
    fn from(reason: Incomparable) -> Self {
        match reason {
            Incomparable::Unlit(unlit) => unlit.into(),
            Incomparable::NotFinite(channels) => Self::input(
                "the reference",
                format!("{channels} channels are NaN or infinite, so it is no truth"),
                "Render the reference again or give another one.",
            ),
            Incomparable::Unfit(error) => error,
        }
    }
}

impl From<Unlit> for Incomparable {
    fn from(unlit: Unlit) -> Self {
        Self::Unlit(unlit)
    }
}

impl From<Error> for Incomparable {
    fn from(error: Error) -> Self {
        Self::Unfit(error)
    }
}
