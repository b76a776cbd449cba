//! Measurement: backends, truths, batches of cells, stability sweeps, and the provenance of a build.
//!
//! Part of `occlab`, whose documentation starts with the architecture.

pub mod backend;
pub mod batch;
#[cfg(test)]
#[path = "../../tests/hostile/damage.rs"]
mod damage;
pub mod environment;
pub mod probe;
pub mod provenance;
pub mod stability;
pub mod truth;

#[doc(no_inline)]
pub use occlab_render::*;
