//! numpy arrays to polygons and back.

use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use phex_job::{JobError, MeshFile};
use phex_mesh::{PolygonSoup, Vec3};
use pyo3::prelude::*;

/// Corners, over all faces, that are taken: indices have 32 bits.
const MOST_CORNERS: usize = 1 << 30;

/// A mesh from Python: its name, the checksum of its file or nothing, vertices (n, 3), the numbers
/// of all faces' corners, and where each face begins in them, with the end.
pub type GivenArrays<'py> = (
    String,
    String,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, u32>,
    PyReadonlyArray1<'py, i64>,
);
/// A mesh for Python: vertices, corners, offsets.
pub type Arrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<i64>>,
);

/// A copy of a mesh from Python.
///
/// # Errors
/// If the arrays do not fit one another.
pub fn mesh_file(given: &GivenArrays<'_>) -> Result<MeshFile, JobError> {
    let (name, sha256, vertices, corners, offsets) = given;
    let soup = soup(vertices, corners, offsets)
        .map_err(|cause| JobError::Input(format!("{name}: {cause}")))?;
    let mut file = MeshFile::in_memory(name, soup);
    if !sha256.is_empty() {
        file.record.sha256.clone_from(sha256);
    }
    Ok(file)
}

fn soup(
    vertices: &PyReadonlyArray2<'_, f64>,
    corners: &PyReadonlyArray1<'_, u32>,
    offsets: &PyReadonlyArray1<'_, i64>,
) -> Result<PolygonSoup, String> {
    if vertices.shape()[1] != 3 {
        let [n, d] = [vertices.shape()[0], vertices.shape()[1]];
        return Err(format!("vertices have shape ({n}, {d}), not (n, 3)"));
    }
    if corners.len() > MOST_CORNERS {
        let count = corners.len();
        return Err(format!("{count} corners of faces, at most {MOST_CORNERS}"));
    }
    let rows = vertices.as_array();
    let point = |p: numpy::ndarray::ArrayView1<'_, f64>| Vec3::new(p[0], p[1], p[2]);
    let (corners, offsets) = (corners.as_array().to_vec(), offsets.as_array().to_vec());
    Ok(PolygonSoup {
        positions: rows.outer_iter().map(point).collect(),
        faces: faces(&corners, &offsets)?,
    })
}

fn faces(corners: &[u32], offsets: &[i64]) -> Result<Vec<Vec<u32>>, String> {
    let ends = (offsets.first().copied(), offsets.last().copied());
    let wanted = i64::try_from(corners.len()).unwrap_or(i64::MAX);
    if ends != (Some(0), Some(wanted)) {
        return Err(format!(
            "offsets go from {:?} to {:?}, not from 0 to {wanted}, the number of corners",
            ends.0, ends.1
        ));
    }
    let face = |(k, pair): (usize, &[i64])| {
        let range = usize::try_from(pair[0])
            .ok()
            .zip(usize::try_from(pair[1]).ok());
        let face = range.and_then(|(a, b)| corners.get(a..b));
        let falls = || format!("offsets fall at face {k}, from {} to {}", pair[0], pair[1]);
        face.map(<[u32]>::to_vec).ok_or_else(falls)
    };
    offsets.windows(2).enumerate().map(face).collect()
}

/// A mesh as arrays.
///
/// # Errors
/// If Python refuses them.
pub fn arrays<'py>(py: Python<'py>, soup: &PolygonSoup) -> PyResult<Arrays<'py>> {
    let mut offsets = Vec::with_capacity(soup.faces.len() + 1);
    offsets.push(0);
    let mut end = 0;
    for face in &soup.faces {
        end += face.len() as i64;
        offsets.push(end);
    }
    Ok((
        points(py, &soup.positions)?,
        PyArray1::from_vec(py, soup.faces.concat()),
        PyArray1::from_vec(py, offsets),
    ))
}

/// Points as an array (n, 3).
///
/// # Errors
/// If Python refuses it.
pub fn points<'py>(py: Python<'py>, points: &[Vec3]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    PyArray1::from_vec(py, flat).reshape([points.len(), 3])
}
