//! All tables in one XLSX workbook, a sheet for each.

use super::{Cell, Table};
use crate::error::FabError;
use rust_xlsxwriter::{DocProperties, ExcelDateTime, Format, Workbook, XlsxError};

/// Most characters that a cell of a workbook holds.
const CELL: usize = 32_767;

/// The workbook; headings stay in sight. Texts that are too long for a cell end in `...`, and are
/// whole in the CSV files.
///
/// # Errors
/// If there are more rows than a sheet holds (1 048 576).
pub fn xlsx(tables: &[Table]) -> Result<Vec<u8>, FabError> {
    let failed = |cause: XlsxError| FabError::Content {
        name: "schedules.xlsx".into(),
        cause: cause.to_string(),
    };
    fill(tables).map_err(failed)
}

fn fill(tables: &[Table]) -> Result<Vec<u8>, XlsxError> {
    let mut workbook = Workbook::new();
    // A fixed date: the same input gives the same bytes.
    let date = ExcelDateTime::from_ymd(2000, 1, 1)?;
    workbook.set_properties(&DocProperties::new().set_creation_datetime(&date));
    let bold = Format::new().set_bold();
    for table in tables {
        let sheet = workbook.add_worksheet();
        sheet.set_name(table.name)?;
        sheet.set_freeze_panes(1, 1)?;
        for (column, heading) in (0u16..).zip(&table.head) {
            sheet.write_string_with_format(0, column, *heading, &bold)?;
            sheet.set_column_width(column, (heading.len() + 2).clamp(10, 28) as f64)?;
        }
        for (row, cells) in (1u32..).zip(&table.rows) {
            for (column, cell) in (0u16..).zip(cells) {
                match cell {
                    Cell::Text(text) => sheet.write_string(row, column, shortened(text))?,
                    Cell::Number(number) => sheet.write_number(row, column, *number)?,
                };
            }
        }
    }
    workbook.save_to_buffer()
}

fn shortened(text: &str) -> String {
    if text.chars().count() <= CELL {
        return text.to_owned();
    }
    let start: String = text.chars().take(CELL - 3).collect();
    start + "..."
}
