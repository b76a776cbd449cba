//! Why pictures cannot be compared, as types: who asks for a comparison decides what each reason means.

use crate::error::Error;

/// The reference shows nothing whose error could be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlit {
    /// No cloud pixel.
    NoCloud,
    /// Cloud pixels without sunlight on them: relative errors have no scale.
    NoSunlight,
}

/// Why [`super::compare`] has no numbers.
#[derive(Debug)]
pub enum Incomparable {
    /// There is nothing to measure.
    Unlit(Unlit),
    /// Channels of the reference, of 8 a pixel, that are NaN or infinite: it is no truth.
    NotFinite(u64),
    /// Pictures that do not fit together.
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
