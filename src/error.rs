//! The library's error type: every message names the file, the place in it and the remedy.

use std::path::{Path, PathBuf};

/// Everything that can go wrong in the core. The program prints it as one paragraph and exits with 2.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The user's input (configuration, scene, volume, command line) cannot be used.
    #[error("{place}: {problem}. {remedy}")]
    Input {
        /// File with line and column, or the command-line option.
        place: String,
        /// What is wrong, without a full stop.
        problem: String,
        /// What to do about it, a full sentence.
        remedy: String,
    },
    /// Reading or writing a file failed.
    #[error("{path}: cannot {action}: {source}. {remedy}", path = path.display())]
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
    /// No adapter, a limit of the adapter, a lost device, memory.
    #[error("adapter: {problem}. {remedy}")]
    Gpu {
        /// What the driver or the limit said.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// A shader does not compose or validate; carries the original file and line.
    #[error("shader {file}: {message}")]
    Shader {
        /// WGSL file the user can open.
        file: String,
        /// The compiler's message.
        message: String,
    },
    /// An image cannot be decoded or encoded.
    #[error("{path}: {message}", path = path.display())]
    Image {
        /// The image file.
        path: PathBuf,
        /// What is wrong and what would be accepted.
        message: String,
    },
    /// The user or a front end asked to stop.
    #[error("stopped on request; finished cells are kept, run the same command to go on")]
    Stopped,
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

    /// Whether it concerns one cell or view alone, so that a batch records it there and goes on: the adapter, the
    /// input, a shader. A disk that fails or a wish to stop concerns all.
    pub fn concerns_one_cell(&self) -> bool {
        matches!(
            self,
            Self::Gpu { .. } | Self::Input { .. } | Self::Shader { .. }
        )
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
