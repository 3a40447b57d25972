//! Files that are read.

use crate::error::JobError;
use phex::report::InputFile;
use phex_mesh::io::{
    Format, ReadCause, ReadError, logical_lines, other_elements, parse_soup, shown,
};
use phex_mesh::{
    EdgeId, HexMesh, LARGEST_COORDINATE, OtherElements, PolygonSoup, SurfaceNotes, SurfaceParts,
    Topology, TriangleSurface, Vec3,
};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
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
    /// What is in it beside faces, and is not read.
    pub others: OtherElements,
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
            .and_then(|format| Ok((parse_soup(bytes, format)?, other_elements(bytes, format))));
        let parsed = parsed.map_err(|e: ReadError| JobError::unusable(&e.in_file(path)));
        let (soup, others) = parsed?;
        let record = InputFile {
            path: path.display().to_string(),
            sha256: sha256(bytes),
            vertices: soup.positions.len(),
            faces: soup.faces.len(),
        };
        Ok(Self {
            path: path.to_path_buf(),
            soup,
            record,
            others,
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
        Self {
            path,
            soup,
            record,
            others: OtherElements::default(),
        }
    }

    /// The connected surfaces in the file.
    ///
    /// # Errors
    /// If the faces are no surface; the message names element and cause.
    pub fn surfaces(&self) -> Result<SurfaceParts, JobError> {
        let surfaces = TriangleSurface::from_soup(&self.soup);
        let mut surfaces = surfaces.map_err(|e| JobError::in_file(&self.path, &e))?;
        surfaces.notes.others = self.others;
        Ok(surfaces)
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
        let looks_inwards = mesh.topology().is_closed() && mesh.to_soup().volume() < 0.0;
        let notes = SurfaceNotes {
            others: self.others,
            inward_bodies: usize::from(looks_inwards),
            ..notes
        };
        Ok((mesh, notes.sentences()))
    }
}

/// SHA-256 of bytes, hexadecimal.
pub fn sha256(bytes: impl AsRef<[u8]>) -> String {
    hexadecimal(&Sha256::digest(bytes))
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

/// The text of a file, without a byte-order mark.
///
/// # Errors
/// If it can't be read, or is no text.
pub fn read_text(path: &Path) -> Result<String, JobError> {
    let mut text = std::fs::read_to_string(path).map_err(|e| JobError::in_file(path, &e))?;
    let mark = '\u{feff}';
    if text.starts_with(mark) {
        text.drain(..mark.len_utf8());
    }
    Ok(text)
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

/// The numbers of a line, separated by blanks or by commas: a line with both would be read another
/// way by those who write decimal commas.
fn numbers_of(data: &str) -> Result<Vec<f64>, String> {
    // Commas at the end of a line move no number.
    let data = data.trim_end_matches(|c: char| c == ',' || c.is_whitespace());
    let fields: Vec<&str> = data.split(',').map(str::trim).collect();
    if fields.len() > 1 && fields.contains(&"") {
        return Err("no number stands before a comma".to_owned());
    }
    let has_both = fields.len() > 1 && fields.iter().any(|f| f.contains(char::is_whitespace));
    if has_both {
        return Err(
            "commas and blanks both stand between numbers (decimals have a point: 12.5)".to_owned(),
        );
    }
    let words = fields.into_iter().flat_map(str::split_whitespace);
    words.map(number).collect()
}

/// The lines of a text file with numbers, separated by blanks or by commas; `#` begins a comment.
///
/// # Errors
/// If the file can't be read, a word is no [`number`], or a line has blanks and commas between
/// numbers.
pub fn read_numbers(path: &Path) -> Result<Vec<NumberLine>, JobError> {
    let text = read_text(path)?;
    let path: Arc<Path> = path.into();
    // A list that grew by doubling would take more than 64 bytes for each byte of short lines.
    let mut lines = Vec::with_capacity(text.lines().count());
    for (index, text) in text.lines().enumerate() {
        let (path, line) = (path.clone(), index + 1);
        let data = text.split('#').next().unwrap_or_default();
        let wrong = |e| {
            let place = format!("{}:{line}", path.display());
            JobError::input(format!("{place}: {e} in `{}`", shown(text.trim())))
        };
        let numbers = numbers_of(data).map_err(wrong)?;
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

/// The same of a file that is to hold some.
///
/// # Errors
/// As [`read_numbers`], or if no line holds any.
pub(crate) fn read_some_numbers(path: &Path) -> Result<Vec<NumberLine>, JobError> {
    let lines = read_numbers(path)?;
    match lines.is_empty() {
        false => Ok(lines),
        true => Err(JobError::input(format!(
            "{}: no line of it holds numbers",
            path.display()
        ))),
    }
}

/// The polylines of an OBJ file.
///
/// # Errors
/// If the file can't be read, or a line of it is wrong.
pub fn read_polylines(path: &Path) -> Result<Vec<Vec<Vec3>>, JobError> {
    let (mut points, mut curves) = (Vec::new(), Vec::new());
    for (number, line) in logical_lines(&read_text(path)?) {
        let bad = |e| JobError::input(format!("{}:{number}: {e}", path.display()));
        let mut words = line.split_whitespace();
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

/// Edges by the numbers of their vertices, the smaller one first.
pub fn edges_by_vertices(topology: &Topology) -> HashMap<(usize, usize), EdgeId> {
    let ends = |e| {
        let [a, b] = topology.edge_vertices(e).map(|v| v.index());
        (a.min(b), a.max(b))
    };
    topology.edges().map(|e| (ends(e), e)).collect()
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
    fn a_decimal_comma_is_no_separator() {
        for text in ["12.5 3 8", " 12.5\t3  8 ", "12.5,3,8", "12.5, 3, 8,"] {
            assert_eq!(numbers_of(text), Ok(vec![12.5, 3.0, 8.0]), "{text}");
        }
        for text in ["12,5 3 8", "12,5 3,0 8,0", "12.5 3, 8"] {
            let told = numbers_of(text).unwrap_err();
            assert!(told.contains("decimals have a point"), "{text}: {told}");
        }
        for text in ["1,2,,5", ",2,3", "1, ,3"] {
            let told = numbers_of(text).unwrap_err();
            assert_eq!(told, "no number stands before a comma", "{text}");
        }
        assert_eq!(numbers_of("1,2,3,,"), Ok(vec![1.0, 2.0, 3.0]));
        assert_eq!(numbers_of(" ,,"), Ok(vec![]), "an empty row of a table");
    }

    /// The first vertex of a file with a byte-order mark was lost, and all lines joined others.
    #[test]
    fn a_byte_order_mark_and_continued_lines_move_no_point() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines.obj");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_polylines(&path).unwrap()
        };
        let plain = read("v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3\nl 1 2\n");
        assert_eq!(plain.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2]);
        let marked = "\u{feff}v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3\nl 1 2\n";
        assert_eq!(read(marked), plain);
        let continued = "v 0 0 0\nv 1 0 0\nv 2 0 \\\n0\nl 1 \\\n2 3\nl 1 2\n";
        assert_eq!(read(continued), plain);
        std::fs::write(&path, "\u{feff}1 2\n").unwrap();
        assert_eq!(read_numbers(&path).unwrap()[0].numbers, [1.0, 2.0]);
    }

    #[test]
    fn what_a_file_holds_beside_faces_is_told() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nl 1 2 3\n";
        let file = MeshFile::from_bytes(Path::new("a.obj"), text.as_bytes()).unwrap();
        let told = "1 polyline was left out: panels are made of faces alone";
        assert_eq!(file.surfaces().unwrap().notes.sentences(), [told]);
        assert_eq!(file.sewn_polygon_mesh().unwrap().1, [told]);
        assert_eq!(crate::FileInfo::new(&file).notes, [told]);
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
