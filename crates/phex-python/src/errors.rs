//! Errors as Python raises them.

use phex_job::JobError;
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(phex._errors, InputError);
import_exception!(phex._errors, NoValidResult);
import_exception!(phex._errors, Cancelled);
import_exception!(phex._errors, InternalError);

/// The exception of an error.
pub fn raised(error: JobError) -> PyErr {
    let told = error.to_string();
    match error {
        JobError::Input(_) => InputError::new_err(told),
        JobError::NoResult(_) => NoValidResult::new_err(told),
        JobError::Cancelled => Cancelled::new_err("the computation was stopped"),
        JobError::Internal(_) => InternalError::new_err(told),
    }
}
