//! `phex doctor`: what this program and this machine have, and a small run.

use super::tell;
use crate::args::DoctorCommand;
use crate::exit::{Exit, Failure, OrExit};
use crate::machine::facts;
use phex::Mesher;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use std::time::Instant;

/// Panels of the small run.
const PANELS: usize = 60;

/// Runs the command.
///
/// # Errors
/// If the small run fails, or standard output can't be written.
pub fn run(command: &DoctorCommand) -> Result<Exit, Failure> {
    let mut table = facts();
    let start = Instant::now();
    let shape = Shape::from_name("roof", &[]).or_exit(Exit::Internal)?;
    let options = TriangulationOptions {
        triangles: 2000,
        ..Default::default()
    };
    let roof = triangulate(&shape, &options).or_exit(Exit::Internal)?;
    let made = Mesher::new().panels(PANELS).run(&roof);
    let made = made.or_exit(Exit::Internal)?;
    let seconds = start.elapsed().as_secs_f64();
    let panels = made.mesh().topology().n_faces();
    let fine = made.is_valid();
    let said = if fine { "valid" } else { "NOT valid" };
    table.row(
        "small run",
        format!("the roof with {panels} panels is {said}, in {seconds:.1} s"),
    );
    tell(command.talk.quiet, &table.into_text())?;
    Ok(if fine { Exit::Success } else { Exit::Internal })
}
