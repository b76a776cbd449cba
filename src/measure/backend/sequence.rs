//! Sequences of frames, on either backend.

use super::Backend;
use crate::error::Result;
use crate::raymarch::DeviceSequence;
use crate::reconstruct::{self, OracleSequence, Reconstruction};
use crate::scene::{ImageSize, ReconstructionInfo};
use std::cell::RefCell;
use std::rc::Rc;

/// Consecutive frames and their history. Views of one sequence have one size and may differ in their cameras.
#[derive(Clone)]
pub struct Sequence {
    pub(super) reconstruction: &'static dyn Reconstruction,
    pub(super) kind: SequenceKind,
}

#[derive(Clone)]
pub(super) enum SequenceKind {
    Device(Rc<dyn DeviceSequence>),
    Oracle(Rc<RefCell<Box<dyn OracleSequence>>>),
}

impl Backend {
    /// A sequence whose history is still empty.
    pub fn sequence(&self, info: &ReconstructionInfo, image: ImageSize) -> Result<Sequence> {
        let reconstruction = reconstruct::find(info.id)?;
        reconstruction.info().check_size(image)?;
        let kind = match self {
            Self::Device(renderer) => {
                SequenceKind::Device(reconstruction.on_device(&renderer.gpu, image)?)
            }
            Self::Oracle(_) => {
                SequenceKind::Oracle(Rc::new(RefCell::new(reconstruction.on_oracle(image))))
            }
        };
        Ok(Sequence {
            reconstruction,
            kind,
        })
    }
}
