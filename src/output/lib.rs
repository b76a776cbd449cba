//! Output of measurements: reports with charts, tables and pages, and studies with their guides.
//!
//! Part of `occlab`, whose documentation starts with the architecture.

pub mod report;
pub mod study;

#[doc(no_inline)]
pub use occlab_measure::*;
