//! Where the time goes.

use super::error::PipelineError;
use crate::progress::{Event, Progress};
use serde::Serialize;
use std::time::Instant;

/// Seconds that a stage took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Name of the stage.
    pub stage: &'static str,
    /// Wall time, seconds, summed over repeats.
    pub seconds: f64,
}

/// Names stages to the progress and sums their times.
pub(super) struct Clock<'a> {
    pub progress: &'a dyn Progress,
    pub stages: Vec<StageSeconds>,
}

impl<'a> Clock<'a> {
    pub fn new(progress: &'a dyn Progress) -> Self {
        Self {
            progress,
            stages: Vec::new(),
        }
    }

    /// Adds what another clock measured.
    pub fn add(&mut self, stages: &[StageSeconds]) {
        for StageSeconds { stage, seconds } in stages {
            match self.stages.iter_mut().find(|s| s.stage == *stage) {
                Some(s) => s.seconds += seconds,
                None => self.stages.push(StageSeconds {
                    stage,
                    seconds: *seconds,
                }),
            }
        }
    }

    /// A stage before there is a mesh: a cancelled run ends here.
    pub fn stage<T>(
        &mut self,
        stage: &'static str,
        work: impl FnOnce() -> T,
    ) -> Result<T, PipelineError> {
        if self.progress.is_cancelled() {
            return Err(PipelineError::Cancelled);
        }
        Ok(self.timed(stage, work))
    }

    /// Ends a cancelled run of which nothing is wanted.
    pub fn unless_unwanted(&self) -> Result<(), PipelineError> {
        match self.progress.is_cancelled() && !self.progress.wants_best() {
            true => Err(PipelineError::Cancelled),
            false => Ok(()),
        }
    }

    /// A stage that a cancelled run still makes, because what was reached is returned.
    pub fn timed<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        self.progress.report(&Event::StageStarted { stage });
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        self.progress.report(&Event::StageFinished { stage });
        self.add(&[StageSeconds { stage, seconds }]);
        result
    }
}
