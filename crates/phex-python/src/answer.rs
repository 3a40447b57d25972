//! What a computation hands to Python: named parts, each in one of a few forms.

use crate::arrays;
use crate::kept::Kept;
use numpy::PyArray1;
use phex_job::JobError;
use phex_mesh::{PolygonSoup, Vec3};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use serde::Serialize;

/// A part of an answer.
pub enum AnswerPart {
    /// Arrays `(vertices, corners, offsets)`, or nothing.
    Mesh(Option<PolygonSoup>),
    /// Several of these.
    Meshes(Vec<PolygonSoup>),
    /// A text, JSON for one.
    Text(String),
    /// An array.
    Numbers(Vec<f64>),
    /// Bytes of a file.
    Bytes(Vec<u8>),
    /// Bytes of files, by name.
    Files(Vec<(String, Vec<u8>)>),
    /// Arrays (n, 3).
    Curves(Vec<Vec<Vec3>>),
    /// What pictures and pages are made of later.
    Kept(Box<Kept>),
}

/// A named list of parts.
pub type Answer = Vec<(&'static str, AnswerPart)>;

/// A value as JSON.
///
/// # Errors
/// If it has none, which is a bug.
pub fn json(value: &impl Serialize) -> Result<AnswerPart, JobError> {
    let text = serde_json::to_string(value).map_err(|e| JobError::Internal(e.to_string()))?;
    Ok(AnswerPart::Text(text))
}

/// The parts as a dictionary.
///
/// # Errors
/// If Python refuses one.
pub fn into_dict(py: Python<'_>, answer: Answer) -> PyResult<Py<PyDict>> {
    let dict = PyDict::new(py);
    for (name, content) in answer {
        dict.set_item(name, object(py, content)?)?;
    }
    Ok(dict.unbind())
}

fn object(py: Python<'_>, content: AnswerPart) -> PyResult<Py<PyAny>> {
    match content {
        AnswerPart::Mesh(None) => Ok(py.None()),
        AnswerPart::Mesh(Some(soup)) => arrays::arrays(py, &soup)?.into_py_any(py),
        AnswerPart::Meshes(soups) => {
            let all: PyResult<Vec<_>> = soups.iter().map(|s| arrays::arrays(py, s)).collect();
            all?.into_py_any(py)
        }
        AnswerPart::Text(text) => text.into_py_any(py),
        AnswerPart::Numbers(numbers) => PyArray1::from_vec(py, numbers).into_py_any(py),
        AnswerPart::Bytes(bytes) => PyBytes::new(py, &bytes).into_py_any(py),
        AnswerPart::Files(files) => {
            let files = files.iter().map(|(name, b)| (name, PyBytes::new(py, b)));
            PyList::new(py, files.collect::<Vec<_>>())?.into_py_any(py)
        }
        AnswerPart::Curves(curves) => {
            let all: PyResult<Vec<_>> = curves.iter().map(|c| arrays::points(py, c)).collect();
            all?.into_py_any(py)
        }
        AnswerPart::Kept(kept) => (*kept).into_py_any(py),
    }
}
