//! Reports: charts, tables, pages, guides, studies.
//!
//! Part of `occlab`, whose documentation starts with the architecture.

pub mod report;
pub mod study;

#[doc(no_inline)]
pub use occlab_measure::*;
