//! Exact pictures of one view, kept while only the methods change.

use super::Request;
use super::update::{Drawn, Rgb, What};
use crate::cost::{Memory, PassTimes};
use crate::frame::{Exposure, Frame, tone_map};
use crate::occlusion::MethodSetup;
use crate::raymarch::BAND_ROWS;
use crate::scene::{ImageSize, Scene};
use std::sync::Arc;

/// Exact pictures of a scene at one image size.
pub(super) struct Stage {
    scene: Scene,
    image: ImageSize,
    finished: Vec<(MethodSetup, Finished)>,
    /// The truth, once it is complete.
    pub truth: Option<Arc<Frame>>,
    /// Exposure of the truth; until there is one, of the first picture.
    exposure: Option<Exposure>,
}

/// An exact picture.
#[derive(Clone)]
pub(super) struct Finished {
    pub frame: Arc<Frame>,
    pub cost: (PassTimes, Memory),
}

impl Stage {
    /// An empty stage for a request's view. Until its truth is there pictures keep the `exposure` of the previous view.
    pub fn new(request: &Request, exposure: Option<Exposure>) -> Self {
        Self {
            scene: request.scene.clone(),
            image: request.image,
            finished: Vec::new(),
            truth: None,
            exposure,
        }
    }

    /// Whether the request has the same scene and image size.
    pub fn shows(&self, request: &Request) -> bool {
        self.scene == request.scene && self.image == request.image
    }

    /// Exposure that the next view starts with.
    pub fn exposure(&self) -> Option<Exposure> {
        self.exposure
    }

    /// The exact picture of a method, if it is there.
    pub fn finished(&self, setup: &MethodSetup) -> Option<&Finished> {
        let found = self.finished.iter().find(|(known, _)| known == setup);
        found.map(|(_, finished)| finished)
    }

    /// Keeps the exact picture of a method; the truth, also when it was chosen as a method, sets the exposure.
    pub fn keep(&mut self, setup: &MethodSetup, finished: Finished) {
        if MethodSetup::truth(&self.scene).is_ok_and(|truth| truth == *setup) {
            self.exposure = Some(Exposure::from_reference(&finished.frame));
            self.truth = Some(finished.frame.clone());
        }
        self.finished.retain(|(known, _)| known != setup);
        self.finished.push((setup.clone(), finished));
    }

    /// An exact picture for the screen.
    pub fn exact(&mut self, what: What, finished: &Finished) -> Drawn {
        let cost = Some(finished.cost);
        self.drawn(what, finished.frame.clone(), 1, 1.0, cost)
    }

    /// A picture for the screen.
    pub fn drawn(
        &mut self,
        what: What,
        frame: Arc<Frame>,
        factor: u32,
        share: f64,
        cost: Option<(PassTimes, Memory)>,
    ) -> Drawn {
        let exposure = *self
            .exposure
            .get_or_insert_with(|| Exposure::from_reference(&frame));
        Drawn {
            what,
            rgb: Arc::new(Rgb {
                width: frame.width,
                height: frame.height,
                pixels: tone_map(&frame, exposure),
            }),
            frame,
            factor,
            share,
            cost,
        }
    }
}

/// An image size with one pixel for `factor` × `factor` pixels, rounded up.
pub(super) fn coarser(image: ImageSize, factor: u32) -> ImageSize {
    ImageSize {
        width: image.width.div_ceil(factor),
        height: image.height.div_ceil(factor),
    }
}

/// A picture of which the bands up to `share` are rendered; the others are taken from a `coarse` one of the same view.
pub(super) fn filled(mut frame: Frame, share: f64, coarse: &Frame) -> Frame {
    let bands = (share * f64::from(frame.height) / f64::from(BAND_ROWS)).floor();
    let done = (bands as u32 * BAND_ROWS).min(frame.height);
    for y in done..frame.height {
        let from_y = y * coarse.height / frame.height;
        for x in 0..frame.width {
            let from = from_y * coarse.width + x * coarse.width / frame.width;
            let (from, to) = (from as usize, (y * frame.width + x) as usize);
            frame.radiance[to] = coarse.radiance[from];
            frame.sun[to] = coarse.sun[from];
        }
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: u32, height: u32, value: f32) -> Frame {
        let pixels = vec![[value; 4]; (width * height) as usize];
        Frame {
            width,
            height,
            radiance: pixels.clone(),
            sun: pixels,
        }
    }

    #[test]
    fn what_is_not_rendered_comes_from_the_coarse_picture() {
        let (fine, coarse) = (frame(16, 24, 1.0), frame(4, 6, 2.0));
        let rows = |share| {
            let filled = filled(fine.clone(), share, &coarse);
            let fine = filled.sun.iter().filter(|p| p[0] == 1.0).count();
            let radiance = filled.radiance.iter().filter(|p| p[0] == 1.0).count();
            assert_eq!(fine, radiance);
            fine / 16
        };
        assert_eq!([rows(0.0), rows(0.34), rows(0.6), rows(1.0)], [0, 8, 8, 24]);
    }

    #[test]
    fn no_picture_is_without_pixels() {
        let image = ImageSize {
            width: 1,
            height: 9,
        };
        assert_eq!(
            coarser(image, 8),
            ImageSize {
                width: 1,
                height: 2
            }
        );
    }
}
