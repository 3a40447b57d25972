//! Options of the whole flow.

use crate::classical::duality::DualOptions;
use crate::curvature::CurvatureOptions;
use crate::directions::DirectionOptions;
use crate::directions::size::SizeOptions;
use crate::layout::LayoutOptions;
use crate::layout::brick_wall::BrickWallOptions;
use crate::optimise::{OptimiseOptions, Steering};
use crate::quality::{Limits, USUAL_DEVIATION};
use crate::smooth_surface::TargetOptions;
use crate::symmetry::Symmetry;
use crate::trim::Boundary;
use serde::{Deserialize, Serialize};

/// How large panels are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PanelSize {
    /// Number of panels, at least 1.
    Panels(usize),
    /// Mean length of the edges between panels, model units; met by another run or two where the
    /// first is off.
    EdgeLength(f64),
}

/// How panels are laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A hexagonal lattice in the metric of the second fundamental form, on any surface; another
    /// one where that is outside limits.
    #[default]
    Lattice,
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
    /// A mesh parallel to a Koebe mesh, fitted to the surface: it has offsets at constant edge
    /// distance.
    Koebe,
}

impl Method {
    /// Whether panels are laid out on the surface; other methods take planes at its vertices.
    pub(super) fn lays_out(self) -> bool {
        matches!(self, Self::Lattice | Self::BrickWall)
    }
}

/// How much a run tries. Whatever it is, the mesh is judged, and what is wrong with it named.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effort {
    /// One lattice and one pass, without search: a first picture.
    Draft,
    /// The most regular of a few lattices, another one where that may be better, and a search where
    /// something is wrong.
    #[default]
    Normal,
    /// All of the portfolio, side by side; the best is kept and searched.
    Best,
}

/// Vertices under panels of many sizes, and under planes, over those under a lattice of panels that
/// are alike: with no more than there a penguin's panels lie twice as far off, and ten of 250
/// tangent planes of a torus cross themselves.
const EXACT: f64 = 2.0;

/// Options of [`mesh_surface`](super::mesh_surface): one struct per stage, and what concerns the
/// whole flow.
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
    /// What [`Effort::Best`] tries beside the lattice of these options.
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
    /// Vertices per panel, at least, of the mesh on which directions and lattice are computed;
    /// twice as many where sizes vary or planes come from its curvature.
    pub field_density: f64,
    /// Vertices per panel, at least, of the mesh on which cells are drawn and to which panels are
    /// kept close.
    pub cell_density: f64,
    /// Difference within which edges count as equal, over the diagonal of the surface, where as
    /// many as possible are to be made so in the end; `None` leaves them as they are.
    pub repeat_rel: Option<f64>,
    /// Which symmetries of the surface panels have.
    pub symmetry: Symmetry,
    /// Whether panels may differ in size wherever that saves pairs of a pentagon and a heptagon,
    /// and opposite cones cancel however far apart they are: else pairs stay where they make panels
    /// more even.
    pub regular: bool,
    /// How much is tried.
    pub effort: Effort,
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
            field_density: 4.0,
            cell_density: 25.0,
            repeat_rel: None,
            symmetry: Symmetry::default(),
            regular: false,
            effort: Effort::default(),
        }
    }
}

impl MeshOptions {
    /// Whether panels are to be smaller at some places than at others.
    pub(crate) fn varies_sizes(&self) -> bool {
        self.sizes.adaptive.is_some() || self.size_field.is_some()
    }

    /// Vertices of the level that directions and lattice are computed on.
    pub(super) fn field_vertices(&self, panels: usize) -> f64 {
        let is_usual = self.method == Method::Lattice && !self.varies_sizes();
        let share = if is_usual { 1.0 } else { EXACT };
        share * self.field_density * panels as f64
    }

    /// Vertices that cells need.
    pub(super) fn cell_vertices(&self, panels: usize) -> f64 {
        self.cell_density.max(self.field_density) * panels as f64
    }

    /// Distance to the boundary, over the diagonal, that edges along it may have: the usual one, or
    /// the limit where that is less.
    pub(super) fn boundary_limit(&self) -> f64 {
        let limit = self.limits().boundary_rel.unwrap_or(USUAL_DEVIATION);
        limit.min(USUAL_DEVIATION)
    }

    /// What a mesh must keep to.
    pub fn limits(&self) -> Limits {
        let deviation = self.optimise.max_deviation.unwrap_or(USUAL_DEVIATION);
        let mut limits = Limits::new(Some(deviation), Some(self.boundary));
        let typed = self.optimise.planarity_tolerance;
        limits.validity.planarity =
            (typed > OptimiseOptions::default().planarity_tolerance).then_some(typed);
        limits.panels = self.optimise.panels;
        limits
    }
}

/// One way of laying panels out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Candidate {
    /// [`Method::Lattice`] or [`Method::BrickWall`].
    pub method: Method,
    /// Largest ratio of a lattice's panel lengths along the principal directions.
    pub anisotropy: f64,
    /// Whether the size of a lattice's panels may change so far that it needs no dislocations.
    pub seamless: bool,
    /// Whether panels are smaller where they would else be too large for the curvature, and larger
    /// elsewhere, and pairs of pentagons and heptagons stay where they make panels more even.
    pub resolving: bool,
}

impl Default for Candidate {
    fn default() -> Self {
        Self {
            method: Method::Lattice,
            anisotropy: 2.0,
            seamless: false,
            resolving: false,
        }
    }
}

impl Candidate {
    /// What is tried beside the lattice that the options describe.
    fn others() -> Vec<Self> {
        let lattice = |seamless, anisotropy| Self {
            seamless,
            anisotropy,
            ..Self::default()
        };
        let wall = Self {
            method: Method::BrickWall,
            ..Self::default()
        };
        let lattices = [(true, 2.0), (true, 1.5), (false, 1.5), (false, 1.0)];
        let lattices = lattices.map(|(seamless, anisotropy)| lattice(seamless, anisotropy));
        lattices.into_iter().chain([wall]).collect()
    }

    /// The panels that the options describe.
    pub(super) fn first(options: &MeshOptions) -> Self {
        Self {
            method: options.method,
            anisotropy: options.directions.anisotropy,
            seamless: options.regular,
            resolving: false,
        }
    }
}
