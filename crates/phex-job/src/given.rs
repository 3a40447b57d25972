//! What the files that settings name hold, or what a caller has in memory.

use crate::error::JobError;
use crate::guides::add_cone;
use crate::settings::MeshSettings;
use crate::size_field::read_sizes;
use crate::steering::{add_anchor, add_fixed};
use phex::directions::Guides;
use phex::optimise::Steering;

/// Sizes, lines, cones and held points as values; nothing by default.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// Length of the panels' edges at each vertex of the input, in its order.
    pub size_field: Option<Vec<f64>>,
    /// Points, curves and anchors, model units.
    pub steering: Steering,
    /// Lines and cones, model units.
    pub guides: Guides,
}

impl Given {
    /// Reads the files that settings name.
    ///
    /// # Errors
    /// If one can't be read, or a line of it is wrong.
    pub fn read(settings: &MeshSettings) -> Result<Self, JobError> {
        let sizes = settings.size_field.as_deref().map(read_sizes);
        Ok(Self {
            size_field: sizes.transpose()?,
            steering: settings.steering.read()?,
            guides: settings.guides.read()?,
        })
    }

    /// Adds a line of numbers to the list of an option: `fix`, `anchors` or `cones`.
    ///
    /// # Errors
    /// What is wanted instead, if the line is something else.
    pub fn add(&mut self, option: &str, numbers: &[f64]) -> Result<(), &'static str> {
        match option {
            "fix" => add_fixed(&mut self.steering, numbers),
            "anchors" => add_anchor(&mut self.steering, numbers),
            _ => add_cone(&mut self.guides, numbers),
        }
    }
}
