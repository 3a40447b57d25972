//! What can be asked for: each kind has a struct of options, read from JSON, and a function.

use crate::answer::{Answer, AnswerPart, json};
use crate::errors::raised;
use crate::inputs::Inputs;
use crate::{judged, offsets, pictures, studies, workshop};
use phex::Progress;
use phex_fab::PanelIds;
use phex_job::{JobError, MeshFile, Unit, chain, in_file};
use phex_mesh::io::{atomic_write, write_soup};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate_with_parameters};
use pyo3::prelude::*;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::PathBuf;

/// A computation that is ready to run.
pub type Work = Box<dyn FnOnce(&dyn Progress) -> Result<Answer, JobError> + Send>;

/// The work that a request asks for.
///
/// # Errors
/// If there is no such request, or an option of it is wrong.
pub fn work(what: &str, request: &str, inputs: Inputs) -> Result<Work, JobError> {
    match what {
        "mesh" => bound(request, inputs, judged::mesh),
        "planarize" => bound(request, inputs, judged::planarized),
        "check" => bound(request, inputs, judged::checked),
        "koebe" => bound(request, inputs, judged::koebe_mesh),
        "parallel" => bound(request, inputs, judged::parallel),
        "offset" => bound(request, inputs, offsets::offset),
        "fabricate" => bound(request, inputs, workshop::fabricated),
        "lengths" => bound(request, inputs, offsets::lengths),
        "network" => bound(request, inputs, offsets::network),
        "values" => bound(request, inputs, pictures::values),
        "picture" => bound(request, inputs, pictures::picture),
        "page" => bound(request, inputs, pictures::html),
        "ears" => bound(request, inputs, pictures::ears),
        "keys" => bound(request, inputs, studies::keys_of),
        "solve" => bound(request, inputs, studies::solved),
        "finished" => bound(request, inputs, studies::finished_rows),
        "lost" => bound(request, inputs, studies::lost_row),
        "collect" => bound(request, inputs, studies::collected),
        "table" => bound(request, inputs, studies::table),
        "study-page" => bound(request, inputs, studies::study_page),
        "names" => bound(request, inputs, names),
        "read" => bound(request, inputs, read),
        "write" => bound(request, inputs, write),
        "outputs" => bound(request, inputs, judged::check_outputs),
        "shapes" => bound(request, inputs, shapes),
        "shape" => bound(request, inputs, shape),
        _ => Err(JobError::Internal(format!("no request is called {what}"))),
    }
}

fn bound<R: DeserializeOwned + Send + 'static>(
    request: &str,
    inputs: Inputs,
    work: fn(R, Inputs, &dyn Progress) -> Result<Answer, JobError>,
) -> Result<Work, JobError> {
    let request: R = serde_json::from_str(request).map_err(|e| JobError::Input(located(&e)))?;
    Ok(Box::new(move |progress| work(request, inputs, progress)))
}

/// A parser's message without the place in a text that nobody sees.
fn located(error: &serde_json::Error) -> String {
    let told = error.to_string();
    told.split(" at line ").next().unwrap_or(&told).to_owned()
}

/// No options.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

/// A file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    path: PathBuf,
}

fn read(place: Place, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let file = MeshFile::read(&place.path)?;
    Ok(vec![
        ("sha256", AnswerPart::Text(file.record.sha256)),
        ("mesh", AnswerPart::Mesh(Some(file.soup))),
    ])
}

/// A file to write.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WriteRequest {
    path: PathBuf,
    /// That of the coordinates.
    unit: Unit,
}

fn write(request: WriteRequest, inputs: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let WriteRequest { path, unit } = request;
    let written = write_soup(&path, &in_file(&path, &inputs.first()?.soup, unit));
    written.map_err(|e| JobError::Input(chain(&e)))?;
    Ok(Answer::new())
}

/// Writes a file whole or not at all.
#[pyfunction]
pub fn write_whole(py: Python<'_>, path: PathBuf, content: &[u8]) -> PyResult<()> {
    let written = py.detach(|| atomic_write(&path, |out| out.write_all(content)));
    written.map_err(|e| raised(JobError::Input(chain(&e))))
}

/// The names of a mesh's panels, as in the workshop's files.
fn names(_: Nothing, inputs: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let names = PanelIds::new(&inputs.panels()?).into_names();
    let names = json!(names).to_string();
    Ok(vec![("names", AnswerPart::Text(names))])
}

fn shapes(_: Nothing, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let parameter = |p: &phex_mesh::shapes::ShapeParameter| json!({ "name": p.name, "default": p.default, "min": p.min, "max": p.max, "meaning": p.meaning });
    let entry = |s: &phex_mesh::shapes::ShapeInfo| {
        let parameters: Vec<Value> = s.parameters.iter().map(parameter).collect();
        json!({ "name": s.name, "summary": s.summary, "parameters": parameters })
    };
    let all: Vec<Value> = Shape::all().iter().map(entry).collect();
    Ok(vec![("shapes", json(&all)?)])
}

/// A built-in surface.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapeRequest {
    name: String,
    parameters: Vec<(String, f64)>,
    options: TriangulationOptions,
}

fn shape(request: ShapeRequest, _: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let unusable = |e: phex_mesh::shapes::ShapeError| JobError::Input(chain(&e));
    let parameters = request.parameters.iter();
    let parameters: Vec<(&str, f64)> = parameters.map(|(name, x)| (name.as_str(), *x)).collect();
    let shape = Shape::from_name(&request.name, &parameters).map_err(unusable)?;
    let made = triangulate_with_parameters(&shape, &request.options).map_err(unusable)?;
    Ok(vec![("mesh", AnswerPart::Mesh(Some(made.to_soup())))])
}
