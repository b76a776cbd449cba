//! Reconstructed pictures: what all of them must keep; of temporal integration nothing at rest, reprojection on the move, the
//! device against its f64 twin; the records.

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
