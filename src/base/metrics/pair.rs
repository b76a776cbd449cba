//! A picture and its truth, with intermediate results that several error numbers share.

use super::linear::{self, Linear};
use super::perceptual::{self, Flip};
use super::{Incomparable, check_pair};
use crate::frame::{Exposure, Frame, tone_map};

/// Two pictures that can be compared: the argument of the functions of [`super::METRICS`].
pub(super) struct Pair<'a> {
    /// The truth; finite, with sunlight on cloud pixels.
    pub reference: &'a Frame,
    /// The picture, of the same size.
    pub test: &'a Frame,
    /// Errors in linear light.
    pub linear: Linear,
    /// Both pictures tone-mapped, and their perceived difference.
    pub seen: Seen,
}

/// Both pictures tone-mapped at one exposure taken from the truth.
pub(super) struct Seen {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// The truth, 8-bit sRGB.
    pub truth: Vec<u8>,
    /// The picture, likewise.
    pub picture: Vec<u8>,
    /// Perceived difference.
    pub flip: Flip,
}

impl<'a> Pair<'a> {
    /// Refuses pictures that cannot be compared.
    pub fn new(reference: &'a Frame, test: &'a Frame) -> Result<Self, Incomparable> {
        check_pair(reference, test)?;
        Ok(Self {
            reference,
            test,
            linear: linear::measure(reference, test)?,
            seen: Seen::new(reference, test),
        })
    }
}

impl Seen {
    fn new(reference: &Frame, test: &Frame) -> Self {
        let exposure = Exposure::from_reference(reference);
        let size = (reference.width, reference.height);
        let (truth, picture) = (tone_map(reference, exposure), tone_map(test, exposure));
        Self {
            size,
            flip: perceptual::flip(size, &truth, &picture),
            truth,
            picture,
        }
    }
}
