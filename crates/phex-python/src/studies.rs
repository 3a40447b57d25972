//! Requests of studies: names of folders, one variant, tables and pages.

use crate::answer::{Answer, AnswerPart, json};
use crate::inputs::Inputs;
use phex::Progress;
use phex_job::JobError;
use phex_study::{Row, SolveOptions, Variant, collect, csv, finished, keys, lost, page, solve};
use serde::Deserialize;
use std::path::PathBuf;

/// Many variants.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VariantsRequest {
    variants: Vec<Variant>,
}

/// The names of the folders of variants.
///
/// # Errors
/// If one has none.
pub fn keys_of(request: VariantsRequest, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    Ok(vec![("keys", json(&keys(&request.variants)?)?)])
}

/// A variant, its folder's folder, and how it is solved.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolveRequest {
    variant: Variant,
    out: PathBuf,
    options: SolveOptions,
}

/// One variant, solved.
///
/// # Errors
/// As [`solve`].
pub fn solved(
    request: SolveRequest,
    _: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let row = solve(&request.variant, &request.out, &request.options, progress)?;
    Ok(vec![("row", json(&row)?)])
}

/// Folders, by their names.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FinishedRequest {
    out: PathBuf,
    keys: Vec<String>,
    options: SolveOptions,
}

/// The rows of those that are finished.
///
/// # Errors
/// If the rows can't be written as JSON, which is a bug.
pub fn finished_rows(
    request: FinishedRequest,
    _: Inputs,
    _: &dyn Progress,
) -> Result<Answer, JobError> {
    let row = |key: &String| finished(&request.out, key, &request.options);
    let rows: Vec<Option<Row>> = request.keys.iter().map(row).collect();
    Ok(vec![("rows", json(&rows)?)])
}

/// A variant that was lost, and why.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LostRequest {
    variant: Variant,
    reason: String,
}

/// The row of a variant that was lost.
///
/// # Errors
/// If it has no name.
pub fn lost_row(request: LostRequest, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let row = lost(&request.variant, &request.reason)?;
    Ok(vec![("row", json(&row)?)])
}

/// A folder.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CollectRequest {
    out: PathBuf,
}

/// The rows of all finished variants.
///
/// # Errors
/// If the folder can't be read.
pub fn collected(request: CollectRequest, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let found = collect(&request.out)?;
    Ok(vec![
        ("rows", json(&found.rows)?),
        ("broken", json(&found.broken)?),
    ])
}

/// Rows, and where their folders are.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableRequest {
    title: String,
    rows: Vec<Row>,
    out: PathBuf,
}

/// Rows as CSV.
///
/// # Errors
/// If they can't be written, which is a bug.
pub fn table(request: TableRequest, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    Ok(vec![("table", AnswerPart::Text(csv(&request.rows)?))])
}

/// Rows as an HTML page.
///
/// # Errors
/// If they can't be written, which is a bug.
pub fn study_page(request: TableRequest, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let text = page(&request.title, &request.rows, &request.out)?;
    Ok(vec![("page", AnswerPart::Text(text))])
}
