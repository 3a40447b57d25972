//! One file per command.

mod check;
mod convert;
mod criteria;
mod deliver;
mod doctor;
mod dual;
mod dupin;
mod fab;
mod generate;
mod info;
mod koebe;
mod mesh;
mod network;
mod offset;
mod parallel;
mod planarize;
mod power_diagram;
mod render;
mod report;
mod shape;
#[cfg(feature = "studio")]
mod studio;
mod subdivide;
mod sweep;
mod terms;

use crate::args::Command;
use crate::exit::{Exit, Failure};
use crate::output;
use phex_job::{Unit, thread_count};

/// Runs a command.
///
/// # Errors
/// Whatever ends it early, with its exit code.
pub fn run(command: Command) -> Result<Exit, Failure> {
    match command {
        Command::Mesh(command) => mesh::run(&command),
        Command::Network(command) => network::run(&command),
        Command::Planarize(command) => planarize::run(&command),
        Command::Offset(command) => offset::run(&command),
        Command::Fab(command) => fab::run(&command),
        Command::Check(command) => check::run(&command),
        Command::Report(command) => report::run(&command),
        Command::Render(command) => render::run(&command),
        Command::Info(command) => info::run(&command),
        Command::Convert(command) => convert::run(&command),
        Command::Shape(command) => shape::run(&command),
        Command::Koebe(command) => koebe::run(&command),
        Command::Parallel(command) => parallel::run(&command),
        Command::Dual(command) => dual::run(&command),
        Command::Subdivide(command) => subdivide::run(&command),
        Command::PowerDiagram(command) => power_diagram::run(&command),
        Command::Dupin(command) => dupin::run(&command),
        Command::Sweep(command) => sweep::run(&command),
        #[cfg(feature = "studio")]
        Command::Studio(command) => studio::run(&command),
        Command::Terms(command) => terms::run(&command),
        Command::Doctor(command) => doctor::run(&command),
        Command::Generate(command) => generate::run(&command),
    }
}

/// Prints a result, unless the user wants silence.
fn tell(quiet: bool, text: &str) -> Result<(), Failure> {
    if quiet { Ok(()) } else { output::print(text) }
}

/// The refusal of a typed value, with the unit in place of `model units`.
fn in_unit(told: impl std::fmt::Display, unit: Unit) -> Failure {
    let told = told.to_string();
    Failure::input(told.replace(" (model units)", &format!(" {unit}")))
}

/// Sets the number of threads; called once, before anything is computed.
fn use_threads(threads: Option<u16>) -> Result<usize, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(thread_count(threads)?);
    pool.build_global()
        .map_err(|e| Failure::new(Exit::Internal, e))?;
    Ok(rayon::current_num_threads())
}
