//! Numbers: backends, truths, batches of cells, sweeps of stability, and what a build is made from.
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
