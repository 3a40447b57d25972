//! What became of the rows, as it is kept in a file.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Figures by name; one that does not exist (the boundary of a closed surface) is left out.
pub type Figures = BTreeMap<String, f64>;

/// All rows that were made.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// The rows, in the order of the list.
    pub rows: Vec<Entry>,
}

/// A row, and what became of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// The row's name.
    pub name: String,
    /// Options of `phex mesh`.
    pub options: String,
    /// `pass`, `outside_tolerance` or `invalid` from the report; else how the process ended.
    pub verdict: String,
    /// Names of the checks that fail.
    pub failed: Vec<String>,
    /// Exit code; -1 where the process was ended.
    pub exit_code: i32,
    /// Figures by name.
    pub figures: Figures,
}

impl Ledger {
    /// Reads a ledger.
    pub fn read(path: &Path) -> Result<Self, String> {
        serde_json::from_str(&crate::read(path)?).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// Writes it.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let json = serde_json::to_string_pretty(self).map_err(|e| e.to_string())?;
        crate::write(path, &(json + "\n"))
    }

    /// The same with rows in place of those of their names.
    pub fn with(mut self, other: Self) -> Self {
        for row in other.rows {
            match self.rows.iter_mut().find(|old| old.name == row.name) {
                Some(old) => *old = row,
                None => self.rows.push(row),
            }
        }
        self
    }

    /// The row of a name.
    pub fn row(&self, name: &str) -> Option<&Entry> {
        self.rows.iter().find(|row| row.name == name)
    }
}
