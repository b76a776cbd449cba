//! Reprojection: a pixel that is not marched takes the value of the previous picture at the place where the previous
//! camera saw the same point; where that history is rejected, the marched pixels around are interpolated.
//!
//! Works for any pattern on a rectangular grid (shear 0).

mod device;
mod oracle;

use super::{OracleSequence, Reconstruction};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::raymarch::DeviceSequence;
use crate::scene::{ImageSize, ReconstructionInfo};
use std::rc::Rc;

/// The reconstruction that an info describes.
pub(super) struct Reprojection(pub &'static ReconstructionInfo);

impl Reprojection {
    /// File of the pass after the march, below `shaders/`.
    pub const SHADER: &'static str = "reconstruct/temporal.wgsl";
    /// History of a sequence, bytes a pixel: two pictures of radiance, sunlight and inverse depth.
    pub const PIXEL_BYTES: u64 = 2 * (16 + 16 + 4);
}

impl Reconstruction for Reprojection {
    fn info(&self) -> &'static ReconstructionInfo {
        self.0
    }

    fn on_device(&self, gpu: &Gpu, image: ImageSize) -> Result<Rc<dyn DeviceSequence>> {
        let sequence = device::DeviceReprojection::new(gpu, image, self.0.pattern)?;
        Ok(Rc::new(sequence))
    }

    fn on_oracle(&self, image: ImageSize) -> Box<dyn OracleSequence> {
        Box::new(oracle::OracleReprojection::new(image, self.0.pattern))
    }
}
