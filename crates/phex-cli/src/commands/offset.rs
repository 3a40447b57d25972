//! `phex offset`: layers at constant distance of faces or vertices, solid panels and beams between
//! them.
//!
//! Everything is computed and checked before anything is written, so that a distance that goes too
//! far leaves no file.

mod base;
mod between;
mod files;
mod told;

use super::{tell, use_threads};
use crate::exit::{Exit, Failure};
use crate::offset_arguments::{Kind, OffsetCommand};
use crate::output::{check_writable, given, write_text};
use crate::progress::{Reporter, check_interruption};
use base::{Base, OffsetLayer};
use files::Files;
use phex::offset::OffsetOptions;
use phex_job::{MeshFile, NumberLine, check_distances, read_numbers};
use phex_mesh::{HexMesh, PerFace, ValidateOptions};
use std::path::Path;
use told::Told;

/// Runs the command.
///
/// # Errors
/// If the mesh can't be used, has no such offset, a distance goes too far, or files of others are
/// in the way; nothing is written then.
pub fn run(command: &OffsetCommand) -> Result<Exit, Failure> {
    use_threads(command.threads)?;
    let input = MeshFile::read(&command.input)?;
    let (given, _) = input.polygon_mesh()?;
    if let Some(note) = command.unit.doubted(given.diagonal()) {
        Reporter::new(&command.talk).note(note);
    }
    let job = OffsetJob::new(command, &given)?;
    let files = Files::plan(command, &job.distances)?;
    let outputs = files.outputs();
    let paths: Vec<_> = outputs
        .iter()
        .map(|(path, c)| (path.as_path(), *c))
        .collect();
    check_writable(&paths, &job.inputs())?;
    let folder = files.folder();
    if let Some(folder) = &folder {
        folder.check(&files.in_folder(), &[])?;
    }
    let base = Base::new(&job, given)?;
    let safe = command.max_distance.then(|| base.safe_distances(&job));
    let layers = base.layers(&job)?;
    check_interruption()?;
    let contents = files.contents(command, &job, &base, &layers)?;
    let written: Vec<_> = contents.iter().map(files::OffsetFile::file).collect();
    folder.map_or(Ok(()), |folder| folder.write(&written))?;
    let told = Told {
        job: &job,
        base: &base,
        safe: safe.as_ref(),
        layers: &layers,
        contents: &contents,
    };
    if let Some(path) = &command.report {
        write_text(path, &format!("{:#}\n", told.report()))?;
    }
    tell(command.talk.quiet, &told.summary())?;
    Ok(Exit::of_check(base.is_within_limits()))
}

/// What was typed, in model units.
struct OffsetJob<'a> {
    command: &'a OffsetCommand,
    options: OffsetOptions,
    distances: Vec<f64>,
    face_distances: Option<PerFace<f64>>,
    gap: f64,
}

impl<'a> OffsetJob<'a> {
    fn new(command: &'a OffsetCommand, mesh: &HexMesh) -> Result<Self, Failure> {
        let (unit, size) = (command.unit, mesh.diagonal());
        let planarity = command
            .planarity
            .map(|q| q.fraction(unit, mesh.mean_edge()));
        let mut distances: Vec<f64> = command
            .distance
            .iter()
            .map(|d| d.length(unit, size))
            .collect();
        distances.sort_by(f64::total_cmp);
        check_distances("--distance", &distances, mesh)?;
        if let Some(twice) = distances.windows(2).find(|pair| pair[0] == pair[1]) {
            let told = format!("--distance: {} (model units) is given twice", twice[0]);
            return Err(Failure::new(Exit::Usage, told));
        }
        let between = command.solids || command.beams;
        if between && distances == [0.0] {
            return Err(Failure::new(
                Exit::Usage,
                "--distance 0 is the mesh itself: --solids and --beams lie between two layers, so give another distance",
            ));
        }
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
        if silent && !command.gauss_image && command.output.is_some() {
            return Err(Failure::new(
                Exit::Usage,
                "--output has no effect without layers: give --distance or --face-distances, or leave it out",
            ));
        }
        if silent && between {
            return Err(Failure::new(
                Exit::Usage,
                "--solids and --beams have no effect without layers: give --distance or --face-distances",
            ));
        }
        Ok(Self {
            command,
            options: OffsetOptions {
                validity: ValidateOptions {
                    planarity,
                    ..Default::default()
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
        given([
            Some(&command.input),
            command.surface.as_ref(),
            command.face_distances.as_ref(),
        ])
    }
}

fn read_distances(path: &Path) -> Result<PerFace<f64>, Failure> {
    let distance = |line: NumberLine| match line.numbers[..] {
        [distance] => Ok(distance),
        _ => Err(line.wrong("one number")),
    };
    let all: Result<Vec<f64>, _> = read_numbers(path)?.into_iter().map(distance).collect();
    Ok(PerFace::from_vec(all?))
}
