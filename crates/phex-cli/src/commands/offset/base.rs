//! The mesh that layers are offsets of, and the layers.

use super::Job;
use super::told::rounded_down;
use crate::exit::{Exit, Failure, OrExit};
use crate::input::{MeshFile, whole};
use crate::offset_arguments::Kind;
use crate::progress::{Reporter, is_interrupted};
use phex::optimise::{
    AngleOptimised, AngleOptions, SurfaceTarget, Target, satisfy_angle_condition,
};
use phex::parallel_mesh::{
    EdgeGaussImage, GaussImage, Inheritance, OffsetError, SafeDistances, SphericalMesh,
    distance_error, edge_gauss_image, face_distance_error, face_offset, layer, safe_distances,
    vertex_gauss_image,
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
    if result.is_converged() && result.offenders.is_empty() {
        return Ok(result);
    }
    let message = format!(
        "no vertex offset was reached: the angle condition is off by {:.1e} radians, reflections by {:.1e}; other panel sizes may reach it where the \
         curvature changes its sign, and `phex mesh --method brick-wall --boundary whole` lays panels that are easier",
        result.angle_defect[1], result.closing_defect[1]
    );
    Err(Failure::new(Exit::NoValidResult, message))
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
