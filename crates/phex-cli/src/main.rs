//! The program `phex`: arguments to options, options to results, results to files and an exit code.

mod args;
mod bundle;
mod commands;
mod contact;
mod dual_arguments;
mod exit;
mod fab_arguments;
mod html;
mod machine;
mod method_summary;
mod offset_arguments;
mod output;
mod output_folder;
mod parallel_arguments;
mod picture_arguments;
mod printable;
mod progress;
mod promise;
mod shared_arguments;
mod start;
mod summary;
mod sweep_arguments;
mod terms;
mod verdict;

use args::Arguments;
use clap::Parser;
use exit::{Exit, Failure, OrExit};
use printable::tell;
use shared_arguments::{ProgressMode, Talk};
use start::START;
use std::process::ExitCode;

fn main() -> ExitCode {
    if std::env::args_os().len() == 1 {
        return output::print(START)
            .map_or_else(|f| f.exit, |()| Exit::Success)
            .into();
    }
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return usage(&error),
    };
    let talk = arguments.command.talk().clone();
    match run(arguments) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            say(&failure, &talk);
            failure.exit.into()
        }
    }
}

fn run(arguments: Arguments) -> Result<Exit, Failure> {
    progress::install_interrupt_handler().or_exit(Exit::Internal)?;
    commands::run(arguments.command)
}

/// Shows help, or what is wrong with the command line.
fn usage(error: &clap::Error) -> ExitCode {
    // A closed pipe must not turn help into a failure.
    let _ = error.print();
    if error.use_stderr() {
        Exit::Usage.into()
    } else {
        Exit::Success.into()
    }
}

fn say(failure: &Failure, talk: &Talk) {
    if talk.progress == ProgressMode::Json {
        let exit = failure.exit as u8;
        let message = failure.to_string();
        let event = serde_json::json!({ "event": "error", "exit_code": exit, "message": message });
        tell(&event.to_string());
    } else {
        tell(&format!("error: {failure}"));
    }
}
