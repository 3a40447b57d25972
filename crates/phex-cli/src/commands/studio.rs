//! `phex studio`: the page, served on this machine alone.

use crate::args::StudioCommand;
use crate::exit::{Exit, Failure};
use crate::output;
use crate::printable::tell;
use crate::progress::{is_interrupted, keep_best};
use phex_studio::{StudioOptions, serve};

/// Runs the command until Ctrl-C.
///
/// # Errors
/// If the surface can't be read, or the port can't be had.
pub fn run(command: &StudioCommand) -> Result<Exit, Failure> {
    let options = StudioOptions {
        surface: command.surface.clone(),
        port: command.port,
    };
    // The first Ctrl-C is the studio's, which ends by itself; the second one ends the program.
    keep_best();
    let ready = |address: &str| {
        // A closed pipe, or a desktop without a browser, is no reason not to serve.
        let _ = output::print(&format!("phex studio: {address}\n"));
        if !command.talk.quiet {
            tell("Ctrl-C ends it.");
        }
        if !command.no_open {
            let _ = open::that_detached(address);
        }
    };
    serve(&options, ready, is_interrupted)?;
    Ok(Exit::Success)
}
