//! How many threads a job may have.

use crate::error::JobError;

/// The most threads that are started: each takes memory, and more than cores help nobody.
const MOST_THREADS: u16 = 1024;

/// A number of threads for a pool; 0, which means all cores, where nothing is asked for.
///
/// # Errors
/// If it is 0, or more than makes sense.
pub fn thread_count(threads: Option<u16>) -> Result<usize, JobError> {
    match threads {
        None => Ok(0),
        Some(n) if (1..=MOST_THREADS).contains(&n) => Ok(usize::from(n)),
        Some(n) => Err(JobError::Input(format!(
            "{n} threads are asked for, from 1 to {MOST_THREADS} make sense"
        ))),
    }
}
