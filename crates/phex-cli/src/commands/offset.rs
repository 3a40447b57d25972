//! `phex offset`: layers at constant distance of faces or vertices, solid panels and beams between them.
//!
//! Everything is computed and checked before anything is written, so that a distance that goes too far leaves no file.

mod between;
mod files;

use super::{tell, use_threads};
use crate::exit::{Exit, Failure, OrExit};
use crate::input::{MeshFile, whole};
use crate::offset_arguments::{Kind, OffsetCommand};
use crate::output::{check_writable, write_text};
use crate::progress::{Reporter, is_interrupted};
use files::Files;
use phex::optimise::{
    AngleOptimised, AngleOptions, SurfaceTarget, Target, satisfy_angle_condition,
};
use phex::parallel_mesh::{
    GaussImage, OffsetError, OffsetOptions, SafeDistance, SafeDistances, SphericalMesh, checked,
    face_gauss_image, face_offset, layer, safe_distances, vertex_gauss_image,
};
use phex_mesh::measure::diagonal;
use phex_mesh::{FlatFace, HexMesh, PerFace, ValidHexMesh, ValidateOptions};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If the mesh can't be used, has no such offset, or a distance goes too far; nothing is written then.
pub fn run(command: &OffsetCommand) -> Result<Exit, Failure> {
    use_threads(command.threads)?;
    let input = MeshFile::read(&command.input)?;
    let (given, _) = input.polygon_mesh()?;
    let job = Job::new(command, &given)?;
    let files = Files::plan(command, &job.distances)?;
    let outputs = files.outputs();
    let paths: Vec<_> = outputs
        .iter()
        .map(|(path, c)| (path.as_path(), *c))
        .collect();
    check_writable(&paths, &job.inputs())?;
    let base = Base::new(&job, given)?;
    let safe = command.max_distance.then(|| base.safe_distances(&job));
    let layers = base.layers(&job)?;
    if is_interrupted() {
        return Err(Failure::interrupted());
    }
    let contents = files.contents(command, &job, &base, &layers)?;
    contents.iter().try_for_each(files::Content::write)?;
    let report = report(&job, &base, safe.as_ref(), &layers, &contents);
    if let Some(path) = &command.report {
        write_text(path, &format!("{report:#}\n"))?;
    }
    let text = summary(&base, safe.as_ref(), &layers, &contents);
    tell(command.talk.quiet, &text)?;
    Ok(Exit::Success)
}

/// What was typed, in model units.
struct Job<'a> {
    command: &'a OffsetCommand,
    options: OffsetOptions,
    distances: Vec<f64>,
    face_distances: Option<PerFace<f64>>,
    gap: f64,
}

impl<'a> Job<'a> {
    fn new(command: &'a OffsetCommand, mesh: &HexMesh) -> Result<Self, Failure> {
        let (unit, size) = (command.unit, diagonal(mesh));
        let default = ValidateOptions::default();
        let planarity = command
            .planarity
            .map_or(default.planarity, |q| q.fraction(unit, mesh.mean_edge()));
        let mut distances: Vec<f64> = command
            .distance
            .iter()
            .map(|d| d.length(unit, size))
            .collect();
        distances.sort_by(f64::total_cmp);
        let face_distances = command.face_distances.as_deref().map(read_distances);
        if command.face_distances.is_some() && command.kind != Kind::Face {
            return Err(Failure::new(
                Exit::Usage,
                "--face-distances needs --kind face",
            ));
        }
        if command.optimise && command.kind != Kind::Vertex {
            return Err(Failure::new(Exit::Usage, "--optimise needs --kind vertex"));
        }
        let silent = distances.is_empty() && face_distances.is_none();
        if silent && !command.max_distance && !command.gauss_image {
            return Err(Failure::new(
                Exit::Usage,
                "give --distance, --face-distances, --max-distance or --gauss-image",
            ));
        }
        Ok(Self {
            command,
            options: OffsetOptions {
                validity: ValidateOptions {
                    planarity,
                    ..default
                },
                ..Default::default()
            },
            distances,
            face_distances: face_distances.transpose()?,
            gap: command.gap.map_or(0.0, |gap| gap.length(unit, size)),
        })
    }

    fn inputs(&self) -> Vec<&Path> {
        let command = self.command;
        let more = [&command.surface, &command.face_distances];
        std::iter::once(command.input.as_path())
            .chain(more.into_iter().flatten().map(AsRef::as_ref))
            .collect()
    }
}

fn read_distances(path: &Path) -> Result<PerFace<f64>, Failure> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
    let number = |(k, word): (usize, &str)| {
        let refused = || format!("{}: number {} is `{word}`", path.display(), k + 1);
        let value = word.parse::<f64>().ok().filter(|x| x.is_finite());
        value.ok_or_else(|| Failure::input(refused()))
    };
    let numbers: Result<Vec<f64>, Failure> =
        text.split_whitespace().enumerate().map(number).collect();
    numbers.map(PerFace::from_vec)
}

/// The mesh that layers are offsets of, and how its vertices move.
struct Base {
    mesh: HexMesh,
    image: GaussImage,
    /// Of a vertex offset.
    spherical: Option<SphericalMesh>,
    optimised: Option<AngleOptimised>,
}

impl Base {
    fn new(job: &Job<'_>, given: HexMesh) -> Result<Self, Failure> {
        let optimised = job
            .command
            .optimise
            .then(|| optimise(job, &given))
            .transpose()?;
        let mesh = optimised.as_ref().map_or(given, |o| o.mesh.clone());
        let (image, spherical) = match job.command.kind {
            Kind::Face => (
                face_gauss_image(&mesh, &job.options).or_exit(Exit::InputUnusable)?,
                None,
            ),
            Kind::Vertex => {
                let spherical =
                    vertex_gauss_image(&mesh, &job.options).or_exit(Exit::InputUnusable)?;
                (spherical.image.clone(), Some(spherical))
            }
        };
        Ok(Self {
            mesh,
            image,
            spherical,
            optimised,
        })
    }

    fn safe_distances(&self, job: &Job<'_>) -> SafeDistances {
        safe_distances(&self.mesh, &self.image, &job.options)
    }

    fn layers(&self, job: &Job<'_>) -> Result<Vec<Layer>, Failure> {
        if let Some(distances) = &job.face_distances {
            return Ok(vec![self.own_distances(job, distances)?]);
        }
        let distances = job.distances.iter();
        distances.map(|&d| self.layer(job, d)).collect()
    }

    fn layer(&self, job: &Job<'_>, distance: f64) -> Result<Layer, Failure> {
        let mesh = layer(&self.mesh, &self.image, distance, &job.options)
            .map_err(|e| self.refusal(job, distance, &e))?;
        Ok(Layer::new(mesh, distance))
    }

    fn own_distances(&self, job: &Job<'_>, distances: &PerFace<f64>) -> Result<Layer, Failure> {
        let offset =
            face_offset(&self.mesh, distances, &job.options).or_exit(Exit::InputUnusable)?;
        let largest = distances
            .iter()
            .fold(0.0f64, |m, &d| if d.abs() > m.abs() { d } else { m });
        let mesh = checked(&self.mesh, offset.apply(&self.mesh), largest, &job.options)
            .or_exit(Exit::NoValidResult)?;
        Ok(Layer::new(mesh, largest))
    }

    /// Why a distance does not work, and how far it might go.
    fn refusal(&self, job: &Job<'_>, distance: f64, error: &OffsetError) -> Failure {
        let safe = safe_distances(&self.mesh, &self.image, &job.options);
        let side = if distance < 0.0 { -1.0 } else { 1.0 };
        let most = if side < 0.0 {
            safe.inward
        } else {
            safe.outward
        };
        let message = format!(
            "{error}; the largest safe distance on that side is {}",
            side * most.distance
        );
        Failure::new(Exit::NoValidResult, message)
    }
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
        "the angle condition could not be reached: {:.3e} radians are left, {} panels are not as they should be",
        result.angle_defect[1],
        result.offenders.len()
    );
    Err(Failure::new(Exit::NoValidResult, message))
}

/// One offset, with what was measured of it.
struct Layer {
    distance: f64,
    mesh: ValidHexMesh,
    /// Largest distance of a vertex to the plane of its face, in mean edges.
    planarity: f64,
}

impl Layer {
    fn new(mesh: ValidHexMesh, distance: f64) -> Self {
        let faces = FlatFace::all(&mesh);
        let bent = faces.iter().map(|f| f.planarity_length).fold(0.0, f64::max);
        Self {
            distance,
            planarity: bent / mesh.mean_edge(),
            mesh,
        }
    }
}

fn side(safe: &SafeDistance) -> Value {
    json!({
        "distance": if safe.distance.is_finite() { json!(safe.distance) } else { Value::Null },
        "limit": safe.limit,
    })
}

fn report(
    job: &Job<'_>,
    base: &Base,
    safe: Option<&SafeDistances>,
    layers: &[Layer],
    contents: &[files::Content],
) -> Value {
    let command = job.command;
    json!({
        "schema_version": phex::report::SCHEMA_VERSION,
        "tool": phex::report::Tool::default(),
        "command": "offset",
        "input": command.input.display().to_string(),
        "unit": command.unit,
        "kind": base.image.kind,
        "settings": { "offset": job.options, "gap": job.gap },
        "angle_condition": base.optimised.as_ref().map(|o| json!({
            "defect_before": o.angle_defect[0],
            "defect_after": o.angle_defect[1],
            "deviation": o.deviation[1],
        })),
        "holonomy": base.spherical.as_ref().map(|s| s.holonomy),
        "facing": base.spherical.as_ref().map(|s| s.facing),
        "free_edges": base.spherical.as_ref().map(|s| s.free_edges.clone()),
        "safe_distances": safe.map(|s| json!({ "outward": side(&s.outward), "inward": side(&s.inward) })),
        "layers": layers.iter().map(|l| json!({ "distance": l.distance, "planarity": l.planarity })).collect::<Vec<_>>(),
        "outputs": contents.iter().map(files::Content::record).collect::<Vec<_>>(),
    })
}

fn summary(
    base: &Base,
    safe: Option<&SafeDistances>,
    layers: &[Layer],
    contents: &[files::Content],
) -> String {
    let mut text = String::new();
    if let Some(o) = &base.optimised {
        let [before, after] = o.angle_defect;
        let _ = writeln!(
            text,
            "angle condition  {before:.2e} -> {after:.2e} rad, moved by up to {:.3e}",
            o.deviation[1]
        );
    }
    if let Some(s) = &base.spherical {
        let _ = writeln!(
            text,
            "spherical mesh   closes to {:.1e}, faces the normals by {:.3} at least",
            s.holonomy.defect, s.facing
        );
    }
    if let Some(safe) = safe {
        for (name, side) in [("outward", &safe.outward), ("inward", &safe.inward)] {
            let limit = side
                .limit
                .as_ref()
                .map_or(String::new(), |v| format!("  ({v})"));
            let _ = writeln!(text, "safe {name:<12}{}{limit}", side.distance);
        }
    }
    for layer in layers {
        let _ = writeln!(
            text,
            "layer {:<11}planar to {:.1e} mean edges",
            layer.distance, layer.planarity
        );
    }
    for content in contents {
        let _ = writeln!(text, "{}", content.line());
    }
    text
}
