//! Tables of panels, edges, nodes, sheets and groups, as CSV files and as one XLSX workbook.
//!
//! Lengths are in mm, areas in m², angles in degrees. Several values in one cell are separated by
//! `;`, in the order of the panel's corners: side `i` goes from corner `i` to the next, and edge,
//! neighbour, mitre and length lists run alike.

mod edges;
mod groups;
mod nodes;
mod panels;
mod sheets;
mod workbook;

pub use workbook::xlsx;

use crate::error::FabError;
use crate::fabricate::Fabrication;
use crate::ids::{check_name, engraved};
use phex_mesh::{PanelLimit, Vec3};
use std::collections::HashMap;

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// A number.
    Number(f64),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<usize> for Cell {
    fn from(number: usize) -> Self {
        Self::Number(number as f64)
    }
}

impl From<bool> for Cell {
    fn from(yes: bool) -> Self {
        if yes { "yes" } else { "no" }.into()
    }
}

/// A table with a row of headings.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its name: of the CSV file, and of the sheet in the workbook.
    pub name: &'static str,
    /// Headings.
    pub head: Vec<&'static str>,
    /// Rows, each as long as the headings.
    pub rows: Vec<Vec<Cell>>,
}

/// How many panels are beyond any of the limits that are set, and beyond each of them.
pub fn beyond_limits(fabrication: &Fabrication) -> (usize, Vec<(PanelLimit, usize)>) {
    panels::beyond_limits(fabrication)
}

/// All tables.
pub fn tables(fabrication: &Fabrication) -> Vec<Table> {
    vec![
        panels::table(fabrication),
        edges::table(fabrication),
        nodes::table(fabrication),
        sheets::table(fabrication),
        groups::table(fabrication),
    ]
}

/// A table as CSV; numbers with all their digits.
///
/// # Errors
/// If a row is not as long as the headings.
pub fn csv(table: &Table) -> Result<Vec<u8>, FabError> {
    let failed = |cause: String| FabError::Content {
        name: format!("{}.csv", table.name),
        cause,
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(&table.head)
        .map_err(|e| failed(e.to_string()))?;
    for row in &table.rows {
        let words = row.iter().map(|cell| match cell {
            Cell::Text(text) => text.clone(),
            Cell::Number(number) => number.to_string(),
        });
        writer
            .write_record(words)
            .map_err(|e| failed(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| failed(e.to_string()))
}

/// Names and centres (mm) of the panels of a `panels` table.
///
/// # Errors
/// If a column is missing or holds no number, or a name can't be one or is there twice; the line is
/// named.
pub fn panel_centres(bytes: &[u8]) -> Result<Vec<(String, Vec3)>, FabError> {
    let failed = |cause: String| FabError::Content {
        name: "table of panels".into(),
        cause,
    };
    let mut reader = csv::Reader::from_reader(bytes);
    let head = reader.headers().map_err(|e| failed(e.to_string()))?.clone();
    let column = |name: &str| {
        head.iter()
            .position(|h| h == name)
            .ok_or_else(|| failed(format!("there is no column `{name}`")))
    };
    let id = column("id")?;
    let centre = [
        column("centre_x_mm")?,
        column("centre_y_mm")?,
        column("centre_z_mm")?,
    ];
    let mut lines = HashMap::new();
    let row = |record: Result<csv::StringRecord, csv::Error>| {
        let record = record.map_err(|e| failed(e.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let at = |cause: String| failed(format!("line {line}: {cause}"));
        let name = &record[id];
        check_name(name).map_err(at)?;
        if let Some(first) = lines.insert(engraved(name), line) {
            return Err(at(format!("`{name}` is the panel of line {first}, too")));
        }
        let number = |c: usize| {
            let value = record[c].parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| at(format!("{:?} is no number", shortened(&record[c]))))
        };
        let [x, y, z] = centre;
        Ok((
            name.to_owned(),
            Vec3::new(number(x)?, number(y)?, number(z)?),
        ))
    };
    reader.records().map(row).collect()
}

fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Values of one cell.
fn list<T: ToString>(values: impl IntoIterator<Item = T>) -> Cell {
    let words: Vec<String> = values.into_iter().map(|v| v.to_string()).collect();
    words.join(";").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(names: &[&str]) -> Result<Vec<(String, Vec3)>, String> {
        let mut text = "id,centre_x_mm,centre_y_mm,centre_z_mm\n".to_owned();
        for name in names {
            text += &format!("\"{name}\",1,2,3\n");
        }
        panel_centres(text.as_bytes()).map_err(|e| e.to_string())
    }

    #[test]
    fn names_that_can_t_tell_panels_apart_are_refused_with_their_line() {
        let long = "N".repeat(33);
        for (names, cause) in [
            (
                vec!["A1", "B 2", "A1"],
                "line 4: `A1` is the panel of line 2",
            ),
            (vec!["A1", "a1"], "line 3: `a1` is the panel of line 2"),
            (vec!["A1", ""], "line 3: the name is empty"),
            (vec![long.as_str()], "line 2: the name has 33 characters"),
            (vec!["A\x001"], "line 2: the name \"A\\01\" holds '\\0'"),
            (vec!["A1", "A\n2"], "line 3: the name \"A\\n2\" holds '\\n'"),
            (vec!["A\r2"], "holds '\\r'"),
            (vec!["A1;A2"], "holds ';'"),
            (vec!["=1+1"], "line 2: the name \"=1+1\" begins with '='"),
            (vec!["+1"], "begins with '+'"),
            (vec!["-1"], "begins with '-'"),
            (vec!["@A"], "begins with '@'"),
            (vec![" A1"], "begins or ends with a blank"),
            (vec!["S\u{fc}d"], "holds '\u{fc}'"),
        ] {
            let refused = read(&names).unwrap_err();
            assert!(refused.contains(cause), "{names:?}: {refused}");
        }
        let good = ["A1", "NORTH-12", "P0007", "b_2/3", "1.5"];
        let found: Vec<String> = read(&good).unwrap().into_iter().map(|p| p.0).collect();
        assert_eq!(found, good);
    }
}
