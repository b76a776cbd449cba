//! Pictures: light-occlusion methods, the ray marcher of the device, the oracle in f64, reconstructions.
//!
//! Part of `occlab`, whose documentation starts with the architecture.

pub mod occlusion;
pub mod oracle;
pub mod raymarch;
pub mod reconstruct;

#[doc(no_inline)]
pub use occlab_input::*;
