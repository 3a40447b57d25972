//! `cargo xtask ledger`: a fixed list of surfaces, what became of each, and whether that is better
//! or worse than before.
//!
//! `rows` is the list, `made` the surfaces that no file holds, `run` makes a row, `figures` reads
//! and compares its figures, `table` writes them. The committed `docs/ledger.json` is the
//! yardstick.

mod entries;
mod figures;
mod implicit;
mod made;
mod reference;
mod rows;
mod run;
mod table;

use entries::{Entry, Ledger};
use rows::LedgerRow;
use run::Runner;
use std::path::{Path, PathBuf};

pub use reference::run as reference;

/// The yardstick, relative to the repository's root.
const KEPT: &str = "docs/ledger.json";
/// The same for people.
const TABLE: &str = "docs/ledger.md";
/// Folder of surfaces, meshes and reports, relative to the repository's root.
const WORK: &str = "out/ledger";

/// What is wanted of the ledger.
struct WantedRows {
    /// Whether the yardstick stays and is compared with.
    compare: bool,
    /// Whether only the rows that `cargo xtask check` makes are wanted.
    quick: bool,
    /// Another program than the one that is built from this tree.
    program: Option<PathBuf>,
    /// Folder of models that are not part of the repository.
    models: PathBuf,
    /// Names of rows; all without any.
    only: Vec<String>,
}

impl WantedRows {
    fn parse(root: &Path, words: &[&str]) -> Result<Self, String> {
        let mut wanted = Self {
            compare: false,
            quick: false,
            program: None,
            models: root.join("../shared/models"),
            only: Vec::new(),
        };
        let mut words = words.iter();
        while let Some(&word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} takes a path"));
            match word {
                "--compare" => wanted.compare = true,
                "--quick" => wanted.quick = true,
                "--program" => wanted.program = Some(value()?.into()),
                "--models" => wanted.models = value()?.into(),
                name => wanted.only.push(name.to_owned()),
            }
        }
        let unknown = |name: &&String| !rows::ROWS.iter().any(|row| row.name == **name);
        match wanted.only.iter().find(unknown) {
            Some(name) => Err(format!("the ledger has no row {name:?}")),
            None => Ok(wanted),
        }
    }

    fn rows(&self) -> Vec<&'static LedgerRow> {
        let wanted = |row: &&LedgerRow| {
            (self.only.is_empty() || self.only.iter().any(|name| name == row.name))
                && (!self.quick || row.quick)
                && row.surface.is_there(&self.models)
        };
        rows::ROWS.iter().filter(wanted).collect()
    }
}

/// Makes the rows; without `--compare` they become the new yardstick, those that were not made
/// staying as they are.
pub fn ledger(root: &Path, words: &[&str]) -> Result<(), String> {
    let wanted = WantedRows::parse(root, words)?;
    let program = match &wanted.program {
        Some(program) => program.clone(),
        None => released(root)?,
    };
    let made = make(root, program, &wanted)?;
    let kept = Ledger::read(&root.join(KEPT)).ok();
    if let Some(kept) = &kept {
        print!("{}", table::comparison(kept, &made));
    }
    if !wanted.compare && !wanted.quick {
        let all = match kept {
            Some(kept) if !wanted.only.is_empty() => kept.with(made),
            _ => made,
        };
        all.write(&root.join(KEPT))?;
        crate::write(&root.join(TABLE), &table::markdown(&all))?;
        println!("written: {KEPT}, {TABLE}");
        return Ok(());
    }
    match kept {
        Some(kept) if wanted.compare => slipped(&kept, &made, figures::FigureScope::All),
        _ => Ok(()),
    }
}

/// The step of `cargo xtask check`: the quick rows, held to the yardstick in all figures but cost,
/// which depends on how the program was built.
pub fn check(root: &Path) -> Result<(), String> {
    let wanted = WantedRows::parse(root, &["--quick"])?;
    let made = make(root, crate::program_as_tested(root)?, &wanted)?;
    let kept = Ledger::read(&root.join(KEPT))?;
    print!("{}", table::comparison(&kept, &made));
    slipped(&kept, &made, figures::FigureScope::WithoutCost)
}

fn make(root: &Path, program: PathBuf, wanted: &WantedRows) -> Result<Ledger, String> {
    let runner = Runner::new(root, program, &wanted.models)?;
    let made = runner.run(&wanted.rows())?;
    made.write(&root.join(WORK).join("ledger.json"))?;
    crate::write(&root.join(WORK).join("ledger.md"), &table::markdown(&made))?;
    Ok(made)
}

/// The program of this tree, built with all optimisations.
fn released(root: &Path) -> Result<PathBuf, String> {
    crate::cargo(root, &["build", "--package", "phex-cli", "--release"])?;
    let name = format!("phex{}", std::env::consts::EXE_SUFFIX);
    Ok(crate::target_folder(root).join("release").join(name))
}

/// An error that names the rows that are worse than the yardstick.
fn slipped(kept: &Ledger, made: &Ledger, scope: figures::FigureScope) -> Result<(), String> {
    let worse = |entry: &&Entry| {
        let before = kept.row(&entry.name);
        before.is_some_and(|before| figures::compare(before, entry, scope).is_worse())
    };
    let names: Vec<&str> = (made.rows.iter().filter(worse))
        .map(|entry| entry.name.as_str())
        .collect();
    match names[..] {
        [] => Ok(()),
        _ => Err(format!(
            "worse than {KEPT}: {}; if that is the price of something better, say so and run cargo xtask ledger",
            names.join(", ")
        )),
    }
}
