//! The library's error type: every message names the file, the place in it and the remedy.

use std::fmt::{Display, Formatter, Write as _};
use std::path::{Path, PathBuf};

/// Longest part of a message, characters: a key of a megabyte must not fill the terminal.
const MAX_PART_CHARS: usize = 1000;

/// Last sentence of a defect's message: what to report, and where.
pub const REPORT: &str = concat!(
    "This is a defect of occlab ",
    env!("CARGO_PKG_VERSION"),
    ", not of your input: please report this message, with the command and the files it read, where you got the program."
);

/// Everything that can go wrong in the core. The program prints it as one paragraph and exits with 2.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The user's input (configuration, scene, volume, command line) cannot be used.
    #[error("{}: {}. {}", Escaped(place), Escaped(problem), Escaped(remedy))]
    Input {
        /// File with line and column, or the command-line option.
        place: String,
        /// What is wrong, without a full stop.
        problem: String,
        /// What to do about it, a full sentence.
        remedy: String,
    },
    /// Reading or writing a file failed.
    #[error("{}: cannot {action}: {source}. {remedy}", Escaped(path.display()))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// `read`, `write`, `create`…
        action: &'static str,
        /// The operating system's reason.
        source: std::io::Error,
        /// What to do about it.
        remedy: &'static str,
    },
    /// No adapter, a limit of the adapter exceeded, a lost device, or out of memory.
    #[error("adapter: {}. {}", Escaped(problem), Escaped(remedy))]
    Gpu {
        /// What the driver or the limit said.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// A shader does not compose or validate, or does not fit what is bound to it; carries the original file and line.
    /// For the program's own shaders the message says that this is a defect.
    #[error("shader {file}: {message}")]
    Shader {
        /// WGSL file the user can open.
        file: String,
        /// The compiler's message.
        message: String,
    },
    /// An image cannot be decoded or encoded.
    #[error("{}: {}", Escaped(path.display()), Escaped(message))]
    Image {
        /// The image file.
        path: PathBuf,
        /// What is wrong and what would be accepted.
        message: String,
    },
    /// An internal inconsistency, which no user, file or driver can cause: a bug of the program.
    #[error("{}: {}. {REPORT}", Escaped(place), Escaped(problem))]
    Defect {
        /// The part of the program.
        place: String,
        /// What it found, without a full stop.
        problem: String,
    },
    /// The user or a front end asked to stop.
    #[error("stopped on request; finished cells are kept, run the same command to go on")]
    Stopped,
}

/// External text as part of a message: control characters are written as escapes, so that a name can neither break the
/// line nor send control sequences to the terminal; the middle of very long text is left out.
struct Escaped<T>(T);

impl<T: Display> Display for Escaped<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let text = self.0.to_string();
        let count = text.chars().count();
        let half = MAX_PART_CHARS / 2;
        let cut = count > MAX_PART_CHARS;
        for (i, c) in text.chars().enumerate() {
            match c {
                _ if cut && i == half => f.write_char('…')?,
                _ if cut && (half..count - half).contains(&i) => {}
                c if c.is_control() => write!(f, "{}", c.escape_default())?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

/// Result with the library's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An [`Error::Input`].
    pub fn input(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Input {
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// An [`Error::Gpu`].
    pub fn gpu(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Gpu {
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// An [`Error::Defect`].
    pub fn defect(place: impl Into<String>, problem: impl Display) -> Self {
        Self::Defect {
            place: place.into(),
            problem: problem.to_string(),
        }
    }

    /// Whether the error concerns one cell or view alone, so that a batch records it there and goes on: errors of the
    /// adapter or of the input do. A failed file access and [`Error::Stopped`] end the batch. So do a defect and a
    /// shader that does not compile: a batch runs the program's own shaders, and in a cell's record the error would
    /// read like a user error.
    pub fn concerns_one_cell(&self) -> bool {
        matches!(self, Self::Gpu { .. } | Self::Input { .. })
    }

    /// Closure for `map_err` after a failed read of `path`.
    pub fn reading(path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io {
            path,
            action: "read",
            source,
            remedy: "Check the path and its permissions.",
        }
    }

    /// Closure for `map_err` after a failed write of `path`.
    pub fn writing(path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io {
            path,
            action: "write",
            source,
            remedy: "Free space or choose another folder, then run the same command again: finished cells are kept.",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_of_bounded_length_whatever_it_quotes() {
        let name = format!("a\nb\u{1b}[2J{}z", "é".repeat(1 << 20));
        let error = Error::input(&name, &name, &name).to_string();
        assert!(error.starts_with("a\\nb\\u{1b}[2Jé") && error.ends_with("éz"));
        assert!(error.chars().count() < 4 * MAX_PART_CHARS);
        assert!(!error.chars().any(char::is_control));
        let path = Path::new("a\nb");
        let io = Error::reading(path)(std::io::ErrorKind::NotFound.into());
        assert!(io.to_string().starts_with("a\\nb: cannot read"));
        assert_eq!(Error::input("p", "q", "R.").to_string(), "p: q. R.");
    }

    #[test]
    fn a_defect_says_what_to_report_and_is_never_the_failure_of_a_cell() {
        let defect = Error::defect("charts", "a\nb");
        let message = defect.to_string();
        assert!(message.starts_with("charts: a\\nb. This is a defect of occlab "));
        assert!(message.contains("report this message") && message.ends_with('.'));
        assert!(!defect.concerns_one_cell());
        assert!(Error::input("p", "q", "R.").concerns_one_cell());
    }
}
