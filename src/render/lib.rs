//! Rendering of pictures: light-occlusion methods, the ray marcher on the device, the f64 oracle, reconstructions.
//!
//! Part of `occlab`, whose documentation starts with the architecture.

pub mod occlusion;
pub mod oracle;
pub mod raymarch;
pub mod reconstruct;

#[doc(no_inline)]
pub use occlab_input::*;
