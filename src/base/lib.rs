//! The parts that need neither a scene nor a method: errors, parameters, devices, pictures and their error numbers.
//!
//! Part of `occlab`, whose documentation starts with the architecture.

pub mod cost;
pub mod error;
pub mod file_part;
pub mod frame;
pub mod gpu;
pub mod metrics;
pub mod param;
pub mod problem;
pub mod progress;
pub mod shader_defs;

pub use error::{Error, Result};
