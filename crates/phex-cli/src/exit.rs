//! Exit codes, and failures that carry one.

use phex_job::JobError;
use std::fmt;
use std::process::ExitCode;

/// What the program's exit code says; the numbers are part of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Written, and every check passes.
    Success = 0,
    /// An internal error, or reading or writing failed half-way.
    Internal = 1,
    /// The command line can't be understood.
    Usage = 2,
    /// Written, but a figure is outside a tolerance.
    OutsideTolerance = 3,
    /// A file, path or value can't be used; nothing was written.
    InputUnusable = 4,
    /// No valid mesh was reached; nothing was written unless asked for.
    NoValidResult = 5,
    /// Interrupted; no file is half written.
    Interrupted = 130,
}

/// The table that `--help` ends with.
pub const EXIT_CODES: &str = "Exit codes:
  0    written, and every check passes
  1    internal error, or input or output failed half-way
  2    the command line can't be understood
  3    written, but a figure is outside a tolerance (`check`: a check fails)
  4    a file, path or value can't be used (the message names element and cause); no file is touched
  5    no valid mesh was reached; the mesh file is not written (unless --keep-invalid)
  130  interrupted; no file is half written (with --keep-best, once there is a mesh: 0, 3 or 5 as above)";

impl Exit {
    /// The exit code of a command that judges: whether every figure is within its tolerance.
    pub fn of_check(passes: bool) -> Self {
        match passes {
            true => Self::Success,
            false => Self::OutsideTolerance,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// An error together with the exit code that it ends the program with.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What went wrong.
    pub cause: anyhow::Error,
}

impl Failure {
    /// A failure with a message.
    pub fn new(
        exit: Exit,
        message: impl fmt::Display + fmt::Debug + Send + Sync + 'static,
    ) -> Self {
        Self {
            exit,
            cause: anyhow::Error::msg(message),
        }
    }

    /// A file, path or value that can't be used.
    pub fn input(message: impl fmt::Display + fmt::Debug + Send + Sync + 'static) -> Self {
        Self::new(Exit::InputUnusable, message)
    }

    /// The user interrupted the run.
    pub fn interrupted() -> Self {
        Self::new(Exit::Interrupted, "interrupted")
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#}", self.cause)
    }
}

impl From<anyhow::Error> for Failure {
    fn from(cause: anyhow::Error) -> Self {
        Self {
            exit: Exit::Internal,
            cause,
        }
    }
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        let exit = match error {
            JobError::Input(_) => Exit::InputUnusable,
            JobError::NoResult(_) => Exit::NoValidResult,
            JobError::Cancelled => Exit::Interrupted,
            JobError::Internal(_) => Exit::Internal,
        };
        Self {
            exit,
            cause: error.into(),
        }
    }
}

/// Gives an error its exit code.
pub trait OrExit<T> {
    /// The value, or a failure with this exit code.
    fn or_exit(self, exit: Exit) -> Result<T, Failure>;
}

impl<T, E: Into<anyhow::Error>> OrExit<T> for Result<T, E> {
    fn or_exit(self, exit: Exit) -> Result<T, Failure> {
        self.map_err(|cause| Failure {
            exit,
            cause: cause.into(),
        })
    }
}
