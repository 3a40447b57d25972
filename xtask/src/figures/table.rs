//! The table "method x surface".

use super::run::{Phex, Said, WORK};
use super::surfaces::{SURFACES, commands};
use std::fmt::Write;

/// Methods in the order of the table; the last two are ours.
const METHODS: [&str; 8] = [
    "power-diagram",
    "projective-dual",
    "dual-subdivision",
    "support-function",
    "tangent-planes",
    "parallel",
    "brick-wall",
    "lattice",
];
/// Panels of each run.
const PANELS: usize = 200;

/// The table as Markdown, with what refused runs said below it.
pub fn table(phex: &Phex) -> Result<String, String> {
    for line in SURFACES.iter().flat_map(|name| commands(name)) {
        phex.follow(&line)?;
    }
    let mut rows = String::new();
    let mut refusals = String::new();
    for method in METHODS {
        let _ = write!(rows, "| `{method}` |");
        for surface in SURFACES {
            let (cell, refusal) = cell(phex, method, surface)?;
            let _ = write!(rows, " {cell} |");
            if let Some(reason) = refusal {
                let _ = writeln!(refusals, "- `{method}`, {surface}: {reason}");
            }
        }
        rows.push('\n');
    }
    let commands = SURFACES.iter().flat_map(|name| commands(name));
    let commands: Vec<String> = commands.collect();
    Ok(format!(
        "| method | {} |\n|---|{}\n{rows}\n```sh\n{}\nphex mesh SURFACE -o {WORK}/table.obj --method METHOD -n {PANELS} --keep-invalid\n```\n\n\
         ### What the refused runs say\n\n{refusals}",
        SURFACES.join(" | "),
        "---|".repeat(SURFACES.len()),
        commands.join("\n")
    ))
}

/// A cell, and the words of the refusal if there was one.
fn cell(phex: &Phex, method: &str, surface: &str) -> Result<(String, Option<String>), String> {
    let line = format!(
        "mesh {WORK}/{surface}.obj -o {WORK}/table.obj --method {method} -n {PANELS} --keep-invalid --progress none"
    );
    let said = phex.run(&line)?;
    if said.row("panels").is_some() {
        return Ok((figures(&said), None));
    }
    let reason = said
        .err
        .lines()
        .next()
        .unwrap_or("")
        .trim_start_matches("error: ")
        .to_owned();
    let forced = phex.run(&format!("{line} --any-domain"))?;
    if forced.row("panels").is_some() {
        return Ok((
            format!("*refused*; forced: {}", figures(&forced)),
            Some(reason),
        ));
    }
    Ok(("*refused*".to_owned(), Some(reason)))
}

/// Planarity, faces that are not simple, deviation.
fn figures(said: &Said) -> String {
    let word = |row: &str, n: usize| -> String {
        let words = said.row(row).and_then(|r| r.split_whitespace().nth(n));
        words.unwrap_or("?").trim_end_matches(',').to_owned()
    };
    let invalid = if said
        .row("simple")
        .is_some_and(|row| row.starts_with("every face"))
    {
        "0".to_owned()
    } else {
        format!("**{}**", word("simple", 0))
    };
    format!(
        "{}, {invalid}, {} %",
        word("planarity", 1),
        word("deviation", 1)
    )
}
