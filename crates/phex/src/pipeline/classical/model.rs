//! Places and quadrics in the user's coordinates.

use crate::layout::LayoutError;
use crate::layout::domain::Place;
use crate::layout::duality::{DualOptions, DualityError, Quadric};
use crate::pipeline::PipelineError;
use crate::target::Similarity;
use phex_mesh::{TriangleSurface, Vec3};

/// What errors say of places: in the user's coordinates, and by the user's vertices.
pub(super) struct Model<'a> {
    pub normalised: &'a TriangleSurface,
    pub similarity: Similarity,
}

impl Model<'_> {
    /// The vertex of the input that is nearest to a place on the refined surface.
    pub fn place(&self, place: Place) -> Place {
        let distance = |p: &Vec3| (p - place.position).norm_squared();
        let all = self.normalised.positions().enumerate();
        let nearest = all.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        nearest.map_or(place, |(vertex, p)| Place {
            vertex,
            position: self.similarity.restore(*p),
        })
    }

    pub fn error(&self, error: PipelineError) -> PipelineError {
        match error {
            PipelineError::Layout(LayoutError::Domain(e)) => {
                LayoutError::from(e.mapped(|p| self.place(p))).into()
            }
            PipelineError::Layout(LayoutError::Duality(e)) => {
                LayoutError::from(e.mapped(|p| self.similarity.restore(p))).into()
            }
            other => other,
        }
    }
}

/// The quadric that is asked for, in normalised coordinates.
pub(super) fn quadric(
    options: &DualOptions,
    similarity: &Similarity,
) -> Result<Option<[f64; 10]>, LayoutError> {
    let normalised = |upper| {
        let quadric = Quadric::from_upper(upper)?;
        let there = quadric.normalised(similarity.centre, similarity.scale)?;
        Ok::<_, DualityError>(there.upper())
    };
    Ok(options.quadric.map(normalised).transpose()?)
}
