//! The whole flow as a user calls it: a builder of its options, and what it made.

use crate::directions::{Cone, Guides};
use crate::offset::{OffsetError, OffsetOptions, face_gauss_image, layer};
use crate::optimise::{Steering, led_elsewhere};
use crate::pipeline::{
    Beyond, MeshOptions, MeshRun, Method, PanelSize, PipelineError, StageSeconds, mesh_surface,
};
use crate::progress::{Progress, Silent};
use crate::quality::{Assessment, Limits, References, USUAL_DEVIATION};
use crate::report::{RunReport, StageTime};
use crate::trim::Boundary;
use phex_mesh::io::WriteError;
use phex_mesh::{HexMesh, Invalid, TriangleSurface, ValidHexMesh, validate};
use serde_json::json;
use std::path::Path;

/// Makes planar hexagonal meshes of surfaces; what is not set is as in the program `phex mesh`.
///
/// ```
/// use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
///
/// let sphere = triangulate(&Shape::from_name("sphere", &[])?, &TriangulationOptions::default())?;
/// let made = phex::Mesher::new().panels(32).seed(7).run(&sphere)?;
/// assert!(made.is_valid());
/// // A valid mesh has offsets: every face moves by the same distance.
/// let shell = made.offset(0.05)?;
/// assert_eq!(shell.topology().n_faces(), made.mesh().topology().n_faces());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Mesher<'a> {
    options: MeshOptions,
    progress: &'a dyn Progress,
}

impl Default for Mesher<'_> {
    fn default() -> Self {
        let mut options = MeshOptions::default();
        options.optimise.max_deviation = Some(USUAL_DEVIATION);
        Self {
            options,
            progress: &Silent,
        }
    }
}

impl<'a> Mesher<'a> {
    /// About 500 panels, at most 0.5 % of the diagonal away from the surface.
    pub fn new() -> Self {
        Self::default()
    }

    /// All options of all stages at once; what was set before is forgotten.
    pub fn options(self, options: MeshOptions) -> Self {
        Self { options, ..self }
    }

    /// What is told of the run while it lasts, and what may cancel it.
    pub fn progress<'b>(self, progress: &'b dyn Progress) -> Mesher<'b> {
        let options = self.options;
        Mesher { options, progress }
    }

    fn with(mut self, set: impl FnOnce(&mut MeshOptions)) -> Self {
        set(&mut self.options);
        self
    }

    /// About how many panels.
    pub fn panels(self, count: usize) -> Self {
        self.with(|o| o.size = PanelSize::Panels(count))
    }

    /// About how long the edges of panels are, model units.
    pub fn edge_length(self, length: f64) -> Self {
        self.with(|o| o.size = PanelSize::EdgeLength(length))
    }

    /// What happens at the boundary.
    pub fn boundary(self, how: Boundary) -> Self {
        self.with(|o| o.boundary = how)
    }

    /// How panels are laid out.
    pub fn method(self, method: Method) -> Self {
        self.with(|o| o.method = method)
    }

    /// By which angle, radians, rows are turned from where curvature leads them.
    pub fn rotation(self, angle: f64) -> Self {
        self.with(|o| o.directions.rotate = angle)
    }

    /// Largest ratio of panel lengths along the principal directions; 1 for regular panels.
    pub fn anisotropy(self, ratio: f64) -> Self {
        self.with(|o| o.directions.anisotropy = ratio)
    }

    /// Smaller panels where the surface bends: their length times curvature stays below
    /// `resolution` (0.4 resolves features well).
    pub fn adaptive(self, resolution: f64) -> Self {
        self.with(|o| o.sizes.adaptive = Some(resolution))
    }

    /// Relative size of panels at each vertex of the surface.
    pub fn size_field(self, sizes: Vec<f64>) -> Self {
        self.with(|o| o.size_field = Some(sizes))
    }

    /// Largest distance to the surface, over the diagonal of its bounding box.
    pub fn max_deviation(self, share: f64) -> Self {
        self.with(|o| o.optimise.max_deviation = Some(share))
    }

    /// Curves, creases and cones that rows are to follow.
    pub fn guides(self, guides: Guides) -> Self {
        self.with(|o| o.directions.guides = guides)
    }

    /// Points, curves and planes that vertices are held on.
    pub fn steering(self, steering: Steering) -> Self {
        self.with(|o| o.steering = steering)
    }

    /// Seed of every random choice.
    pub fn seed(self, seed: u64) -> Self {
        self.with(|o| o.layout.seed = seed)
    }

    /// Covers a connected surface with panels.
    ///
    /// # Errors
    /// If the surface or an option can't be used, or no panelling is found. A mesh that did not
    /// become valid is no error; see [`Panelling::valid`].
    pub fn run(&self, surface: &TriangleSurface) -> Result<Panelling, PipelineError> {
        self.run_with(surface, self.progress)
    }

    /// As [`run`](Self::run), watched by `progress`.
    ///
    /// # Errors
    /// As [`run`](Self::run), or if it is cancelled before there is a mesh.
    pub fn run_with(
        &self,
        surface: &TriangleSurface,
        progress: &dyn Progress,
    ) -> Result<Panelling, PipelineError> {
        Ok(Panelling {
            run: mesh_surface(surface, &self.options, progress)?,
            facets: surface.clone(),
            options: self.options.clone(),
        })
    }
}

/// What a [`Mesher`] made of a surface.
#[derive(Clone)]
pub struct Panelling {
    /// Everything that the stages gave.
    pub run: MeshRun,
    facets: TriangleSurface,
    options: MeshOptions,
}

impl Panelling {
    /// The mesh, valid or not.
    pub fn mesh(&self) -> &HexMesh {
        &self.run.mesh
    }

    /// The cones of the direction field, model units.
    pub fn cones(&self) -> &[Cone] {
        &self.run.statistics.cones
    }

    fn limits(&self) -> Limits {
        self.options.limits()
    }

    /// Whether every panel is planar and simple, and no two of them meet where they should not.
    pub fn is_valid(&self) -> bool {
        self.valid().is_ok()
    }

    /// The mesh as one that is known to be valid.
    ///
    /// # Errors
    /// If it is not, with everything that is wrong, by the panels' numbers.
    pub fn valid(&self) -> Result<ValidHexMesh, Invalid> {
        let target = Some(&self.run.target);
        validate(self.run.mesh.clone(), target, &self.limits().validity)
    }

    /// Figures and checks of the mesh.
    pub fn assessment(&self) -> Assessment {
        let elsewhere = led_elsewhere(&self.options.steering, &self.run.mesh);
        let references = References {
            smooth: Some(&self.run.target),
            facets: Some(&self.facets),
            beyond: self.run.beyond.as_ref().map(Beyond::surfaces),
            elsewhere: &elsewhere,
            asked: Some(self.run.statistics.panels_asked),
        };
        let mut found = Assessment::new(&self.run.mesh, references, &self.limits());
        found.measures = (found.measures).over_wished(&self.run.mesh, &self.run.wished);
        found
    }

    /// Figures, checks, options and times, for people and as JSON.
    pub fn report(&self) -> RunReport {
        let run = &self.run;
        RunReport {
            settings: json!(self.options),
            seed: self.options.layout.seed,
            stages: run.stages.iter().map(StageTime::from).collect(),
            statistics: json!(run.statistics),
            outcome: json!(run.outcome),
            ..RunReport::new("mesh", self.assessment())
        }
    }

    /// The mesh whose faces lie at a distance from these, model units, on the side of the normals.
    ///
    /// # Errors
    /// If the mesh is not valid, or its offset at that distance is not.
    pub fn offset(&self, distance: f64) -> Result<HexMesh, OffsetError> {
        let options = OffsetOptions {
            validity: self.limits().validity,
            ..OffsetOptions::default()
        };
        let image = face_gauss_image(&self.run.mesh, &options)?;
        layer(&self.run.mesh, &image, distance, &options)
    }

    /// Writes the mesh; the extension decides the format (OBJ, PLY, OFF, STL).
    ///
    /// # Errors
    /// If the extension is unknown or the file can't be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), WriteError> {
        self.run.mesh.write(path.as_ref())
    }
}

impl From<&StageSeconds> for StageTime {
    fn from(stage: &StageSeconds) -> Self {
        Self {
            stage: stage.stage.to_owned(),
            seconds: stage.seconds,
        }
    }
}
