//! The flow for the methods that work by planes and their poles: a lattice that is regular in the
//! method's own metric, its tangent planes, and the points where they meet. Nothing is optimised or
//! repaired: the comparison is with the methods as they are.

mod joined;
mod koebe;
mod lattices;
mod model;
mod parallel;
mod power_diagram;
mod start;
mod subdivision;

pub(super) use model::{place_in, quadric};

use super::domain::Ground;
use super::field::{Field, FineSurface};
use super::sized::{boundary_length, panel_length};
use super::{ClassicalStatistics, Clock, MeshOptions, MeshRun, Method, PipelineError, Statistics};
use crate::classical::domain::DomainError;
use crate::directions::guides::Cone;
use crate::layout::{LayoutError, LayoutStatistics};
use crate::optimise::RunSummary;
use crate::smooth_surface::Normalised;
use joined::{cells, fitted_planes, joined, met, on_gauss_sphere};
use phex_mesh::{HexMesh, TriangleSurface};
use phex_numeric::{Outcome, Status};
use start::CurvedGround;

/// Panels by one of the methods, of a normalised surface.
pub(super) fn mesh_with_panels(
    model: &Normalised,
    panels: usize,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let ground = clock.stage("target", || match options.method {
        Method::DualSubdivision => subdivision::ground(&model.surface, panels, options),
        Method::Koebe => koebe::ground(&model.surface, panels, options),
        _ => Ground::new(&model.surface, panels, options),
    })?;
    let made = make(&ground, clock)?;
    let mut classical = made.classical;
    let mesh = match &made.fine {
        Some(fine) => {
            let trimmed = clock.timed("trim", || ground.trimmed(&made.mesh, fine))?;
            classical.follow(trimmed.parent.as_slice());
            trimmed.mesh
        }
        None => made.mesh,
    };
    classical.compare(&mesh);
    let beyond = (made.fine.as_ref()).and_then(|fine| ground.beyond(fine));
    let outside = classical.outside.take();
    classical.outside_domain = outside.map(|e| e.mapped(|p| place_in(model, p)).to_string());
    let mut statistics = Statistics {
        cones: made.cones,
        layout: made.layout,
        classical: Some(classical),
        ..Statistics::of(&ground.smooth, panels)
    };
    made.run.into_iter().for_each(|run| statistics.add(run));
    Ok(MeshRun {
        beyond,
        ..MeshRun::new(mesh, made.reported, made.outcome, statistics)
    })
}

/// What a method made, in normalised coordinates.
struct ClassicalMesh {
    mesh: HexMesh,
    /// The surface that the panels are compared with.
    reported: TriangleSurface,
    /// The surface on which cells were drawn, where there are cells.
    fine: Option<TriangleSurface>,
    outcome: Outcome,
    layout: LayoutStatistics,
    /// The cones of the lattice, where there is one.
    cones: Vec<Cone>,
    /// How the optimiser went, where there was need of one.
    run: Option<RunSummary>,
    classical: ClassicalStatistics,
}

impl ClassicalMesh {
    /// Panels that come from no lattice.
    fn new(mesh: HexMesh, reported: TriangleSurface, classical: ClassicalStatistics) -> Self {
        Self {
            mesh,
            reported,
            fine: None,
            outcome: Outcome::empty(Status::Converged),
            layout: LayoutStatistics::default(),
            cones: Vec::new(),
            run: None,
            classical,
        }
    }

    /// Panels from the cells of a lattice, which are planar as they are.
    fn of(
        ground: &Ground,
        mesh: HexMesh,
        fine: FineSurface,
        (field, layout): (&Field, LayoutStatistics),
        classical: ClassicalStatistics,
    ) -> Self {
        let reported = ground.reported(&fine.surface).clone();
        Self {
            fine: Some(fine.surface),
            layout,
            cones: field.cones(&ground.smooth),
            ..Self::new(mesh, reported, classical)
        }
    }
}

fn make(ground: &Ground, clock: &mut Clock<'_>) -> Result<ClassicalMesh, PipelineError> {
    match ground.options.method {
        Method::ProjectiveDual => lattices::projective_dual(ground, clock),
        Method::SupportFunction => lattices::support_function(ground, clock),
        Method::PowerDiagram => power_diagram::make(ground, clock),
        Method::DualSubdivision => subdivision::make(ground, clock),
        Method::Parallel => parallel::make(ground, clock),
        Method::Koebe => koebe::make(ground, clock),
        _ => lattices::tangent_planes(ground, clock),
    }
}

/// What a refusal becomes: the error, or where any domain will do a remark.
fn refusal<T>(
    checked: Result<T, DomainError>,
    ground: &Ground,
) -> Result<Option<DomainError>, LayoutError> {
    match checked {
        Ok(_) => Ok(None),
        Err(e) if ground.options.dual.any_domain => Ok(Some(e)),
        Err(e) => Err(e.into()),
    }
}
