//! Tables of panels, edges, nodes, sheets and groups, as CSV files and as one XLSX workbook.
//!
//! Lengths are in mm, areas in m², angles in degrees. Several values in one cell are separated by `;`, in the order of the
//! panel's corners: side `i` goes from corner `i` to the next, and edge, neighbour, mitre and length lists run alike.

mod edges;
mod groups;
mod nodes;
mod panels;
mod sheets;
mod workbook;

pub use workbook::xlsx;

use crate::error::FabError;
use crate::fabricate::Fabrication;
use phex_mesh::Vec3;

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
/// If a column is missing or holds no number; the line is named.
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
    let (id, x, y, z) = (
        column("id")?,
        column("centre_x_mm")?,
        column("centre_y_mm")?,
        column("centre_z_mm")?,
    );
    let row = |(k, record): (usize, Result<csv::StringRecord, csv::Error>)| {
        let record = record.map_err(|e| failed(e.to_string()))?;
        let number = |c: usize| {
            let value = record[c].parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| failed(format!("line {}: `{}` is no number", k + 2, &record[c])))
        };
        Ok((
            record[id].to_owned(),
            Vec3::new(number(x)?, number(y)?, number(z)?),
        ))
    };
    reader.records().enumerate().map(row).collect()
}

/// Values of one cell.
fn list<T: ToString>(values: impl IntoIterator<Item = T>) -> Cell {
    let words: Vec<String> = values.into_iter().map(|v| v.to_string()).collect();
    words.join(";").into()
}
