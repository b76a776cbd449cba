//! The density field: imported volumes.

pub mod volume;
