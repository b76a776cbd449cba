//! The `occlab` program.

fn main() {}
