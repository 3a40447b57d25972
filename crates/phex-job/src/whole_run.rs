//! How much of a whole run is done, and how long the rest takes, about.
//!
//! How many layouts a run tries, and how long it searches, is known only when it ends. So every
//! stage that ends takes a share of what was left, a smaller one each time that it comes again, and
//! iterations lead up to the end of theirs: the share that is done never falls and is 1 only in the
//! end. What is left is estimated from the time that it took to come here.

use phex::Event;
use serde::Serialize;
use std::collections::HashMap;
use std::fmt;
use std::time::{Duration, Instant};

/// Share of what is left that a stage takes, the first time.
const SHARES: [(&str, f64); 6] = [
    ("curvature", 0.03),
    ("directions", 0.06),
    ("layout", 0.12),
    ("optimise", 0.4),
    ("trim", 0.06),
    ("search", 0.5),
];
/// The same for a stage that is not listed.
const OTHER: f64 = 0.04;
/// Share of the way to the end of a stage that an iteration takes.
const ITERATION: f64 = 0.03;
/// Shares done, and time, after which there is something new to say.
const NEWS: f64 = 0.005;
const SILENCE: Duration = Duration::from_secs(1);

/// What is said of a whole run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename = "progress")]
pub struct WholeProgress {
    /// Share that is done, from 0 to 1; it never falls.
    pub done: f64,
    /// Seconds since the start.
    pub elapsed_seconds: f64,
    /// Seconds that are left, about.
    pub left_seconds: f64,
}

impl fmt::Display for WholeProgress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = 100.0 * self.done;
        write!(f, "{percent:.0} %, about {:.0} s left:", self.left_seconds)
    }
}

/// A run that is watched.
pub struct WholeRun {
    start: Instant,
    done: f64,
    /// What will be done when the stage that runs has ended.
    goal: f64,
    /// How many times each stage has begun.
    begun: HashMap<&'static str, u32>,
    told: f64,
    told_at: Instant,
}

impl Default for WholeRun {
    /// A run that begins now.
    fn default() -> Self {
        let start = Instant::now();
        Self {
            start,
            done: 0.0,
            goal: 0.0,
            begun: HashMap::new(),
            told: 0.0,
            told_at: start,
        }
    }
}

impl WholeRun {
    /// Takes an event; tells how far the run is if that is news. `most` is the time that is left at
    /// the most.
    pub fn take(&mut self, event: &Event, most: Option<Duration>) -> Option<WholeProgress> {
        match event {
            Event::StageStarted { stage } => self.begin(stage),
            Event::StageFinished { .. } => self.done = self.done.max(self.goal),
            Event::Iteration { .. } => self.done += ITERATION * (self.goal - self.done).max(0.0),
            Event::Counted { done, total, .. } => {
                let left = (self.goal - self.done).max(0.0);
                self.done += left / (total.saturating_sub(*done) + 1) as f64;
            }
            Event::Note { .. } => {}
        }
        let news = self.done - self.told >= NEWS || self.told_at.elapsed() >= SILENCE;
        news.then(|| self.tell(most))
    }

    /// The run has ended.
    pub fn end(&mut self) -> WholeProgress {
        self.done = 1.0;
        self.tell(None)
    }

    fn begin(&mut self, stage: &'static str) {
        let times = self.begun.entry(stage).or_default();
        *times += 1;
        let listed = SHARES.iter().find(|(name, _)| *name == stage);
        let share = listed.map_or(OTHER, |(_, share)| *share) / f64::from(*times);
        self.goal = self.goal.max(self.done + share * (1.0 - self.done));
    }

    fn tell(&mut self, most: Option<Duration>) -> WholeProgress {
        (self.told, self.told_at) = (self.done, Instant::now());
        let elapsed = self.start.elapsed().as_secs_f64();
        let left = elapsed * (1.0 - self.done) / self.done.max(NEWS);
        WholeProgress {
            done: self.done,
            elapsed_seconds: elapsed,
            left_seconds: most.map_or(left, |m| left.min(m.as_secs_f64())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounds over rounds, with iterations that repeat one number.
    #[test]
    fn a_run_s_progress_never_goes_back_and_ends_at_one() {
        let mut run = WholeRun::default();
        let mut last = 0.0;
        let mut hear = |event: &Event| {
            if let Some(told) = run.take(event, Some(Duration::from_secs(7))) {
                assert!(told.done >= last && told.done < 1.0, "{told:?}");
                assert!((0.0..=7.0).contains(&told.left_seconds), "{told:?}");
                last = told.done;
            }
        };
        for _ in 0..30 {
            for stage in ["curvature", "directions", "layout", "optimise", "trim"] {
                hear(&Event::StageStarted { stage });
                for _ in 0..200 {
                    hear(&Event::Iteration {
                        stage,
                        iteration: 3,
                        limit: 60,
                        residual: 1.0,
                    });
                }
                hear(&Event::StageFinished { stage });
            }
        }
        assert!(last > 0.9, "{last}");
        assert_eq!(run.end().done, 1.0);
    }
}
