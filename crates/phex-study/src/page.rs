//! All of a study as one HTML page that opens from a disk without a network: thumbnails, parallel
//! axes, a scatter of two figures with the best of both, one variant's figures, two beside each
//! other.

use crate::row::Row;
use crate::table::columns;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use phex_html::escaped;
use phex_job::JobError;
use serde_json::{Value, json};
use std::path::Path;

const STYLE: &str = include_str!("page/study.css");
const SCRIPT: &str = include_str!("page/study.js");
const BODY: &str = include_str!("page/study.html");
/// What the page may load: its own script and style, pictures of its own and of the folders beside
/// it.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: 'self' file:";

/// The page of a study's rows; thumbnails are read from the folders below `out`, reports and large
/// pictures stay there.
///
/// # Errors
/// If the data can't be written as JSON, which is a bug.
pub fn page(title: &str, rows: &[Row], out: &Path) -> Result<String, JobError> {
    let columns = columns(rows);
    let cells = |row: &Row| -> Vec<Value> {
        let cell = |name: &String| row.get(name).cloned().unwrap_or(Value::Null);
        columns.iter().map(cell).collect()
    };
    let key = |row: &Row| row.get("key").and_then(Value::as_str).map(str::to_owned);
    let thumbnail = |row: &Row| {
        let file = out.join(key(row)?).join("thumbnail.png");
        Some(STANDARD.encode(std::fs::read(file).ok()?))
    };
    let has_report = |row: &Row| key(row).is_some_and(|k| out.join(k).join("report.html").exists());
    let data = json!({
        "columns": columns,
        "rows": rows.iter().map(cells).collect::<Vec<_>>(),
        "thumbnails": rows.iter().map(thumbnail).collect::<Vec<_>>(),
        "pages": rows.iter().map(has_report).collect::<Vec<_>>(),
    });
    let data = serde_json::to_string(&data).map_err(|e| JobError::Internal(e.to_string()))?;
    // No tag begins in it.
    let data = data.replace('<', "\\u003c");
    let title = escaped(title);
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{BODY}\
         <script type=\"application/json\" id=\"study\">{data}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_holds_every_row_and_nothing_that_could_be_markup() {
        let row = json!({ "in:surface": "</script><b>.obj", "out:panels": 97, "key": "k" });
        let rows = [row.as_object().unwrap().clone()];
        let page = page("<i>", &rows, Path::new("/nowhere")).unwrap();
        assert!(page.contains("<title>&lt;i&gt;</title>"));
        assert_eq!(
            page.matches("</script>").count(),
            2,
            "one for the data, one for the program"
        );
        assert!(page.contains("\\u003c/script>\\u003cb>.obj"));
        for outside in ["http://", "https://"] {
            let own = page.replace("http://www.w3.org/2000/svg", "");
            assert!(!own.contains(outside), "nothing is loaded from {outside}");
        }
    }
}
