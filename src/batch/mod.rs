//! Experiment → stream of events → records on disk.

pub mod record;
