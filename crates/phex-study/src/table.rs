//! All rows of a folder, and a table of them.

use crate::row::Row;
use crate::solve::{RUN_FILE, RunRecord};
use phex_job::JobError;
use serde_json::Value;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::path::Path;

/// What a folder of variants holds.
#[derive(Clone, Debug, Default)]
pub struct Collected {
    /// The rows of every finished variant, ordered by what was wanted.
    pub rows: Vec<Row>,
    /// What is wrong with the files that hold no row although they should, in the order of their
    /// names; such a variant is computed again when its study is.
    pub broken: Vec<String>,
}

/// The rows of every finished variant below a folder.
///
/// # Errors
/// If the folder can't be read.
pub fn collect(out: &Path) -> Result<Collected, JobError> {
    let told = |e: std::io::Error| JobError::input(format!("{}: {e}", out.display()));
    let mut found = Collected::default();
    for entry in std::fs::read_dir(out).map_err(told)? {
        let file = entry.map_err(told)?.path().join(RUN_FILE);
        let Ok(text) = std::fs::read_to_string(&file) else {
            continue;
        };
        match serde_json::from_str::<RunRecord>(&text) {
            Ok(run) => found.rows.push(run.row),
            Err(error) => found.broken.push(format!("{}: {error}", file.display())),
        }
    }
    found.rows.sort_by(order);
    found.broken.sort();
    Ok(found)
}

/// By surface, then by the other columns of what was wanted.
fn order(a: &Row, b: &Row) -> Ordering {
    let inputs: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let inputs = inputs.into_iter().filter(|name| name.starts_with("in:"));
    let mut by = std::iter::once("in:surface").chain(inputs.map(String::as_str));
    let unequal = by.find_map(|name| {
        let order = compare(a.get(name), b.get(name));
        (order != Ordering::Equal).then_some(order)
    });
    unequal.unwrap_or_else(|| compare(a.get("key"), b.get("key")))
}

fn compare(a: Option<&Value>, b: Option<&Value>) -> Ordering {
    let number = |v: Option<&Value>| v.and_then(Value::as_f64);
    match (number(a), number(b)) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        _ => text(a).cmp(&text(b)),
    }
}

/// A value as a table has it.
pub(crate) fn text(value: Option<&Value>) -> String {
    match value {
        None | Some(Value::Null) => String::new(),
        Some(Value::String(text)) => text.clone(),
        Some(value) => value.to_string(),
    }
}

/// The columns that some row has: what was wanted, what came of it, files.
pub(crate) fn columns(rows: &[Row]) -> Vec<String> {
    let all: BTreeSet<&String> = rows.iter().flat_map(Row::keys).collect();
    let group = |prefix: &'static str| {
        let of = all.iter().filter(move |name| name.starts_with(prefix));
        of.map(|name| (*name).clone())
    };
    let files = ["img", "threeD", "key"].map(str::to_owned);
    group("in:").chain(group("out:")).chain(files).collect()
}

/// Rows as CSV with the columns of Design Explorer: `in:`, `out:`, `img`, `threeD`; `key` is the
/// folder.
///
/// # Errors
/// If a row can't be written, which is a bug.
pub fn csv(rows: &[Row]) -> Result<String, JobError> {
    let columns = columns(rows);
    let mut table = csv::Writer::from_writer(Vec::new());
    let told = |e: csv::Error| JobError::Internal(e.to_string());
    table.write_record(&columns).map_err(told)?;
    for row in rows {
        let cells = columns.iter().map(|name| text(row.get(name)));
        table.write_record(cells).map_err(told)?;
    }
    let bytes = table
        .into_inner()
        .map_err(|e| JobError::Internal(e.to_string()))?;
    String::from_utf8(bytes).map_err(|e| JobError::Internal(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn row(panels: u64, status: &str) -> Row {
        let row = json!({ "in:panels": panels, "in:surface": "a, \"b\".obj", "out:status": status, "key": "k" });
        row.as_object().unwrap().clone()
    }

    #[test]
    fn a_table_has_the_columns_of_all_rows_and_quotes_what_it_must() {
        let mut second = row(100, "invalid");
        second.insert("out:panels".to_owned(), json!(97));
        let table = csv(&[row(40, "pass"), second]).unwrap();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(
            lines[0],
            "in:panels,in:surface,out:panels,out:status,img,threeD,key"
        );
        assert_eq!(lines[1], "40,\"a, \"\"b\"\".obj\",,pass,,,k");
        assert_eq!(lines[2], "100,\"a, \"\"b\"\".obj\",97,invalid,,,k");
    }

    #[test]
    fn a_broken_file_leaves_the_other_rows() {
        let folder = tempfile::tempdir().unwrap();
        let run = json!({
            "version": "", "variant": {}, "limits": {}, "row": row(40, "pass"),
            "cost": { "seconds": 1.0, "megabytes": 1.0, "threads": 1 },
        });
        for (name, text) in [
            ("whole", run.to_string()),
            ("cut", "{\"version\"".to_owned()),
        ] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
            std::fs::write(folder.path().join(name).join(RUN_FILE), text).unwrap();
        }
        let found = collect(folder.path()).unwrap();
        assert_eq!(found.rows, [row(40, "pass")]);
        assert!(found.broken.len() == 1 && found.broken[0].contains("cut"));
    }

    #[test]
    fn numbers_are_ordered_as_numbers() {
        let mut rows = [row(100, "pass"), row(40, "pass"), row(9, "pass")];
        rows.sort_by(order);
        let panels: Vec<&Value> = rows.iter().map(|r| &r["in:panels"]).collect();
        assert_eq!(panels, [&json!(9), &json!(40), &json!(100)]);
    }
}
