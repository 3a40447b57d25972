//! Options of the whole flow.

use super::portfolio::Candidate;
use super::{PipelineError, classical};
use crate::curvature::CurvatureOptions;
use crate::directions::DirectionOptions;
use crate::directions::size::SizeOptions;
use crate::layout::LayoutOptions;
use crate::layout::brick_wall::BrickWallOptions;
use crate::layout::duality::DualOptions;
use crate::optimise::{OptimiseOptions, Steering};
use crate::quality::{Limits, USUAL_DEVIATION};
use crate::smooth_surface::{Normalised, TargetOptions};
use crate::trim::Boundary;
use serde::{Deserialize, Serialize};

/// How large panels are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PanelSize {
    /// Number of panels, at least 1.
    Panels(usize),
    /// Mean edge length, model units; met by another run or two where the first is off.
    EdgeLength(f64),
}

/// How panels are laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A hexagonal lattice in the metric of the second fundamental form, on any surface; another one where that is outside limits.
    #[default]
    Lattice,
    /// All of the portfolio, side by side; the best is kept.
    Best,
    /// A brick wall on a conjugate curve network, where the surface has one.
    BrickWall,
    /// A Goldberg polyhedron on the ellipsoid that the surface is.
    PowerDiagram,
    /// A regular triangulation of the dual surface, mapped back.
    ProjectiveDual,
    /// A coarse mesh of tangent planes, refined through its dual.
    DualSubdivision,
    /// A regular triangulation of the Gauss sphere, and tangent planes with its normals.
    SupportFunction,
    /// Tangent planes of the lattice's panels, intersected.
    TangentPlanes,
    /// A mesh parallel to one that tangent planes give, fitted to the surface.
    Parallel,
}

/// Options of [`mesh_surface`]: one struct per stage, and what concerns the whole flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshOptions {
    /// Size of the panels.
    pub size: PanelSize,
    /// Where panels are smaller.
    pub sizes: SizeOptions,
    /// Relative size of panels at each vertex of the input (positive; only ratios matter).
    pub size_field: Option<Vec<f64>>,
    /// What happens at the boundary.
    pub boundary: Boundary,
    /// Smooth target.
    pub target: TargetOptions,
    /// Curvature.
    pub curvature: CurvatureOptions,
    /// Metric and direction field.
    pub directions: DirectionOptions,
    /// How panels are laid out.
    pub method: Method,
    /// What [`Method::Best`] tries beside the lattice of these options.
    pub portfolio: Vec<Candidate>,
    /// Layout by a lattice.
    pub layout: LayoutOptions,
    /// Layout as a brick wall.
    pub brick_wall: BrickWallOptions,
    /// The methods that work by planes and their poles.
    pub dual: DualOptions,
    /// Optimiser.
    pub optimise: OptimiseOptions,
    /// Vertices that are held in the end; numbers of vertices make sense for a warm start only.
    pub steering: Steering,
    /// Vertices per panel, at least, of the mesh on which directions and lattice are computed.
    pub field_density: f64,
    /// Vertices per panel, at least, of the mesh on which cells are drawn and to which panels are kept close.
    pub cell_density: f64,
    /// Whether places where something is wrong are searched for local changes.
    pub search: bool,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            size: PanelSize::Panels(500),
            sizes: SizeOptions::default(),
            size_field: None,
            boundary: Boundary::default(),
            target: TargetOptions::default(),
            curvature: CurvatureOptions::default(),
            directions: DirectionOptions::default(),
            method: Method::default(),
            portfolio: Candidate::others(),
            layout: LayoutOptions::default(),
            brick_wall: BrickWallOptions::default(),
            dual: DualOptions::default(),
            optimise: OptimiseOptions::default(),
            steering: Steering::default(),
            field_density: 8.0,
            cell_density: 25.0,
            search: true,
        }
    }
}

impl MeshOptions {
    /// What a mesh must keep to.
    pub fn limits(&self) -> Limits {
        let deviation = self.optimise.max_deviation.unwrap_or(USUAL_DEVIATION);
        let mut limits = Limits::new(Some(deviation), Some(self.boundary));
        let typed = self.optimise.planarity_tolerance;
        limits.validity.planarity =
            (typed > OptimiseOptions::default().planarity_tolerance).then_some(typed);
        limits
    }

    /// The options for the normalised surface.
    pub(super) fn normalised(&self, model: &Normalised) -> Result<Self, PipelineError> {
        let mut options = self.clone();
        let guides = self.directions.guides.moved(|p| model.place(p));
        options.directions.guides = guides.with_creases(&model.surface);
        options.dual.quadric = classical::quadric(&self.dual, &model.similarity)?;
        options.optimise.max_deviation = self.optimise.max_deviation.map(without_unit);
        if let Some(values) = &self.size_field {
            check_size_field(values, model.surface.positions().len())?;
            options.size_field = Some(relative_sizes(values));
        }
        Ok(options)
    }
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

/// A positive ratio in single precision: in another unit it is the same.
fn without_unit(ratio: f64) -> f64 {
    match ratio > f64::from(f32::MIN_POSITIVE) {
        true => f64::from(ratio as f32),
        false => ratio,
    }
}
