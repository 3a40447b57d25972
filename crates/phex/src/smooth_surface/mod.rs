//! Smooth surface: what everything else looks at.
//!
//! The input's facets are a sample of a smooth surface. It is normalised ([`Normalised`]:
//! bounding-box diagonal 1, box centre at the origin, coordinates on a grid, so that no later
//! figure depends on the unit), and refined by Loop subdivision whose control points are corrected
//! until the refined surface passes through the input's vertices:
//! `C <- C + damping * (V - (M C)|input)`, with `M` the subdivision matrix.
//!
//! | symbol | variable |
//! |---|---|
//! | `V` | positions of the input's vertices |
//! | `C` | control points |
//! | `M` | [`subdivide::Refinement`], level by level |
//!
//! Guaranteed: the refined surface has the topology of the input, vertex `i` of the input is vertex
//! `i` of every level, sharp boundary corners stay where they are. Fails: never; where the
//! corrections do not converge (very irregular triangles) the control points that came closest to
//! the input are used.

mod affinity;
mod coarsen;
mod creases;
mod elongated;
pub(crate) mod extend;
mod local;
mod normalise;
mod opened;
mod slivers;
pub(crate) mod subdivide;
pub(crate) mod teeth;

pub use affinity::Affinity;
pub use coarsen::{Coarsened, coarsened};
pub(crate) use elongated::{CutShort, cut_short};
pub use extend::{Extension, extend};
pub use normalise::Normalised;
pub(crate) use slivers::IN_PLANE;
pub use subdivide::Refinement;

use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};
use serde::{Deserialize, Serialize};

/// Which surface the panels are kept close to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TargetKind {
    /// The smooth surface through the input's vertices; on a coarse input it bulges over every
    /// facet.
    #[default]
    Smooth,
    /// Between the smooth surface and the facets: half the correction towards the input's vertices.
    HalfWay,
    /// The input's facets themselves.
    Facets,
}

/// How the smooth target is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TargetOptions {
    /// Which surface the panels are kept close to.
    pub kind: TargetKind,
    /// Corrections of the control points towards interpolation (0: plain Loop, which smooths noise;
    /// 6 interpolates to about 1e-4).
    pub corrections: usize,
    /// Share of the error that a correction removes (0 to 1).
    pub damping: f64,
    /// Turning angle in degrees above which a boundary vertex is a corner and is kept sharp.
    pub corner_angle: f64,
}

impl Default for TargetOptions {
    fn default() -> Self {
        Self {
            kind: TargetKind::Smooth,
            corrections: 6,
            damping: 0.9,
            corner_angle: 40.0,
        }
    }
}

/// The smooth target at every level of refinement, in normalised coordinates.
#[derive(Clone)]
pub struct SmoothTarget {
    /// Surfaces from the input's connectivity (level 0) to the finest.
    pub levels: Vec<TriangleSurface>,
    /// Refinement from each level to the next.
    pub refinements: Vec<Refinement>,
    /// Sharp corners of the boundary (vertices of the input, the same number at every level),
    /// sharpest first.
    pub corners: Vec<VertexId>,
    /// Largest distance of an input vertex to the refined surface's vertex of the same number,
    /// diagonals.
    pub interpolation_error: f64,
}

impl SmoothTarget {
    /// A surface that is smooth already, as the only level.
    pub(super) fn of(surface: TriangleSurface) -> Self {
        Self {
            levels: vec![surface],
            refinements: Vec::new(),
            corners: Vec::new(),
            interpolation_error: 0.0,
        }
    }

    /// The finest surface.
    pub fn finest(&self) -> &TriangleSurface {
        self.levels
            .last()
            .expect("there is a level for the input itself")
    }

    /// The coarsest level with at least `vertices` vertices, or the finest.
    pub fn level_with(&self, vertices: f64) -> usize {
        let enough = |l: &TriangleSurface| l.positions().len() as f64 >= vertices;
        let last = self.levels.len() - 1;
        self.levels.iter().position(enough).unwrap_or(last)
    }
}

/// Refines a normalised surface until it has at least `min_vertices` vertices.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let options = TriangulationOptions { triangles: 320, ..Default::default() };
/// # let sphere = triangulate(&Shape::from_name("sphere", &[])?, &options)?;
/// use phex::smooth_surface::{Normalised, TargetOptions, smooth_target};
///
/// let model = Normalised::of(&sphere);
/// let target = smooth_target(&model.surface, 1000, &TargetOptions::default());
/// // New vertices lie on the sphere of radius 1, too.
/// let radius = |p| model.affinity.restore(p).norm();
/// assert!(target.finest().positions().iter().all(|p| (radius(*p) - 1.0).abs() < 0.01));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn smooth_target(
    surface: &TriangleSurface,
    min_vertices: usize,
    options: &TargetOptions,
) -> SmoothTarget {
    let corners = boundary_corners(surface, options.corner_angle.to_radians());
    let mut refinements = Vec::new();
    let mut topology = surface.topology().clone();
    while topology.n_vertices() < min_vertices {
        let (refinement, finer) = Refinement::of(&topology, &corners);
        refinements.push(refinement);
        topology = finer;
    }
    let (control, interpolation_error) =
        interpolating_control(surface.positions(), &refinements, options);
    let mut positions = control;
    let mut levels = Vec::new();
    let mut faces: Vec<[u32; 3]> = surface.triangles().collect();
    for (i, refinement) in refinements.iter().enumerate() {
        let finest: PerVertex<Vec3> = refinements[i..]
            .iter()
            .fold(positions.clone(), |p, r| r.apply(&p));
        // A coarse level holds the points of the final surface, not its control points.
        let on_surface = finest.as_slice()[..positions.len()].to_vec();
        levels.push(rebuilt(on_surface, &faces));
        positions = refinement.apply(&positions);
        faces = refinement.faces.clone();
    }
    if refinements.is_empty() {
        levels.push(surface.clone());
    } else {
        levels.push(rebuilt(positions.into_vec(), &faces));
    }
    SmoothTarget {
        levels,
        refinements,
        corners,
        interpolation_error,
    }
}

/// Distance between neighbours among so many vertices on a surface, in equilateral triangles.
fn spacing(surface: &TriangleSurface, vertices: usize) -> f64 {
    (surface.area() * 2.0 / (3.0_f64.sqrt() * vertices.max(1) as f64)).sqrt()
}

fn rebuilt(positions: Vec<Vec3>, faces: &[[u32; 3]]) -> TriangleSurface {
    TriangleSurface::new(positions, faces).expect("refinement keeps a manifold a manifold")
}

fn interpolating_control(
    input: &PerVertex<Vec3>,
    refinements: &[Refinement],
    options: &TargetOptions,
) -> (PerVertex<Vec3>, f64) {
    let error_of = |control: &PerVertex<Vec3>| -> Vec<Vec3> {
        let refined = refinements.iter().fold(control.clone(), |p, r| r.apply(&p));
        input
            .iter()
            .zip(refined.iter())
            .map(|(v, x)| v - x)
            .collect()
    };
    let largest = |errors: &[Vec3]| errors.iter().map(|e| e.norm()).fold(0.0, f64::max);
    let mut control = input.clone();
    let mut errors = error_of(&control);
    let mut best = (control.clone(), largest(&errors));
    if refinements.is_empty() {
        return best;
    }
    let (corrections, damping) = match options.kind {
        TargetKind::HalfWay => (1, 0.5),
        _ => (options.corrections, options.damping),
    };
    for _ in 0..corrections {
        for (c, e) in control.iter_mut().zip(&errors) {
            *c += damping * e;
        }
        errors = error_of(&control);
        let worst = largest(&errors);
        if worst < best.1 {
            best = (control.clone(), worst);
        }
    }
    best
}

/// Boundary vertices where the boundary turns by more than `angle` (radians), sharpest first; where
/// it turns to and fro from one vertex to the next they are none.
pub fn boundary_corners(surface: &TriangleSurface, angle: f64) -> Vec<VertexId> {
    let mut corners = Vec::new();
    for boundary in surface.topology().boundary_loops() {
        let n = boundary.len();
        let at = |i: usize| surface.positions()[boundary[i % n]];
        let is_tooth = teeth::line_through_teeth(surface, &boundary).1;
        for (i, &corner) in boundary.iter().enumerate() {
            let turning = (at(i + n) - at(i + n - 1)).angle(&(at(i + 1) - at(i)));
            if turning > angle && !is_tooth[i] {
                corners.push((turning, corner));
            }
        }
    }
    corners.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    corners.into_iter().map(|(_, v)| v).collect()
}
