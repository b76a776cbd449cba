//! The reconstruction that marches every pixel in every frame.

use super::{OracleSequence, Reconstruction};
use crate::cost::Counts;
use crate::error::Result;
use crate::frame::Frame;
use crate::gpu::Gpu;
use crate::oracle::Occlusion;
use crate::progress::Progress;
use crate::raymarch::{DeviceSequence, Frames};
use crate::scene::{ImageSize, Pattern, ReconstructionInfo, RestInfo};
use std::rc::Rc;

/// Description of the reconstruction.
pub(super) static INFO: ReconstructionInfo = ReconstructionInfo {
    id: ReconstructionInfo::FULL,
    title: "Full pictures",
    brief: "every pixel in every frame",
    doc: "Every pixel is marched in every frame.",
    frame: "A frame marches every pixel.",
    citation: "",
    shaders: &[],
    pattern: Pattern::EVERY,
    smallest: [1, 1],
    history: None,
    rest: RestInfo {
        frames: 1,
        exact: true,
    },
};

/// The reconstruction.
pub(super) struct Full;

/// The last picture.
#[derive(Default)]
struct OraclePicture(Option<Frame>);

impl Reconstruction for Full {
    fn info(&self) -> &'static ReconstructionInfo {
        &INFO
    }

    fn on_device(&self, _gpu: &Gpu, _image: ImageSize) -> Result<Rc<dyn DeviceSequence>> {
        Ok(Frames::full())
    }

    fn on_oracle(&self, _image: ImageSize) -> Box<dyn OracleSequence> {
        Box::new(OraclePicture::default())
    }
}

impl OracleSequence for OraclePicture {
    fn render(&mut self, method: &Occlusion<'_>, progress: Progress) -> Result<Counts> {
        let (frame, counts) = method.render(progress)?;
        self.0 = Some(frame);
        Ok(counts)
    }

    fn picture(&self) -> Option<Frame> {
        self.0.clone()
    }
}
