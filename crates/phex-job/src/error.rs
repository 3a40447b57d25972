//! Why a job has no result.

use std::error::Error;
use std::fmt::Display;

/// Why a job has no result; each kind asks for something else of the user.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JobError {
    /// A file, value or element can't be used; the message names it and the cause.
    #[error("{0}")]
    Input(String),
    /// The input can be used, and no panelling was found.
    #[error("{0}")]
    NoResult(String),
    /// The caller asked to stop.
    #[error("interrupted")]
    Cancelled,
    /// A bug, or a machine that fails.
    #[error("{0}")]
    Internal(String),
}

impl JobError {
    /// Something that can't be used.
    pub fn input(message: impl Display) -> Self {
        Self::Input(message.to_string())
    }

    /// An error of a library in what is given.
    pub(crate) fn unusable(error: &dyn Error) -> Self {
        Self::Input(chain(error))
    }

    /// The same of a part of what is given.
    pub(crate) fn of_part(self, part: &str) -> Self {
        match self {
            Self::Input(cause) => Self::Input(format!("{part}: {cause}")),
            Self::NoResult(cause) => Self::NoResult(format!("{part}: {cause}")),
            other => other,
        }
    }

    /// The same in a file.
    pub(crate) fn in_file(path: &std::path::Path, error: &dyn Error) -> Self {
        Self::Input(format!("{}: {}", path.display(), chain(error)))
    }

    /// What should not happen, while something was done.
    pub(crate) fn internal(doing: &str, error: &dyn Error) -> Self {
        Self::Internal(format!("{doing}: {}", chain(error)))
    }
}

/// An error with its causes, in one line.
pub fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(next) = cause {
        text = format!("{text}: {next}");
        cause = next.source();
    }
    text
}
