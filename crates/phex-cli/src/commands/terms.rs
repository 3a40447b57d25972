//! `phex terms`: what the words of the tables mean.

use super::tell;
use crate::args::TermsCommand;
use crate::exit::{Exit, Failure};
use crate::terms::TERMS;

/// Runs the command.
///
/// # Errors
/// If standard output can't be written.
pub fn run(command: &TermsCommand) -> Result<Exit, Failure> {
    tell(command.talk.quiet, &format!("{TERMS}\n"))?;
    Ok(Exit::Success)
}
