//! Files that are read.

use crate::error::JobError;
use phex::report::InputFile;
use phex_mesh::io::{Format, ReadCause, ReadError, parse_soup, shown};
use phex_mesh::{
    HexMesh, LARGEST_COORDINATE, PolygonSoup, SurfaceNotes, SurfaceParts, TriangleSurface, Vec3,
};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh file: its elements, and what the report says about it.
pub struct MeshFile {
    /// Where it is.
    pub path: PathBuf,
    /// Vertices and faces as they stand in it.
    pub soup: PolygonSoup,
    /// Path, hash and counts.
    pub record: InputFile,
}

impl MeshFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If the extension is unknown, the file can't be read or holds no mesh.
    pub fn read(path: &Path) -> Result<Self, JobError> {
        let bytes = Format::from_path(path)
            .map_err(ReadCause::from)
            .and_then(|_| std::fs::read(path).map_err(ReadCause::from))
            .map_err(|e| JobError::unusable(&ReadError::from(e).in_file(path)))?;
        Self::from_bytes(path, &bytes)
    }

    /// The bytes of a file; its name says what they are, and nothing is read from there.
    ///
    /// # Errors
    /// If the extension is unknown, or the bytes hold no mesh.
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, JobError> {
        let parsed = Format::from_path(path)
            .map_err(|e| ReadCause::from(e).into())
            .and_then(|format| parse_soup(bytes, format));
        let soup = parsed.map_err(|e: ReadError| JobError::unusable(&e.in_file(path)))?;
        let record = InputFile {
            path: path.display().to_string(),
            sha256: hexadecimal(&Sha256::digest(bytes)),
            vertices: soup.positions.len(),
            faces: soup.faces.len(),
        };
        Ok(Self {
            path: path.to_path_buf(),
            soup,
            record,
        })
    }

    /// Elements that were never a file; the report tells their name and the checksum of their
    /// bytes, numbers little-endian.
    pub fn in_memory(name: &str, soup: PolygonSoup) -> Self {
        let mut digest = Sha256::new();
        for p in &soup.positions {
            p.iter().for_each(|x| digest.update(x.to_le_bytes()));
        }
        for face in &soup.faces {
            digest.update((face.len() as u64).to_le_bytes());
            face.iter().for_each(|v| digest.update(v.to_le_bytes()));
        }
        let record = InputFile {
            path: name.to_owned(),
            sha256: hexadecimal(&digest.finalize()),
            vertices: soup.positions.len(),
            faces: soup.faces.len(),
        };
        let path = PathBuf::from(name);
        Self { path, soup, record }
    }

    /// The connected surfaces in the file.
    ///
    /// # Errors
    /// If the faces are no surface; the message names element and cause.
    pub fn surfaces(&self) -> Result<SurfaceParts, JobError> {
        let surfaces = TriangleSurface::from_soup(&self.soup);
        surfaces.map_err(|e| JobError::in_file(&self.path, &e))
    }

    /// All connected surfaces in the file as one.
    ///
    /// # Errors
    /// As [`surfaces`](Self::surfaces).
    pub fn surface(&self) -> Result<TriangleSurface, JobError> {
        Ok(self.surfaces()?.whole())
    }

    /// The file's faces as a polygon mesh, and the number of vertices that no face uses and that
    /// were left out.
    ///
    /// # Errors
    /// If the faces are no oriented manifold; the message names element and cause.
    pub fn polygon_mesh(&self) -> Result<(HexMesh, usize), JobError> {
        let used = self.soup.without_unused_vertices();
        let dropped = self.soup.positions.len() - used.positions.len();
        let mesh = HexMesh::from_soup(&used).map_err(|e| JobError::in_file(&self.path, &e))?;
        Ok((mesh, dropped))
    }

    /// As [`polygon_mesh`](Self::polygon_mesh), with faces sewn together that lie side by side and
    /// share no vertices, as far as that makes a mesh; and what was done, as sentences.
    ///
    /// # Errors
    /// As [`polygon_mesh`](Self::polygon_mesh).
    pub fn sewn_polygon_mesh(&self) -> Result<(HexMesh, Vec<String>), JobError> {
        let sewn = self.soup.sewn();
        let sewn = sewn.and_then(|(soup, notes)| Some((HexMesh::from_soup(&soup).ok()?, notes)));
        let (mesh, notes) = match sewn {
            Some(sewn) => sewn,
            None => {
                let (mesh, unused_vertices) = self.polygon_mesh()?;
                let notes = SurfaceNotes {
                    unused_vertices,
                    ..SurfaceNotes::default()
                };
                (mesh, notes)
            }
        };
        let looks_inwards =
            mesh.topology().boundary_loops().is_empty() && mesh.to_soup().volume() < 0.0;
        let notes = SurfaceNotes {
            inward_bodies: usize::from(looks_inwards),
            ..notes
        };
        Ok((mesh, notes.sentences()))
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A number as it is typed or stands in a file.
///
/// # Errors
/// If it is none, is not finite, or is larger than any coordinate that is computed with.
pub fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(x) if x.abs() <= LARGEST_COORDINATE => Ok(x),
        Ok(x) if x.is_finite() => Err(format!(
            "`{}` is beyond {LARGEST_COORDINATE:e}, the largest number that is computed with",
            shown(word)
        )),
        Ok(_) => Err(format!("`{}` is not finite", shown(word))),
        Err(_) => Err(format!("`{}` is not a number", shown(word))),
    }
}

/// The text of a file.
///
/// # Errors
/// If it can't be read, or is no text.
pub fn read_text(path: &Path) -> Result<String, JobError> {
    std::fs::read_to_string(path).map_err(|e| JobError::in_file(path, &e))
}

/// A line of numbers, and where it stands.
pub struct NumberLine {
    /// The numbers.
    pub numbers: Vec<f64>,
    path: Arc<Path>,
    line: usize,
}

impl NumberLine {
    /// The line does not hold what is wanted.
    pub fn wrong(&self, wanted: &str) -> JobError {
        let (path, line) = (self.path.display(), self.line);
        JobError::input(format!("{path}:{line}: {wanted} is wanted on each line"))
    }
}

/// The lines of a text file with numbers, separated by blanks or commas; `#` begins a comment.
///
/// # Errors
/// If the file can't be read, or a word is no [`number`].
pub fn read_numbers(path: &Path) -> Result<Vec<NumberLine>, JobError> {
    let text = read_text(path)?;
    let path: Arc<Path> = path.into();
    // A list that grew by doubling would take more than 64 bytes for each byte of short lines.
    let mut lines = Vec::with_capacity(text.lines().count());
    for (index, text) in text.lines().enumerate() {
        let (path, line) = (path.clone(), index + 1);
        let data = text.split('#').next().unwrap_or_default();
        let words = data.split(|c: char| c.is_whitespace() || c == ',');
        let numbers: Result<Vec<f64>, String> =
            words.filter(|w| !w.is_empty()).map(number).collect();
        let wrong = |e| {
            let place = format!("{}:{line}", path.display());
            JobError::input(format!("{place}: {e} in `{}`", shown(text.trim())))
        };
        let numbers = numbers.map_err(wrong)?;
        if !numbers.is_empty() {
            lines.push(NumberLine {
                numbers,
                path,
                line,
            });
        }
    }
    Ok(lines)
}

/// The polylines of an OBJ file.
///
/// # Errors
/// If the file can't be read, or a line of it is wrong.
pub fn read_polylines(path: &Path) -> Result<Vec<Vec<Vec3>>, JobError> {
    let (mut points, mut curves) = (Vec::new(), Vec::new());
    for (index, line) in read_text(path)?.lines().enumerate() {
        let bad = |e| JobError::input(format!("{}:{}: {e}", path.display(), index + 1));
        let mut words = line
            .split('#')
            .next()
            .unwrap_or_default()
            .split_whitespace();
        match words.next() {
            Some("v") => points.push(point(words).map_err(bad)?),
            Some("l") => curves.push(polyline(words, &points).map_err(bad)?),
            _ => {}
        }
    }
    Ok(curves)
}

fn point<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vec3, String> {
    let numbers: Vec<f64> = words.map(number).collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y, z, ..] => Ok(Vec3::new(x, y, z)),
        _ => Err(format!(
            "a point has {} coordinates, 3 are needed",
            numbers.len()
        )),
    }
}

/// The points of a line `l`; as in faces, a texture may follow a point's number, and negative
/// numbers count backwards.
fn polyline<'a>(
    words: impl Iterator<Item = &'a str>,
    points: &[Vec3],
) -> Result<Vec<Vec3>, String> {
    let index = |w: &str| {
        let number = w
            .split('/')
            .next()
            .unwrap_or_default()
            .parse::<i64>()
            .ok()?;
        let from_start = if number < 0 {
            number + points.len() as i64
        } else {
            number - 1
        };
        points.get(usize::try_from(from_start).ok()?).copied()
    };
    let none = |w: &str| {
        let count = points.len();
        format!("`{}` is none of the {count} points so far", shown(w))
    };
    words.map(|w| index(w).ok_or_else(|| none(w))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Panels that share no vertices are one mesh, and those that touch in a point are not.
    #[test]
    fn panels_that_lie_side_by_side_are_sewn() {
        let square = |x: f64, y: f64| {
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .map(|[u, v]| Vec3::new(x + u, y + v, 0.0))
        };
        let squares = |second: [Vec3; 4]| PolygonSoup {
            positions: [square(0.0, 0.0), second].concat(),
            faces: vec![vec![0, 1, 2, 3], vec![4, 5, 6, 7]],
        };
        let mesh = |soup| {
            let file = MeshFile::in_memory("squares", soup);
            let (mesh, notes) = file.sewn_polygon_mesh().unwrap();
            (mesh.topology().n_vertices(), notes.len())
        };
        assert_eq!(mesh(squares(square(1.0, 0.0))), (6, 1));
        assert_eq!(mesh(squares(square(1.0, 1.0))), (8, 0));
    }

    #[test]
    fn unused_vertices_are_left_out_and_faces_renumbered() {
        let positions: Vec<Vec3> = (0..5).map(|i| Vec3::repeat(f64::from(i))).collect();
        let soup = PolygonSoup {
            positions,
            faces: vec![vec![4, 1, 3]],
        };
        let used = soup.without_unused_vertices();
        assert_eq!(used.faces, [[2, 0, 1]]);
        assert_eq!(used.positions, [1.0, 3.0, 4.0].map(Vec3::repeat));
    }
}
