//! Places and quadrics in the user's coordinates.

use crate::classical::domain::LocatedVertex;
use crate::classical::duality::{DualOptions, DualityError, Quadric};
use crate::layout::LayoutError;
use crate::smooth_surface::{Affinity, Normalised};
use phex_mesh::Vec3;

/// The vertex of the input that is nearest to a place on the refined surface.
pub(in crate::pipeline) fn place_in(model: &Normalised, place: LocatedVertex) -> LocatedVertex {
    let distance = |p: &Vec3| (p - place.position).norm_squared();
    let all = model.surface.positions().enumerate();
    let nearest = all.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
    nearest.map_or(place, |(vertex, p)| LocatedVertex {
        vertex,
        position: model.affinity.restore(*p),
    })
}

/// The quadric that is asked for, in normalised coordinates.
pub(in crate::pipeline) fn quadric(
    options: &DualOptions,
    affinity: &Affinity,
) -> Result<Option<[f64; 10]>, LayoutError> {
    let normalised = |upper| {
        let quadric = Quadric::from_upper(upper)?;
        let there = quadric.normalised(affinity.centre, affinity.scale)?;
        Ok::<_, DualityError>(there.upper())
    };
    Ok(options.quadric.map(normalised).transpose()?)
}
