//! The ledger for people: a table of all rows, and what changed.

use super::entries::{Entry, Ledger};
use super::figures::{Better, FIGURES, Figure, FigureScope, compare};
use std::fmt::Write;

/// One row while the ledger is being made.
pub fn line(entry: &Entry) -> String {
    let short = [
        "panels",
        "hexagons",
        "clearance",
        "deviation",
        "spread",
        "seconds",
    ];
    let shown = FIGURES.iter().filter(|f| short.contains(&f.name));
    let figures = shown.map(|f| format!("{} {}", f.heading, text(f, entry)));
    let figures: Vec<String> = figures.collect();
    format!(
        "{:20} {:2} {}",
        entry.name,
        entry.exit_code,
        figures.join("  ")
    )
}

fn text(figure: &Figure, entry: &Entry) -> String {
    match entry.figures.get(figure.name) {
        None => "-".to_owned(),
        Some(x) if figure.name == "planarity" => format!("{x:.0e}"),
        Some(x) => format!("{x:.*}", figure.digits),
    }
}

/// What became better and worse, row by row, and how many of each.
pub fn comparison(kept: &Ledger, made: &Ledger) -> String {
    let mut out = String::new();
    let [mut better, mut worse, mut same, mut new] = [0; 4];
    for entry in &made.rows {
        let Some(before) = kept.row(&entry.name) else {
            new += 1;
            let _ = writeln!(out, "new    {}", line(entry));
            continue;
        };
        let change = compare(before, entry, FigureScope::All);
        better += usize::from(!change.better.is_empty());
        worse += usize::from(change.is_worse());
        same += usize::from(change.better.is_empty() && !change.is_worse());
        for (word, texts) in [("better", &change.better), ("worse ", &change.worse)] {
            if !texts.is_empty() {
                let _ = writeln!(out, "{word} {:20} {}", entry.name, texts.join("; "));
            }
        }
    }
    let _ = writeln!(
        out,
        "{better} rows better in something, {worse} worse in something, {same} the same, {new} new"
    );
    let _ = write!(out, "{}", overall(kept, made));
    out
}

/// Medians over the rows that both have.
fn overall(kept: &Ledger, made: &Ledger) -> String {
    let mut out = String::new();
    for figure in FIGURES.iter().filter(|f| f.better != Better::Neither) {
        let both = made.rows.iter().filter_map(|now| {
            let before = kept.row(&now.name)?.figures.get(figure.name)?;
            Some((*before, *now.figures.get(figure.name)?))
        });
        let (before, now): (Vec<f64>, Vec<f64>) = both.unzip();
        if let (Some(before), Some(now)) = (median(before), median(now)) {
            let digits = if figure.name == "planarity" { 16 } else { 3 };
            let _ = writeln!(
                out,
                "  median {:15} {before:.digits$} -> {now:.digits$}",
                figure.name
            );
        }
    }
    out
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The whole ledger.
pub fn markdown(ledger: &Ledger) -> String {
    let mut out = String::from(
        "# Ledger\n\n\
         Made by `cargo xtask ledger`, never by hand: surfaces of every kind at set sizes, each a run of `phex mesh` on one thread\n\
         with the options that stand here and the defaults else. `cargo xtask ledger --compare` makes all rows again and says what is\n\
         better and what is worse. Rows of models that are not in the repository are made where their folder is there (`--models`).\n\n",
    );
    let headings: Vec<&str> = FIGURES.iter().map(|f| f.heading).collect();
    let _ = writeln!(
        out,
        "| row | options | exit | {} | fails |",
        headings.join(" | ")
    );
    let _ = writeln!(out, "|---|---|---|{}---|", "---:|".repeat(FIGURES.len()));
    for entry in &ledger.rows {
        let cells: Vec<String> = FIGURES.iter().map(|f| text(f, entry)).collect();
        let failed = match entry.verdict.as_str() {
            "no mesh" => "no mesh".to_owned(),
            _ => entry.failed.join(", "),
        };
        let _ = writeln!(
            out,
            "| {} | `{}` | {} | {} | {failed} |",
            entry.name,
            entry.options,
            entry.exit_code,
            cells.join(" | ")
        );
    }
    let count = |code: i32| ledger.rows.iter().filter(|e| e.exit_code == code).count();
    let _ = writeln!(
        out,
        "\n{} rows: {} pass, {} are valid but outside a tolerance, {} have no valid mesh or none at all.\n",
        ledger.rows.len(),
        count(0),
        count(3),
        ledger.rows.len() - count(0) - count(3)
    );
    out.push_str("| column | meaning | counts as the same |\n|---|---|---|\n");
    for figure in &FIGURES {
        let _ = writeln!(
            out,
            "| {} | {} | {} |",
            figure.heading,
            figure.meaning,
            tolerance(figure)
        );
    }
    out
}

fn tolerance(figure: &Figure) -> String {
    let relative = format!("{:.0} %", 100.0 * figure.relative);
    match (figure.better, figure.relative > 0.0, figure.absolute > 0.0) {
        (Better::Neither, ..) => "not compared".to_owned(),
        (_, true, true) => format!("{relative}, or {}", figure.absolute),
        (_, true, false) => relative,
        _ => figure.absolute.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ledger(exit_code: i32, hexagons: f64) -> Ledger {
        let rows = vec![Entry {
            name: "wave".to_owned(),
            options: "-n 300".to_owned(),
            verdict: "pass".to_owned(),
            failed: Vec::new(),
            exit_code,
            figures: [("hexagons".to_owned(), hexagons)].into(),
        }];
        Ledger { rows }
    }

    #[test]
    fn comparison_says_what_changed_and_counts() {
        let text = comparison(&ledger(0, 0.9), &ledger(3, 0.99));
        assert!(
            text.contains("better wave") && text.contains("hex 0.900 -> 0.990"),
            "{text}"
        );
        assert!(
            text.contains("worse  wave") && text.contains("pass (0) -> pass (3)"),
            "{text}"
        );
        assert!(
            text.contains("1 rows better in something, 1 worse in something, 0 the same, 0 new")
        );
        let fresh = comparison(&Ledger::default(), &ledger(0, 0.9));
        assert!(fresh.contains("0 the same, 1 new"), "{fresh}");
    }

    #[test]
    fn table_has_a_row_for_each_entry_and_explains_every_column() {
        let text = markdown(&ledger(0, 0.9));
        assert!(text.contains("| wave | `-n 300` | 0 |"), "{text}");
        assert!(text.contains("1 rows: 1 pass, 0 are valid"), "{text}");
        let explained = FIGURES.iter().all(|f| text.contains(f.meaning));
        assert!(explained);
    }
}
