//! The mesh that layers are offsets of, and the layers.

use super::OffsetJob;
use crate::exit::{Exit, Failure, OrExit};
use crate::offset_arguments::Kind;
use crate::progress::{Reporter, check_interruption};
use phex::offset::{
    EdgeGaussImage, GaussImage, Inheritance, OffsetError, SafeDistances, SphericalMesh, TurnedEdge,
    angle_conditions, distance_error, edge_gauss_image, face_distance_error, face_offset, layer,
    rounded_down, safe_distances, spherical_mesh, vertex_gauss_image,
};
use phex::optimise::{
    AngleOptimised, AngleOptions, Fault, Offender, SurfaceTarget, Target, satisfy_angle_condition,
};
use phex_job::MeshFile;
use phex_mesh::measure::deviation;
use phex_mesh::{EdgeId, FlatFace, HexMesh, PerFace, Vec3, VertexId};
use serde::Serialize;

/// How the vertices move, with what is known of it.
pub(super) enum Motion {
    /// With the vertex whose normal is least certain, and the estimate of its relative error.
    Face(GaussImage, (VertexId, f64)),
    Edge(EdgeGaussImage),
    Vertex(SphericalMesh),
}

impl Motion {
    fn of(mesh: &HexMesh, job: &OffsetJob<'_>) -> Result<Self, OffsetError> {
        let options = &job.options;
        Ok(match job.command.kind {
            Kind::Face => {
                let ones = PerFace::filled(mesh.topology().n_faces(), 1.0);
                let offset = face_offset(mesh, &ones, options)?;
                let worst = offset.worst();
                Self::Face(offset.into_image(), worst)
            }
            Kind::Edge => Self::Edge(edge_gauss_image(mesh, options)?),
            Kind::Vertex => Self::Vertex(vertex_gauss_image(mesh, options)?),
        })
    }

    pub fn image(&self) -> &GaussImage {
        match self {
            Self::Face(image, _) => image,
            Self::Edge(found) => &found.image,
            Self::Vertex(spherical) => &spherical.image,
        }
    }
}

/// The mesh that layers are offsets of, and how its vertices move.
pub(super) struct Base {
    pub mesh: HexMesh,
    pub motion: Motion,
    /// What is wrong with the mesh already.
    pub inheritance: Inheritance,
    pub optimised: Option<MovedVertices>,
    /// Edges of the Gauss image that are not parallel to those of the mesh.
    pub turned: Vec<TurnedEdge>,
}

/// What moved the vertices first, and how far.
pub(super) struct MovedVertices {
    pub result: AngleOptimised,
    /// Largest distance of a vertex from where it was given, in model units.
    pub moved: f64,
    /// Largest distance of a vertex or panel centre to the surface, as `phex check` measures it, or
    /// without one to the tangent planes of the given mesh; in model units.
    pub deviation: f64,
    /// What that is the distance to.
    pub reference: &'static str,
    /// Largest deviation that is allowed, in model units.
    pub limit: f64,
    /// Diagonal of the reference's bounding box, in model units.
    pub diagonal: f64,
}

impl MovedVertices {
    pub fn keeps_to_surface(&self) -> bool {
        self.deviation <= self.limit
    }
}

impl Base {
    pub fn new(job: &OffsetJob<'_>, given: HexMesh) -> Result<Self, Failure> {
        let optimised = job
            .command
            .optimise
            .then(|| optimise(job, &given))
            .transpose()?;
        let mesh = optimised.as_ref().map_or(given, |o| o.result.mesh.clone());
        let motion = Motion::of(&mesh, job).map_err(advised)?;
        Ok(Self {
            turned: motion.image().turned_edges(&mesh),
            motion,
            inheritance: Inheritance::of(&mesh, &job.options).or_exit(Exit::InputUnusable)?,
            mesh,
            optimised,
        })
    }

    /// Whether the mesh is sound itself, and as close to the surface as it should be.
    pub fn is_within_limits(&self) -> bool {
        let close = self
            .optimised
            .as_ref()
            .is_none_or(MovedVertices::keeps_to_surface);
        close && self.inheritance.violations.is_empty()
    }

    pub fn safe_distances(&self, job: &OffsetJob<'_>) -> SafeDistances {
        safe_distances(&self.mesh, self.motion.image(), &job.options)
    }

    pub fn layers(&self, job: &OffsetJob<'_>) -> Result<Vec<OffsetLayer>, Failure> {
        if let Some(distances) = &job.face_distances {
            return Ok(vec![self.own_distances(job, distances)?]);
        }
        let distances = job.distances.iter();
        distances.map(|&d| self.layer(job, d)).collect()
    }

    fn layer(&self, job: &OffsetJob<'_>, distance: f64) -> Result<OffsetLayer, Failure> {
        let image = self.motion.image();
        let moved = layer(&self.mesh, image, distance, &job.options)
            .map_err(|e| self.refusal(job, distance, &e))?;
        let error = match &self.motion {
            Motion::Edge(found) => Ok(found.distance_error(&self.mesh, &moved, distance)),
            _ => distance_error(&self.mesh, &moved, image.kind, distance),
        };
        let turned = Turned::of(&image.turned_edges(&self.mesh), distance);
        Ok(OffsetLayer::new(
            moved,
            distance,
            error.or_exit(Exit::Internal)?,
            turned,
        ))
    }

    fn own_distances(
        &self,
        job: &OffsetJob<'_>,
        distances: &PerFace<f64>,
    ) -> Result<OffsetLayer, Failure> {
        let offset =
            face_offset(&self.mesh, distances, &job.options).or_exit(Exit::InputUnusable)?;
        let farther = |m: f64, &d: &f64| if d.abs() > m.abs() { d } else { m };
        let largest = distances.iter().fold(0.0, farther);
        let moved = self
            .inheritance
            .checked(&self.mesh, offset.apply(&self.mesh), largest)
            .or_exit(Exit::NoValidResult)?;
        let error = face_distance_error(&self.mesh, &moved, distances);
        // The displacements are those of this layer already.
        let turned = Turned::of(&offset.into_image().turned_edges(&self.mesh), 1.0);
        Ok(OffsetLayer::new(
            moved,
            largest,
            error.or_exit(Exit::Internal)?,
            turned,
        ))
    }

    /// Why a distance does not work, and how far it might go.
    fn refusal(&self, job: &OffsetJob<'_>, distance: f64, error: &OffsetError) -> Failure {
        let safe = self.safe_distances(job);
        let most = if distance < 0.0 {
            -rounded_down(safe.inward.distance)
        } else {
            rounded_down(safe.outward.distance)
        };
        let unit = job.command.unit;
        let message = format!("{error}; the largest safe distance on that side is {most} {unit}");
        Failure::new(Exit::NoValidResult, message)
    }
}

/// Where there is no such offset, what to do about it.
fn advised(error: OffsetError) -> Failure {
    let advice = match &error {
        OffsetError::Holonomy { .. } | OffsetError::AngleCondition { .. } => {
            "; `--optimise` moves the vertices so that they do"
        }
        OffsetError::NotParallelToKoebe { .. } => {
            "; `phex koebe` and `phex parallel` make meshes that are"
        }
        _ => "",
    };
    Failure::input(format!("{error}{advice}"))
}

fn optimise(job: &OffsetJob<'_>, mesh: &HexMesh) -> Result<MovedVertices, Failure> {
    let reporter = Reporter::new(&job.command.talk);
    let file = job
        .command
        .surface
        .as_deref()
        .map(MeshFile::read)
        .transpose()?;
    let surface = file.map(|file| file.surface()).transpose()?;
    let target = surface.as_ref().map(SurfaceTarget::new);
    let target = target.as_ref().map(|t| t as &dyn Target);
    let result = satisfy_angle_condition(mesh, target, &AngleOptions::default(), &reporter)
        .or_exit(Exit::InputUnusable)?;
    reporter.finish();
    check_interruption()?;
    // A tight panel is valid; it is told.
    let tight = |o: &Offender| matches!(o.fault, Fault::LowClearance { .. });
    if !result.is_converged() || !result.offenders.iter().all(tight) {
        return Err(Failure::new(Exit::NoValidResult, unreached(&result)));
    }
    let (deviation, reference, diagonal) = match &surface {
        Some(surface) => {
            let found = deviation(&result.mesh, surface);
            (
                found.deviation_max * found.diagonal,
                "surface",
                found.diagonal,
            )
        }
        None => (result.deviation[1], "given mesh", mesh.diagonal()),
    };
    let (limit, unit) = (job.command.max_deviation, job.command.unit);
    let step = |(p, q): (&Vec3, &Vec3)| (p - q).norm();
    let steps = mesh.positions.iter().zip(&result.mesh.positions).map(step);
    Ok(MovedVertices {
        moved: steps.fold(0.0, f64::max),
        deviation,
        reference,
        limit: limit.length(unit, diagonal),
        diagonal,
        result,
    })
}

/// Panels that a refusal names.
const NAMED: usize = 3;

fn described(offender: &Offender) -> String {
    let fault = match offender.fault {
        Fault::NotSimple => "crosses itself",
        Fault::LowClearance { .. } => "has corners that come too near to edges",
        Fault::Flipped => "faces the other way",
        Fault::WrongFan { .. } => "overlaps a neighbour",
        Fault::Folded { .. } => "is folded against a neighbour",
        Fault::NotPlanar { .. } => "is not planar",
    };
    format!("face {} {fault}", offender.face.index())
}

/// Which panels and loops keep a mesh from having a vertex offset.
fn unreached(result: &AngleOptimised) -> String {
    let advice = "other panel sizes may reach it where the curvature changes its sign";
    if result.is_converged() {
        let faults: Vec<String> = result.offenders.iter().map(described).collect();
        let named = faults[..NAMED.min(faults.len())].join(", ");
        return format!(
            "no vertex offset was reached: where the angle condition holds {} panels are not as they should be ({named}); {advice}",
            faults.len()
        );
    }
    let tolerance = AngleOptions::default().tolerance;
    let mut off = angle_conditions(&result.mesh);
    off.retain(|c| c.defect.abs() > tolerance);
    off.sort_by(|a, b| b.defect.abs().total_cmp(&a.defect.abs()));
    let worst: Vec<String> = off
        .iter()
        .take(NAMED)
        .map(|c| format!("face {} by {:.1e}", c.face.index(), c.defect.abs()))
        .collect();
    let angles = match off.len() {
        0 => "the angle condition holds".to_owned(),
        n => format!(
            "{n} panels miss the angle condition, most of all {} radians",
            worst.join(", ")
        ),
    };
    let closing = spherical_mesh(&result.mesh).map_or(String::new(), |s| {
        let h = s.holonomy;
        format!(
            "; reflections round {} odd panels inside and {} loops miss by {:.1e}, at edge {}",
            h.odd_faces,
            h.loops,
            result.closing_defect[1],
            h.edge.index()
        )
    });
    format!("no vertex offset was reached: {angles}{closing}; {advice}")
}

/// One offset, with what was measured of it.
pub(super) struct OffsetLayer {
    pub distance: f64,
    pub mesh: HexMesh,
    /// Largest error of a distance, in model units.
    pub distance_error: f64,
    /// Largest distance of a vertex to the plane of its face, in mean edges.
    pub planarity: f64,
    /// In model units.
    pub mean_edge: f64,
    /// Edges that are not parallel to those of the mesh.
    pub turned: Turned,
}

/// Edges at the boundary that are not parallel to those of the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Turned {
    /// Their number.
    pub edges: usize,
    /// The largest angle, in radians.
    pub angle: f64,
    /// The edge where that is.
    pub edge: Option<EdgeId>,
}

impl Turned {
    fn of(edges: &[TurnedEdge], distance: f64) -> Self {
        let angles = edges.iter().map(|t| (t.angle(distance), t.edge));
        let most = angles.max_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            edges: edges.len(),
            angle: most.map_or(0.0, |(angle, _)| angle),
            edge: most.map(|(_, edge)| edge),
        }
    }
}

impl OffsetLayer {
    fn new(mesh: HexMesh, distance: f64, distance_error: f64, turned: Turned) -> Self {
        let faces = FlatFace::all(&mesh);
        let bent = faces.iter().map(|f| f.planarity_length).fold(0.0, f64::max);
        let mean_edge = mesh.mean_edge();
        Self {
            distance,
            distance_error,
            planarity: bent / mean_edge,
            mean_edge,
            turned,
            mesh,
        }
    }
}
