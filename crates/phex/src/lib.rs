//! From a surface to a planar hexagonal mesh.
//!
//! Data flows `target -> curvature -> directions -> layout -> optimise -> report`; a stage uses earlier stages only.
//!
//! | stage | what it computes |
//! |---|---|
//! | [`layout`] | the panelling's connectivity and first positions |
//! | [`optimise`] | planar, simple panels close to the surface |
//! | [`report`] | what was reached: figures, checks, verdict, a picture |

pub mod layout;
pub mod optimise;
pub mod progress;
pub mod report;

pub use progress::{Event, Progress, Silent};
