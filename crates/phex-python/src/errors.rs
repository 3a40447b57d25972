//! Errors as Python raises them.

use phex_job::JobError;
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(phex._errors, InputError);
import_exception!(phex._errors, NoValidResult);
import_exception!(phex._errors, Cancelled);
import_exception!(phex._errors, InternalError);

/// Options of the program in a message as the keywords that they are here: `--edge-length` is
/// `edge_length`.
fn with_keywords(told: &str) -> String {
    let is_of_name = |c: char| c.is_ascii_lowercase() || c == '-';
    let mut parts = told.split("--");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|c| !is_of_name(c)).unwrap_or(part.len());
        let (name, rest) = part.split_at(end);
        let is_option = name.starts_with(|c: char| c.is_ascii_lowercase());
        if is_option {
            text.push_str(&name.replace('-', "_"));
        } else {
            text.push_str("--");
            text.push_str(name);
        }
        text.push_str(rest);
    }
    text
}

/// The exception of an error.
pub fn raised(error: JobError) -> PyErr {
    let told = with_keywords(&error.to_string());
    match error {
        JobError::Input(_) => InputError::new_err(told),
        JobError::NoResult(_) => NoValidResult::new_err(told),
        JobError::Cancelled => Cancelled::new_err("the computation was stopped"),
        JobError::Internal(_) => InternalError::new_err(told),
    }
}
