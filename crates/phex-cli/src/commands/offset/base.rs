//! The mesh that layers are offsets of, and the layers.

use super::Job;
use super::told::rounded_down;
use crate::exit::{Exit, Failure, OrExit};
use crate::input::{MeshFile, whole};
use crate::offset_arguments::Kind;
use crate::progress::{Reporter, is_interrupted};
use phex::optimise::{
    AngleOptimised, AngleOptions, Fault, Offender, SurfaceTarget, Target, satisfy_angle_condition,
};
use phex::parallel_mesh::{
    EdgeGaussImage, GaussImage, Inheritance, OffsetError, SafeDistances, SphericalMesh,
    angle_conditions, distance_error, edge_gauss_image, face_distance_error, face_offset, layer,
    safe_distances, spherical_mesh, vertex_gauss_image,
};
use phex_mesh::{FlatFace, HexMesh, PerFace, VertexId};

/// How the vertices move, with what is known of it.
pub(super) enum Motion {
    /// With the vertex whose normal is least certain, and the estimate of its relative error.
    Face(GaussImage, (VertexId, f64)),
    Edge(EdgeGaussImage),
    Vertex(SphericalMesh),
}

impl Motion {
    fn of(mesh: &HexMesh, job: &Job<'_>) -> Result<Self, OffsetError> {
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
    pub optimised: Option<AngleOptimised>,
}

impl Base {
    pub fn new(job: &Job<'_>, given: HexMesh) -> Result<Self, Failure> {
        let optimised = job
            .command
            .optimise
            .then(|| optimise(job, &given))
            .transpose()?;
        let mesh = optimised.as_ref().map_or(given, |o| o.mesh.clone());
        Ok(Self {
            motion: Motion::of(&mesh, job).map_err(advised)?,
            inheritance: Inheritance::of(&mesh, &job.options).or_exit(Exit::InputUnusable)?,
            mesh,
            optimised,
        })
    }

    pub fn safe_distances(&self, job: &Job<'_>) -> SafeDistances {
        safe_distances(&self.mesh, self.motion.image(), &job.options)
    }

    pub fn layers(&self, job: &Job<'_>) -> Result<Vec<Layer>, Failure> {
        if let Some(distances) = &job.face_distances {
            return Ok(vec![self.own_distances(job, distances)?]);
        }
        let distances = job.distances.iter();
        distances.map(|&d| self.layer(job, d)).collect()
    }

    fn layer(&self, job: &Job<'_>, distance: f64) -> Result<Layer, Failure> {
        let image = self.motion.image();
        let moved = layer(&self.mesh, image, distance, &job.options)
            .map_err(|e| self.refusal(job, distance, &e))?;
        let error = distance_error(&self.mesh, &moved, image.kind, distance);
        Ok(Layer::new(moved, distance, error.or_exit(Exit::Internal)?))
    }

    fn own_distances(&self, job: &Job<'_>, distances: &PerFace<f64>) -> Result<Layer, Failure> {
        let offset =
            face_offset(&self.mesh, distances, &job.options).or_exit(Exit::InputUnusable)?;
        let farther = |m: f64, &d: &f64| if d.abs() > m.abs() { d } else { m };
        let largest = distances.iter().fold(0.0, farther);
        let moved = self
            .inheritance
            .checked(&self.mesh, offset.apply(&self.mesh), largest)
            .or_exit(Exit::NoValidResult)?;
        let error = face_distance_error(&self.mesh, &moved, distances);
        Ok(Layer::new(moved, largest, error.or_exit(Exit::Internal)?))
    }

    /// Why a distance does not work, and how far it might go.
    fn refusal(&self, job: &Job<'_>, distance: f64, error: &OffsetError) -> Failure {
        let safe = self.safe_distances(job);
        let most = if distance < 0.0 {
            -rounded_down(safe.inward.distance)
        } else {
            rounded_down(safe.outward.distance)
        };
        let message =
            format!("{error}; the largest safe distance on that side is {most} (model units)");
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

fn optimise(job: &Job<'_>, mesh: &HexMesh) -> Result<AngleOptimised, Failure> {
    let reporter = Reporter::new(&job.command.talk);
    let file = job
        .command
        .surface
        .as_deref()
        .map(MeshFile::read)
        .transpose()?;
    let surface = file
        .map(|file| whole(&file.surfaces()?.components))
        .transpose()?;
    let target = surface.as_ref().map(SurfaceTarget::new);
    let target = target.as_ref().map(|t| t as &dyn Target);
    let result = satisfy_angle_condition(mesh, target, &AngleOptions::default(), &reporter)
        .or_exit(Exit::InputUnusable)?;
    reporter.finish();
    if is_interrupted() {
        return Err(Failure::interrupted());
    }
    // A tight panel is valid; it is told.
    let tight = |o: &Offender| matches!(o.fault, Fault::LowClearance { .. });
    if result.is_converged() && result.offenders.iter().all(tight) {
        return Ok(result);
    }
    Err(Failure::new(Exit::NoValidResult, unreached(&result)))
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
pub(super) struct Layer {
    pub distance: f64,
    pub mesh: HexMesh,
    /// Largest error of a distance, in model units.
    pub distance_error: f64,
    /// Largest distance of a vertex to the plane of its face, in mean edges.
    pub planarity: f64,
    /// In model units.
    pub mean_edge: f64,
}

impl Layer {
    fn new(mesh: HexMesh, distance: f64, distance_error: f64) -> Self {
        let faces = FlatFace::all(&mesh);
        let bent = faces.iter().map(|f| f.planarity_length).fold(0.0, f64::max);
        let mean_edge = mesh.mean_edge();
        Self {
            distance,
            distance_error,
            planarity: bent / mean_edge,
            mean_edge,
            mesh,
        }
    }
}
