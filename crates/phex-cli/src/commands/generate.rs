//! `phex generate`: what packages hold besides the program, made from the command line itself.

use crate::args::{Arguments, GenerateCommand, Generated};
use crate::exit::{EXIT_CODES, Exit, Failure, OrExit};
use crate::output;
use clap::{Command, CommandFactory, ValueEnum};
use clap_complete::Shell;
use std::fmt::Write;
use std::path::Path;

/// Width of the help texts in the reference, in characters.
const COLUMNS: usize = 100;

/// Runs the command.
///
/// # Errors
/// If a file can't be written.
pub fn run(command: &GenerateCommand) -> Result<Exit, Failure> {
    match (command.what, &command.output) {
        (Generated::Man, Some(folder)) => manual(folder),
        (Generated::Completions, Some(folder)) => completions(folder),
        _ => return output::print(&reference()).map(|()| Exit::Success),
    }
    .or_exit(Exit::Internal)?;
    Ok(Exit::Success)
}

fn manual(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    clap_mangen::generate_to(Arguments::command(), folder)
}

fn completions(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for shell in Shell::value_variants() {
        clap_complete::generate_to(*shell, &mut Arguments::command(), "phex", folder)?;
    }
    Ok(())
}

/// All commands with their help, as a chapter of the book.
fn reference() -> String {
    let mut all = Arguments::command();
    all.build();
    let mut text = "# Commands\n\n\
        This chapter has what `phex help COMMAND` says of each command. `phex generate reference` writes this page, and the tests hold it to the program.\n"
        .to_owned();
    for command in all.get_subcommands().filter(|c| !c.is_hide_set()) {
        if command.get_name() != "help" {
            add(&mut text, command.clone());
        }
    }
    // Writing to a string does not fail.
    let _ = write!(text, "\n## Exit codes\n\n```text\n{EXIT_CODES}\n```\n");
    text
}

fn add(text: &mut String, command: Command) {
    let name = command.get_name().to_owned();
    let mut command = command.after_help("").term_width(COLUMNS);
    let help = command.render_long_help().to_string();
    let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
    let help = lines.join("\n");
    let _ = write!(text, "\n## phex {name}\n\n```text\n{}\n```\n", help.trim());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_has_every_command_that_is_shown_and_its_options() {
        let text = reference();
        for command in Arguments::command().get_subcommands() {
            let heading = format!("\n## phex {}\n", command.get_name());
            assert_eq!(text.contains(&heading), !command.is_hide_set(), "{heading}");
        }
        assert!(text.contains("--max-deviation") && text.contains("Usage: phex mesh"));
    }

    #[test]
    fn packages_get_manual_pages_and_completions() {
        let folder = tempfile::tempdir().unwrap();
        manual(folder.path()).unwrap();
        completions(folder.path()).unwrap();
        for name in ["phex.1", "phex-mesh.1", "phex.bash", "_phex", "phex.fish"] {
            let file = folder.path().join(name);
            assert!(file.metadata().is_ok_and(|m| m.len() > 500), "{name}");
        }
    }
}
