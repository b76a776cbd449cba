//! The light-occlusion strategies and their registry.

pub mod param;
