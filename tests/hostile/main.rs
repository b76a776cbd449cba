//! Input from outside, damaged at random: no reader panics, none takes memory that its file cannot account for, and what
//! is refused is refused in one paragraph that names the file.
//!
//! 256 cases a property; `PROPTEST_CASES=10000 cargo test --release --test hostile` is the long run.

mod config;
mod damage;
mod memory;
mod names;
mod numpy;
mod params;
mod pictures;
mod records;
mod volumes;
mod words;

use std::path::Path;

/// A message for people: one line of bounded length that names the file and says what to do.
fn is_one_paragraph(message: &str, path: &Path) -> bool {
    let name = path.file_name().unwrap().to_string_lossy();
    message.contains(&*name)
        && !message.chars().any(char::is_control)
        && message.chars().count() < 5000
}
