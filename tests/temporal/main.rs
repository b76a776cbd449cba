//! Reconstructed pictures: properties of all reconstructions; temporal integration at rest, its reprojection in motion,
//! and the device against its f64 twin; the records.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/program.rs"]
mod program;

mod every;
mod motion;
mod records;
mod sequence;
mod twin;
