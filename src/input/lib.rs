//! Input of a measurement: density fields, scenes and experiments, read from JSON.
//!
//! Part of `occlab`, whose documentation starts with the architecture.

pub mod config;
pub mod container;
pub mod density;
pub mod scene;

#[doc(no_inline)]
pub use occlab_base::*;
