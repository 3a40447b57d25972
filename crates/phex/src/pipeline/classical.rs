//! The flow for the methods that work by planes and their poles: a lattice that is regular in the method's own metric, its tangent
//! planes, and the points where they meet. Nothing is optimised or repaired: the comparison is with the methods as they are.

mod parallel;
mod power_diagram;
mod subdivision;

use super::brick_wall::kinked;
use super::field::{
    Field, FineSurface, allow_sizes, boundary_length, counted_lattice, direction_options,
    panel_length, with_seeds,
};
use super::{
    Clock, MeshOptions, MeshRun, Method, PipelineError, Statistics, between_panels, moved,
};
use crate::curvature::{self, Curvature};
use crate::directions::intrinsic::IntrinsicMesh;
use crate::directions::{self, saddle};
use crate::ground::Ground;
use crate::layout::domain::{CurvatureSign, DomainError, Place, SignedPlaces, resolved};
use crate::layout::duality::{
    DualOptions, DualityError, Flipped, Plane, Quadric, convex_panels, envelope, saddle_flips,
    uncrossing_flips, without_broken_rim,
};
use crate::layout::forecast::forecast;
use crate::layout::lattice::CELL;
use crate::layout::projective_dual::{self, DualDefects, SurfaceDual};
use crate::layout::tangent_planes::{regularised, tangent_planes as tangent_planes_of};
use crate::layout::{self, Layout, LayoutError, LayoutStatistics, support_function};
use crate::optimise::{self, Optimised, SurfaceTarget};
use crate::progress::Progress;
use crate::target::{Similarity, SmoothTarget};
use nalgebra::Matrix3;
use phex_mesh::{HexMesh, PerFace, PerVertex, TriangleSurface, Vec3};
use phex_numeric::{Outcome, Status};
use serde::Serialize;

/// What a method by planes and poles met with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClassicalStatistics {
    /// The method.
    pub method: Method,
    /// Signs of the Gauss curvature on the surface.
    pub curvature: CurvatureSign,
    /// The assumption of the method that does not hold, if the run went on regardless.
    pub outside_domain: Option<String>,
    /// The same as it was found, in normalised coordinates.
    #[serde(skip)]
    outside: Option<DomainError>,
    /// Centre of the polarity, model coordinates.
    pub centre: Option<[f64; 3]>,
    /// Least distance of the centre to a tangent plane over the largest.
    pub clearness: Option<f64>,
    /// Singular points and duplicates of the dual surface.
    pub defects: Option<DualDefects>,
    /// Flips that joined the panels as their planes want it: as the convex hull where `K > 0`, by the sign rule where `K < 0`.
    pub flips: Option<usize>,
    /// Panels that were taken out on the way, because their planes cut nothing off.
    pub taken_out: usize,
    /// Class `(m, n)` of the Goldberg polyhedron.
    pub goldberg: Option<(u32, u32)>,
    /// Edges of a parallel mesh that are as short as is allowed.
    pub edges_at_bound: Option<usize>,
    /// Panels that the sign rule says will cross themselves; nothing where there is no layout to ask.
    pub forecast: Option<usize>,
    /// Panels of which it says they will not, but where terms of third order may decide otherwise.
    pub in_doubt: Option<usize>,
}

impl ClassicalStatistics {
    /// Adds what flips did to a mesh with so many panels.
    fn count(&mut self, flipped: &Flipped, panels: usize) {
        let taken_out = panels - flipped.faces.len();
        self.flips = Some(self.flips.unwrap_or(0) + flipped.steps - taken_out);
        self.taken_out += taken_out;
    }

    /// The mesh without panels at the boundary for which there is no room; outside a method's domain it stays as it is.
    fn with_sound_rim(&mut self, mesh: HexMesh, planes: &PerFace<Plane>) -> HexMesh {
        if self.curvature == CurvatureSign::Mixed {
            return mesh;
        }
        let (left, kept) = without_broken_rim(&mesh, planes);
        self.taken_out += planes.len() - kept.len();
        left
    }

    fn foresee(&mut self, layout: &Layout) {
        let told = forecast(layout);
        self.forecast = Some(told.crossing.len());
        self.in_doubt = Some(told.in_doubt.len());
    }
}

/// Panels by one of the methods.
pub(super) fn mesh_with_panels(
    input: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    let mut clock = Clock::new(progress);
    let similarity = Similarity::normalising(input);
    let normalised = moved(input, |p| similarity.normalise(p));
    let mut options = options.normalised(&normalised, &similarity);
    options.dual.quadric = quadric(&options.dual, &similarity)?;
    let options = &options;
    let ground = clock.stage("target", || match options.method {
        Method::DualSubdivision => subdivision::ground(&normalised, panels, options),
        _ => Ground::new(&normalised, panels, options),
    })?;
    let model = Model {
        normalised: &normalised,
        similarity,
    };
    let made = make(&ground, &mut clock).map_err(|e| model.error(e))?;
    let reported = &made.reported;
    let mesh = match &made.fine {
        Some(fine) => {
            clock
                .timed("trim", || ground.trimmed(&made.mesh, &fine.surface))?
                .mesh
        }
        None => made.mesh,
    };
    let violations = clock.timed("validate", || between_panels(&mesh, reported));
    let beyond = (made.fine.as_ref()).and_then(|fine| ground.beyond(&fine.surface));
    let mut classical = made.classical;
    let map = |p: Vec3| similarity.restore(p);
    let outside = classical.outside.take();
    classical.outside_domain = outside.map(|e| e.mapped(|p| model.place(p)).to_string());
    classical.centre = classical
        .centre
        .map(|c| similarity.restore(c.into()).into());
    let statistics = Statistics {
        cones: Vec::new(),
        panels_asked: panels,
        target_vertices: ground
            .smooth
            .levels
            .iter()
            .map(|l| l.positions().len())
            .collect(),
        interpolation_error: ground.smooth.interpolation_error,
        layout: made.layout,
        brick_wall: None,
        classical: Some(classical),
        runs: made
            .optimised
            .as_ref()
            .map_or_else(Vec::new, |o| o.runs.clone()),
        factorisations: made
            .optimised
            .iter()
            .flat_map(|o| &o.runs)
            .map(|r| r.factorisations)
            .sum(),
        repairs: Vec::new(),
        tried: Vec::new(),
    };
    let positions = mesh.positions.map(|p| similarity.restore(*p));
    let optimised = made.optimised;
    Ok(MeshRun {
        start: None,
        mesh: mesh.with_positions(positions),
        target: moved(reported, map),
        beyond: beyond.map(|b| b.moved(map)),
        outcome: made.outcome,
        offenders: optimised.map_or_else(Vec::new, |o| o.offenders),
        violations,
        statistics,
        stages: clock.stages,
    })
}

/// What a method made, in normalised coordinates.
struct Made {
    mesh: HexMesh,
    /// The surface that the panels are compared with.
    reported: TriangleSurface,
    /// The surface on which cells were drawn, where there are cells.
    fine: Option<FineSurface>,
    outcome: Outcome,
    layout: LayoutStatistics,
    optimised: Option<Optimised>,
    classical: ClassicalStatistics,
}

impl Made {
    fn of(
        ground: &Ground,
        mesh: HexMesh,
        fine: FineSurface,
        layout: LayoutStatistics,
        optimised: Option<Optimised>,
        classical: ClassicalStatistics,
    ) -> Self {
        let planar = || Outcome::empty(Status::Converged);
        Self {
            mesh,
            reported: ground.reported(&fine.surface).clone(),
            fine: Some(fine),
            outcome: optimised
                .as_ref()
                .map_or_else(planar, |o| o.outcome.clone()),
            layout,
            optimised,
            classical,
        }
    }
}

fn make(ground: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    match ground.options.method {
        Method::ProjectiveDual => projective_dual(ground, clock),
        Method::SupportFunction => support_function(ground, clock),
        Method::PowerDiagram => power_diagram::make(ground, clock),
        Method::DualSubdivision => subdivision::make(ground, clock),
        Method::Parallel => parallel::make(ground, clock),
        _ => tangent_planes(ground, clock),
    }
}

/// The surface of the field's level with its curvature.
struct Start<'a> {
    level: usize,
    surface: &'a TriangleSurface,
    curvature: Curvature,
}

impl<'a> Start<'a> {
    fn new(ground: &'a Ground, clock: &mut Clock<'_>) -> Result<Self, PipelineError> {
        Self::on(&ground.smooth, ground, clock)
    }

    /// On another surface than that of the ground.
    fn on(
        smooth: &'a SmoothTarget,
        ground: &Ground,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let level = ground.field_level(&ground.options);
        let surface = &smooth.levels[level];
        let length = panel_length(surface, ground.panels);
        let curvature = clock.stage("curvature", || {
            curvature::curvature(surface, length, &ground.options.curvature)
        })?;
        Ok(Self {
            level,
            surface,
            curvature,
        })
    }

    /// The lattice that is laid out for any method, and where it starts.
    fn with_lattice(
        ground: &'a Ground,
        clock: &mut Clock<'_>,
    ) -> Result<(Self, Field), PipelineError> {
        let start = Self::new(ground, clock)?;
        let options = start.saddle_options(&ground.options);
        let settings = direction_options(&options, options.directions.anisotropy);
        let level = ground.field_level(&options);
        let field = Field::new(ground, level, &options, &settings, clock)?;
        Ok((start, field))
    }

    fn sign(&self) -> CurvatureSign {
        SignedPlaces::find(self.surface, &self.curvature).sign()
    }

    /// Options for a lattice that keeps the sign rule with a margin where `K < 0`: its edges stay off the asymptotic directions, to which rows along the boundary may
    /// come too near, and it has no dislocations.
    fn saddle_options(&self, options: &MeshOptions) -> MeshOptions {
        let mut options = options.clone();
        if self.sign() == CurvatureSign::Hyperbolic {
            options.directions.saddle_alignment = SADDLE_ALIGNMENT;
            options.directions.boundary_alignment = 0.0;
            allow_sizes(&mut options);
        }
        options
    }

    /// Whether the given facets tell the sign of the curvature where it is negative.
    fn resolved(&self, ground: &Ground, method: &'static str) -> Result<(), DomainError> {
        match self.sign() {
            CurvatureSign::Hyperbolic => resolved(&ground.given().levels[0], method),
            _ => Ok(()),
        }
    }

    fn statistics(&self, method: Method) -> ClassicalStatistics {
        ClassicalStatistics {
            method,
            curvature: self.sign(),
            outside_domain: None,
            outside: None,
            centre: None,
            clearness: None,
            defects: None,
            flips: None,
            taken_out: 0,
            goldberg: None,
            edges_at_bound: None,
            forecast: None,
            in_doubt: None,
        }
    }

    /// The lattice that is regular in a metric.
    fn field(
        &self,
        ground: &Ground,
        mut metric: PerVertex<Matrix3<f64>>,
        clock: &mut Clock<'_>,
    ) -> Result<Field, PipelineError> {
        let options = &self.saddle_options(&ground.options);
        let settings = direction_options(options, 1.0);
        let (wished, weight) = saddle::wishes(
            self.surface,
            &self.curvature,
            &metric,
            options.directions.saddle_alignment,
        );
        let area: f64 = IntrinsicMesh::new(self.surface, &metric).area.iter().sum();
        scale(&mut metric, CELL * ground.panels as f64 / area);
        let (directions, placed) = counted_lattice(ground.panels, |ratio| {
            scale(&mut metric, 1.0 / ratio);
            let directions = clock.stage("directions", || {
                directions::in_metric(self.surface, metric.clone(), &wished, &weight, &settings)
            })??;
            with_seeds(self.surface.topology(), directions, &options.layout, clock)
        })?;
        Ok(Field {
            level: self.level,
            curvature: self.curvature.clone(),
            directions,
            placed,
        })
    }
}

/// Weight of the alignment where `K < 0`.
const SADDLE_ALIGNMENT: f64 = 20.0;

/// Scales all areas of a metric.
fn scale(metric: &mut PerVertex<Matrix3<f64>>, factor: f64) {
    metric.iter_mut().for_each(|m| *m *= factor);
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

fn projective_dual(ground: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    let start = Start::new(ground, clock)?;
    let (surface, curvature) = (start.surface, &start.curvature);
    let given = ground.options.dual.quadric.map(Quadric::from_upper);
    let dual = match given.transpose().map_err(LayoutError::from)? {
        Some(quadric) => SurfaceDual::about(surface, &curvature.normal, quadric),
        None => SurfaceDual::of(surface, &curvature.normal),
    };
    let chosen = ground.options.dual.quadric.is_none();
    let mut classical = start.statistics(Method::ProjectiveDual);
    let method = projective_dual::METHOD;
    let checked = start.resolved(ground, method);
    let checked =
        checked.and_then(|()| projective_dual::check(surface, curvature, &dual, chosen, method));
    classical.outside = refusal(checked, ground)?;
    classical.centre = dual.quadric.centre().map(Into::into);
    classical.clearness = Some(dual.clearness);
    classical.defects = Some(projective_dual::inspect(surface, curvature, &dual));
    let metric = dual.metric(surface, curvature);
    let field = start.field(ground, metric, clock)?;
    tangent_panels(ground, &field, classical, clock)
}

/// The quadric that is asked for, in normalised coordinates.
fn quadric(
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

/// The panels of a lattice, joined as their tangent planes want it, in these planes.
fn tangent_panels(
    ground: &Ground,
    field: &Field,
    mut classical: ClassicalStatistics,
    clock: &mut Clock<'_>,
) -> Result<Made, PipelineError> {
    let (fine, layout) = cells(ground, field, clock)?;
    let layout = joined(ground, layout, &mut classical)?;
    classical.foresee(&layout);
    let mesh = met(&layout, &mut classical)?;
    let statistics = field.placed.statistics;
    Ok(Made::of(ground, mesh, fine, statistics, None, classical))
}

/// The mesh of a layout's tangent planes.
fn met(layout: &Layout, classical: &mut ClassicalStatistics) -> Result<HexMesh, LayoutError> {
    let planes = tangent_planes_of(layout);
    let mesh = envelope(&layout.mesh, &planes)?;
    Ok(classical.with_sound_rim(mesh, &planes))
}

/// The layout with its panels joined as the poles of their planes are in their hull where `K > 0`; where `K < 0` by the sign rule, and then so that fewer
/// panels cross themselves.
fn joined(
    ground: &Ground,
    layout: Layout,
    classical: &mut ClassicalStatistics,
) -> Result<Layout, LayoutError> {
    if !ground.options.dual.hull {
        return Ok(layout);
    }
    let planes = tangent_planes_of(&layout);
    let (mesh, points) = (&layout.mesh, &layout.face_point);
    match classical.curvature {
        CurvatureSign::Elliptic => {
            let convex = convex_panels(mesh, &planes, points)?;
            classical.count(&convex, planes.len());
            Ok(layout.joined(&convex))
        }
        CurvatureSign::Hyperbolic => {
            let ruled = saddle_flips(mesh, &planes, points);
            let simple = uncrossing_flips(&envelope(&ruled.mesh, &planes)?, &planes);
            classical.count(&ruled, planes.len());
            classical.count(&simple, planes.len());
            Ok(layout.joined(&ruled).joined(&simple))
        }
        CurvatureSign::Mixed => Ok(layout),
    }
}

fn support_function(ground: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    let start = Start::new(ground, clock)?;
    let mut classical = start.statistics(Method::SupportFunction);
    let checked = start.resolved(ground, support_function::METHOD);
    let checked = checked.and_then(|()| support_function::check(start.surface, &start.curvature));
    classical.outside = refusal(checked, ground)?;
    let metric = support_function::metric(&start.curvature);
    let field = start.field(ground, metric, clock)?;
    tangent_panels(ground, &field, classical, clock)
}

fn tangent_planes(ground: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    let options = &ground.options;
    let (start, field) = Start::with_lattice(ground, clock)?;
    let mut classical = start.statistics(Method::TangentPlanes);
    let (fine, mut layout) = cells(ground, &field, clock)?;
    classical.foresee(&layout);
    let (mesh, optimised) = if options.dual.regularisation > 0.0 {
        layout.mesh = regularised(&layout, options.dual.regularisation);
        let target = SurfaceTarget::new(ground.close_to(&fine.surface));
        let progress = clock.progress;
        let optimised = clock.timed("optimise", || {
            optimise::optimise(&layout, &target, &kinked(&options.optimise), progress)
        })?;
        (optimised.mesh.clone(), Some(optimised))
    } else {
        (met(&layout, &mut classical)?, None)
    };
    let statistics = field.placed.statistics;
    Ok(Made::of(
        ground, mesh, fine, statistics, optimised, classical,
    ))
}

/// The panels of a lattice.
fn cells(
    ground: &Ground,
    field: &Field,
    clock: &mut Clock<'_>,
) -> Result<(FineSurface, Layout), PipelineError> {
    let fine = FineSurface::new(ground, field);
    let layout = clock.stage("layout", || {
        layout::panelling(&fine.cells(), &field.placed.seeds)
    })??;
    Ok((fine, layout))
}

/// What errors say of places: in the user's coordinates, and by the user's vertices.
struct Model<'a> {
    normalised: &'a TriangleSurface,
    similarity: Similarity,
}

impl Model<'_> {
    /// The vertex of the input that is nearest to a place on the refined surface.
    fn place(&self, place: Place) -> Place {
        let distance = |p: &Vec3| (p - place.position).norm_squared();
        let all = self.normalised.positions().enumerate();
        let nearest = all.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        nearest.map_or(place, |(vertex, p)| Place {
            vertex,
            position: self.similarity.restore(*p),
        })
    }

    fn error(&self, error: PipelineError) -> PipelineError {
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
