//! Jobs that end at a time, with the best mesh so far.

use crate::error::JobError;
use phex::{Event, Progress};
use phex_mesh::PolygonSoup;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long a job may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeLimit {
    /// All of its time.
    pub length: Duration,
    /// When that is over.
    pub until: Instant,
}

impl TimeLimit {
    /// A time that begins now; none if it has no end.
    pub fn from_now(length: Duration) -> Option<Self> {
        let until = Instant::now().checked_add(length)?;
        Some(Self { length, until })
    }
}

/// Reads a time: `90s`, `5min`, `1h`; a plain number is seconds.
///
/// # Errors
/// If it is none, or no time at all.
pub fn time_limit(text: &str) -> Result<Duration, String> {
    const UNITS: [(&str, f64); 4] = [("min", 60.0), ("h", 3600.0), ("s", 1.0), ("", 1.0)];
    let text = text.trim();
    let number = UNITS
        .iter()
        .find_map(|(unit, seconds)| Some((text.strip_suffix(unit)?, seconds)));
    let seconds = number.and_then(|(n, unit)| Some(n.trim().parse::<f64>().ok()? * unit));
    let duration = seconds.filter(|s| *s > 0.0);
    duration
        .and_then(|s| Duration::try_from_secs_f64(s).ok())
        .ok_or_else(|| format!("`{text}` is no time: give a number above 0 with s, min or h"))
}

/// The caller's progress, which also ends when the time is over, and keeps what is noted.
pub(crate) struct Timed<'a> {
    inner: &'a dyn Progress,
    limit: Option<TimeLimit>,
    /// Whether a caller who stops the job wants what it has reached.
    keep_best: bool,
    /// Whether the computation was told that the time is over.
    late: AtomicBool,
    /// What the computation has noted, in an order that does not depend on threads.
    noted: Mutex<BTreeSet<String>>,
}

impl<'a> Timed<'a> {
    pub fn new(inner: &'a dyn Progress, limit: Option<TimeLimit>, keep_best: bool) -> Self {
        Self {
            inner,
            limit,
            keep_best,
            late: AtomicBool::new(false),
            noted: Mutex::default(),
        }
    }

    /// What the computation has noted, for the report.
    pub fn noted(&self) -> Vec<String> {
        let noted = self.noted.lock().unwrap_or_else(PoisonError::into_inner);
        noted.iter().cloned().collect()
    }

    /// Whether the caller has stopped the job.
    pub fn was_stopped(&self) -> bool {
        self.inner.is_cancelled()
    }

    fn is_late(&self) -> bool {
        let late = self.limit.is_some_and(|l| Instant::now() >= l.until);
        self.late.fetch_or(late, Ordering::Relaxed) || late
    }

    /// What is said of a run that ended early; `is_free` if nothing was to be held.
    pub fn stopped(&self, is_free: bool) -> Option<String> {
        let why = match (self.was_stopped(), self.late.load(Ordering::Relaxed)) {
            (true, _) => "interrupted",
            (false, true) => "the time limit is over",
            (false, false) => return None,
        };
        let held = match is_free {
            true => "",
            false => "; vertices may not yet be held where they were to be",
        };
        Some(format!("{why}: this is the best mesh so far{held}"))
    }

    /// A run that ended early without a mesh: by itself, unless the caller stopped it.
    pub fn too_late(&self, error: JobError) -> JobError {
        match self.limit {
            Some(limit) if error == JobError::Cancelled && !self.was_stopped() => {
                JobError::NoResult(format!(
                    "no mesh was reached within {} s; allow more time, or ask for fewer panels",
                    limit.length.as_secs_f64()
                ))
            }
            _ => error,
        }
    }
}

impl Progress for Timed<'_> {
    fn report(&self, event: &Event) {
        if let Event::Note { message } = event {
            let mut noted = self.noted.lock().unwrap_or_else(PoisonError::into_inner);
            noted.insert(message.clone());
        }
        self.inner.report(event);
    }

    fn is_cancelled(&self) -> bool {
        self.inner.is_cancelled() || self.is_late()
    }

    fn wants_best(&self) -> bool {
        self.keep_best || !self.was_stopped()
    }

    fn preview(&self, stage: &'static str, mesh: &dyn Fn() -> PolygonSoup) {
        self.inner.preview(stage, mesh);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_unit() {
        let seconds = |text| time_limit(text).map(|d| d.as_secs_f64());
        assert_eq!(seconds("90s"), Ok(90.0));
        assert_eq!(seconds("1.5 min"), Ok(90.0));
        assert_eq!(seconds("2h"), Ok(7200.0));
        assert_eq!(seconds("0.25"), Ok(0.25));
        for wrong in ["", "s", "0s", "-3s", "nan", "1e300h", "5 days"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_job_whose_time_is_over_says_so() {
        let over = TimeLimit::from_now(Duration::ZERO);
        let timed = Timed::new(&phex::Silent, over, false);
        assert!(timed.is_cancelled() && !timed.was_stopped() && timed.wants_best());
        assert!(timed.stopped(true).unwrap().starts_with("the time limit"));
        let error = timed.too_late(JobError::Cancelled);
        assert!(matches!(error, JobError::NoResult(_)), "{error:?}");
    }
}
