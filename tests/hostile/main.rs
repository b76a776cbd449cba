//! Input from outside, damaged at random: no reader panics, none takes memory that its file cannot account for, and what
//! is refused is refused in one paragraph that names the file.
//!
//! 256 cases a property; `PROPTEST_CASES=10000 cargo test --release --test hostile` is the long run.

mod config;
mod damage;
mod memory;
mod names;
mod params;
mod pictures;
mod records;
mod volumes;

use proptest::test_runner::Config;
use std::path::Path;

/// Cases from `PROPTEST_CASES`, else 256. Failures print their input; what they find becomes a test of its own.
fn cases() -> Config {
    Config {
        failure_persistence: None,
        ..Config::default()
    }
}

/// A message for people: one line of bounded length that names the file and says what to do.
fn is_one_paragraph(message: &str, path: &Path) -> bool {
    let name = path.file_name().unwrap().to_string_lossy();
    message.contains(&*name)
        && !message.chars().any(char::is_control)
        && message.chars().count() < 5000
}
