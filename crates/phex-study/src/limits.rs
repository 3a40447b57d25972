//! Time and memory that a variant may take.

use phex::{Event, Progress};
use phex_job::JobError;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Milliseconds between two looks at the memory, which cost a system call.
const LOOK: u64 = 20;
/// Bytes in a megabyte.
const MEGABYTE: f64 = 1e6;

/// What a variant may take; nothing is limited by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VariantLimits {
    /// Seconds.
    pub seconds: Option<f64>,
    /// Megabytes (10⁶ bytes) of the whole process; Linux alone tells them.
    pub megabytes: Option<f64>,
}

impl VariantLimits {
    /// Refuses limits that can't be kept.
    ///
    /// # Errors
    /// If one is no positive number, or the system does not tell a process's memory.
    pub fn check(&self) -> Result<(), JobError> {
        let all = [("time", self.seconds), ("memory", self.megabytes)];
        for (name, limit) in all {
            if limit.is_some_and(|x| !(x.is_finite() && x > 0.0)) {
                let told = format!("the limit of {name} is {limit:?}, not a positive number");
                return Err(JobError::Input(told));
            }
        }
        match self.megabytes.is_some() && memory().is_none() {
            true => Err(JobError::input(
                "a limit of memory can't be kept here: only Linux tells what a process takes",
            )),
            false => Ok(()),
        }
    }

    /// Whether something that ended at these limits would go on under others.
    pub(crate) fn is_widened_by(&self, other: &Self) -> bool {
        let wider = |old: Option<f64>, new: Option<f64>| match (old, new) {
            (Some(old), Some(new)) => new > old,
            (Some(_), None) => true,
            (None, _) => false,
        };
        wider(self.seconds, other.seconds) || wider(self.megabytes, other.megabytes)
    }
}

/// Reads an amount of memory: `800MB`, `2GB`; a plain number is megabytes.
///
/// # Errors
/// If it is none.
pub fn memory_limit(text: &str) -> Result<f64, String> {
    const UNITS: [(&str, f64); 3] = [("GB", 1000.0), ("MB", 1.0), ("", 1.0)];
    let text = text.trim();
    let found = UNITS.iter().find_map(|(unit, size)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        Some(number * size)
    });
    found.filter(|m| m.is_finite() && *m > 0.0).ok_or_else(|| {
        format!("`{text}` is no amount of memory: give a number above 0 with MB or GB")
    })
}

/// Resident bytes of this process, where the system tells them.
pub(crate) fn memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split_whitespace().nth(1)?.parse().ok()?;
    // Linux has pages of 4096 bytes on the machines that phex is built for.
    Some(4096 * pages)
}

/// A computation's progress that ends it at limits.
pub(crate) struct Watch<'a> {
    inner: &'a dyn Progress,
    limits: VariantLimits,
    begun: Instant,
    /// Milliseconds after the beginning at which the memory was looked at.
    looked: AtomicU64,
    /// Largest memory that was seen, bytes.
    most: AtomicU64,
    /// Which limit was reached: 1 time, 2 memory.
    reached: AtomicUsize,
}

impl<'a> Watch<'a> {
    pub fn new(inner: &'a dyn Progress, limits: VariantLimits) -> Self {
        Self {
            inner,
            limits,
            begun: Instant::now(),
            looked: AtomicU64::new(0),
            most: AtomicU64::new(memory().unwrap_or(0)),
            reached: AtomicUsize::new(0),
        }
    }

    /// Seconds since the beginning.
    pub fn seconds(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    /// Largest memory that was seen, megabytes.
    pub fn megabytes(&self) -> f64 {
        self.look();
        self.most.load(Ordering::Relaxed) as f64 / MEGABYTE
    }

    /// The limit that ended the computation: the name of its state, and a sentence.
    pub fn ended(&self) -> Option<(&'static str, String)> {
        match (self.reached.load(Ordering::Relaxed), &self.limits) {
            (
                1,
                VariantLimits {
                    seconds: Some(s), ..
                },
            ) => Some(("time-limit", format!("it took more than {s} s"))),
            (
                2,
                VariantLimits {
                    megabytes: Some(m), ..
                },
            ) => Some((
                "memory-limit",
                format!("it took more than {m} MB of memory"),
            )),
            _ => None,
        }
    }

    fn look(&self) {
        self.most
            .fetch_max(memory().unwrap_or(0), Ordering::Relaxed);
    }

    /// Looks at the clock, and now and then at the memory.
    fn is_over(&self) -> bool {
        let now = self.begun.elapsed();
        let millis = u64::try_from(now.as_millis()).unwrap_or(u64::MAX);
        if millis >= self.looked.load(Ordering::Relaxed).saturating_add(LOOK) {
            self.looked.store(millis, Ordering::Relaxed);
            self.look();
        }
        let late = |s: f64| now >= Duration::try_from_secs_f64(s).unwrap_or(Duration::MAX);
        let large = |m: f64| self.most.load(Ordering::Relaxed) as f64 > m * MEGABYTE;
        let over = match self.limits {
            VariantLimits {
                seconds: Some(s), ..
            } if late(s) => 1,
            VariantLimits {
                megabytes: Some(m), ..
            } if large(m) => 2,
            _ => 0,
        };
        self.reached.fetch_max(over, Ordering::Relaxed);
        self.reached.load(Ordering::Relaxed) > 0
    }
}

impl Progress for Watch<'_> {
    fn report(&self, event: &Event) {
        self.inner.report(event);
    }

    fn is_cancelled(&self) -> bool {
        self.inner.is_cancelled() || self.is_over()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex::Silent;

    #[test]
    fn amounts_of_memory_are_read_with_their_unit() {
        assert_eq!(memory_limit("2GB"), Ok(2000.0));
        assert_eq!(memory_limit("1.5 MB"), Ok(1.5));
        assert_eq!(memory_limit("300"), Ok(300.0));
        for wrong in ["", "-1", "nan", "0", "5 kB", "infGB"] {
            assert!(memory_limit(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn limits_end_a_computation_and_say_which() {
        let free = Watch::new(&Silent, VariantLimits::default());
        assert!(!free.is_cancelled() && free.ended().is_none());
        let short = VariantLimits {
            seconds: Some(1e-9),
            megabytes: None,
        };
        let watch = Watch::new(&Silent, short);
        assert!(watch.is_cancelled());
        assert_eq!(watch.ended().unwrap().0, "time-limit");
        if memory().is_some() {
            let small = VariantLimits {
                seconds: None,
                megabytes: Some(0.001),
            };
            let watch = Watch::new(&Silent, small);
            assert!(watch.is_cancelled());
            assert_eq!(watch.ended().unwrap().0, "memory-limit");
        }
        assert!(short.is_widened_by(&VariantLimits::default()));
        assert!(!VariantLimits::default().is_widened_by(&short));
    }
}
