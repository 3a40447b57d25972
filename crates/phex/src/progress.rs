//! Progress and cancelling: the one trait that long stages talk to.

use phex_mesh::PolygonSoup;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a stage says while it runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// A stage begins.
    StageStarted {
        /// Name of the stage.
        stage: &'static str,
    },
    /// A stage has ended.
    StageFinished {
        /// Name of the stage.
        stage: &'static str,
    },
    /// One step of an iteration.
    Iteration {
        /// Name of the stage.
        stage: &'static str,
        /// Number of the iteration, from 1.
        iteration: usize,
        /// Iterations at the most.
        limit: usize,
        /// What is driven to zero (planarity in mean edges, say).
        residual: f64,
    },
    /// A part of the work is done.
    Counted {
        /// Name of the stage.
        stage: &'static str,
        /// How many are done.
        done: usize,
        /// How many there are.
        total: usize,
    },
    /// Something that the user should know.
    Note {
        /// The message.
        message: String,
    },
}

/// Receives events, from one thread at a time, and may ask to stop, which is asked between steps
/// and by several threads.
pub trait Progress: Sync {
    /// Takes one event.
    fn report(&self, event: &Event);
    /// Whether the caller wants the run to end soon; what was reached is then returned as
    /// `Cancelled`.
    fn is_cancelled(&self) -> bool {
        false
    }
    /// Whether what a cancelled run has reached is wanted; if not, it ends without a mesh as soon
    /// as it can.
    fn wants_best(&self) -> bool {
        true
    }
    /// Offers what the mesh looks like after a stage, in model coordinates; `mesh` makes a copy of
    /// the panels, so it costs nothing unless it is called. It may not be valid.
    fn preview(&self, _stage: &'static str, _mesh: &dyn Fn() -> PolygonSoup) {}
}

/// Hears nothing, never cancels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _event: &Event) {}
}

/// Cancels as another does, and says nothing: work beside other work has no progress to tell of.
pub(crate) struct Quiet<'a> {
    other: &'a dyn Progress,
    unwanted: Option<&'a AtomicBool>,
}

impl<'a> Quiet<'a> {
    pub fn new(other: &'a dyn Progress) -> Self {
        Self {
            other,
            unwanted: None,
        }
    }

    /// The same, for work that is cancelled, too, once it is `unwanted`.
    pub fn unless(other: &'a dyn Progress, unwanted: &'a AtomicBool) -> Self {
        Self {
            other,
            unwanted: Some(unwanted),
        }
    }
}

impl Progress for Quiet<'_> {
    fn report(&self, _: &Event) {}

    fn is_cancelled(&self) -> bool {
        let unwanted = self.unwanted.is_some_and(|u| u.load(Ordering::Relaxed));
        unwanted || self.other.is_cancelled()
    }

    fn wants_best(&self) -> bool {
        self.other.wants_best()
    }
}
