//! The compiled part of the Python package `phex`: arrays in, one computation on threads of its
//! own, arrays out. Everything that people see is in `python/src/phex`.
//!
//! | module | what it does |
//! |---|---|
//! | `arrays` | numpy arrays to meshes and back |
//! | `requests` | what can be asked for, and what answers it |
//! | `judged`, `offsets`, `pictures`, `workshop`, `studies` | the answers |
//! | `kept` | what is kept between requests |
//! | `computation` | a thread that computes while the caller's waits without the interpreter's lock |

mod answer;
mod arrays;
mod computation;
mod errors;
mod inputs;
mod judged;
mod kept;
mod offsets;
mod pictures;
mod requests;
mod studies;
mod workshop;

/// The compiled part of phex.
#[pyo3::pymodule]
mod _phex {
    #[pymodule_export]
    use crate::computation::{Computation, start};
    #[pymodule_export]
    use crate::kept::{Kept, KeptSurface};
    #[pymodule_export]
    use crate::requests::write_whole;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
