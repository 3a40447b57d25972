//! The options for the normalised surface.

use super::{MeshOptions, Method, PipelineError, brick_wall, classical};
use crate::layout::LayoutError;
use crate::ranges::without_unit;
use crate::smooth_surface::Normalised;
use phex_mesh::Vec3;

/// The options for the normalised surface.
pub(super) fn normalised(
    given: &MeshOptions,
    model: &Normalised,
) -> Result<MeshOptions, PipelineError> {
    let mut options = match given.method {
        Method::BrickWall => brick_wall::with_corners(given),
        _ => given.clone(),
    };
    let guides = given.directions.guides.moved(|p| model.place(p));
    options.directions.guides = guides.with_creases(&model.surface);
    options.dual.quadric = classical::quadric(&given.dual, &model.affinity)?;
    options.steering = (given.steering).moved(|p| model.affinity.normalise(p));
    // The optimiser keeps to the limit by which the mesh is judged.
    let deviation = given.limits().deviation_rel;
    options.optimise.max_deviation = deviation.map(without_unit);
    options.optimise.panels = (given.optimise.panels)
        .scaled(1.0 / model.affinity.scale)
        .with_sizes(without_unit, without_unit);
    options.repeat_rel = given.repeat_rel.map(without_unit);
    if let Some(values) = &given.size_field {
        check_size_field(values, model.surface.positions().len())?;
        options.size_field = Some(relative_sizes(values));
    }
    Ok(options)
}

/// Whether heights of a shallow surface may be raised: not where rows follow planes or a Gauss
/// image, and not where lengths and angles in space are asked for that are others there.
pub(super) fn may_raise(options: &MeshOptions) -> bool {
    let panels = &options.optimise.panels;
    let has_angles = panels.min_dihedral.is_some() || panels.max_dihedral.is_some();
    let has_lengths = options.repeat_rel.is_some() || !options.steering.grounds.is_empty();
    options.method == Method::Lattice && !has_angles && !has_lengths
}

/// Refuses sizes that are none, or not one for each vertex of the input.
fn check_size_field(values: &[f64], vertices: usize) -> Result<(), PipelineError> {
    if values.len() != vertices {
        let count = values.len();
        return Err(PipelineError::Size(format!(
            "the size field has {count} values, the surface {vertices} vertices"
        )));
    }
    let wrong = |v: &f64| !(*v > 0.0 && v.is_finite());
    match values.iter().position(wrong) {
        Some(i) => Err(PipelineError::Size(format!(
            "the size at vertex {i} is {}, it must be positive and finite",
            values[i]
        ))),
        None => Ok(()),
    }
}

/// Sizes over the largest one, without the last bits that come from a unit.
fn relative_sizes(values: &[f64]) -> Vec<f64> {
    let largest = values.iter().copied().fold(0.0, f64::max);
    values.iter().map(|v| without_unit(v / largest)).collect()
}

impl PipelineError {
    /// The same error with its places in model coordinates.
    pub(super) fn in_model(self, model: &Normalised) -> Self {
        let restore = |p: Vec3| model.affinity.restore(p);
        match self {
            Self::Layout(LayoutError::Domain(e)) => {
                LayoutError::from(e.mapped(|p| classical::place_in(model, p))).into()
            }
            Self::Layout(e) => e.mapped(restore).into(),
            other => other,
        }
    }
}
