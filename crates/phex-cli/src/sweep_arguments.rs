//! What can be typed after `phex sweep`.

use crate::exit::EXIT_CODES;
use crate::shared_arguments::Talk;
use clap::{Args, Subcommand};
use phex_study::Shard;
use std::path::PathBuf;

/// Arguments of `phex sweep`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct SweepCommand {
    /// What else can be done with a study.
    #[command(subcommand)]
    pub part: Option<SweepPart>,
    /// What is solved.
    #[command(flatten)]
    pub solve: SweepArguments,
}

/// What else can be done with a study.
#[derive(Debug, Subcommand)]
pub enum SweepPart {
    /// Write the table `designs.csv` and the page `index.html` of all finished variants
    Collect(CollectArguments),
}

/// Arguments of a sweep.
#[derive(Debug, Args)]
pub struct SweepArguments {
    /// Study: surfaces, settings, lists of values
    #[arg(value_name = "STUDY.TOML", required = true)]
    pub study: Option<PathBuf>,
    /// Folder of the variants' folders
    #[arg(short, long, value_name = "FOLDER", required = true)]
    pub output: Option<PathBuf>,
    /// Solve a share of the variants, the I-th of N; those of other shares are not touched
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Number of threads of each variant; results do not depend on it [default: all cores]
    #[arg(short, long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex sweep collect`.
#[derive(Debug, Args)]
pub struct CollectArguments {
    /// Folder of the variants' folders
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Title of the page [default: the folder's name]
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

impl SweepCommand {
    /// How it talks.
    pub fn talk(&self) -> &Talk {
        match &self.part {
            Some(SweepPart::Collect(collect)) => &collect.talk,
            None => &self.solve.talk,
        }
    }
}
