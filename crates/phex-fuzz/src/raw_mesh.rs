//! A polygon mesh that promises nothing: any coordinates, any faces.

use std::fmt::Write;

/// A point or a vector.
pub type RawPoint = [f64; 3];

/// Points and faces as they come, right or wrong.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// Coordinates of the vertices; possibly not finite.
    pub points: Vec<RawPoint>,
    /// Corners of the faces, counted from 0; possibly repeated, or too few.
    pub faces: Vec<Vec<usize>>,
}

impl RawMesh {
    /// A mesh of triangles.
    pub fn triangles(points: Vec<RawPoint>, triangles: &[[usize; 3]]) -> Self {
        let faces = triangles.iter().map(|t| t.to_vec()).collect();
        Self { points, faces }
    }

    /// The vertices and faces of the text of an OBJ file.
    ///
    /// # Errors
    /// The line that is no vertex and no face of vertices before it.
    pub fn from_obj(text: &str) -> Result<Self, String> {
        let mut mesh = Self::default();
        for line in text.lines() {
            let mut words = line.split_whitespace();
            let read = match words.next() {
                Some("v") => point_of(words).map(|p| mesh.points.push(p)),
                Some("f") => face_of(words, mesh.points.len()).map(|f| mesh.faces.push(f)),
                _ => Some(()),
            };
            read.ok_or_else(|| line.to_owned())?;
        }
        Ok(mesh)
    }

    /// The text of an OBJ file.
    pub fn to_obj(&self) -> String {
        let mut text = String::new();
        for [x, y, z] in &self.points {
            writeln!(text, "v {x} {y} {z}").expect("a string takes all");
        }
        for face in &self.faces {
            let corners: String = face.iter().map(|v| format!(" {}", v + 1)).collect();
            writeln!(text, "f{corners}").expect("a string takes all");
        }
        text
    }

    /// The text of an OFF file.
    pub fn to_off(&self) -> String {
        let mut text = format!("OFF\n{} {} 0\n", self.points.len(), self.faces.len());
        for [x, y, z] in &self.points {
            writeln!(text, "{x} {y} {z}").expect("a string takes all");
        }
        for face in &self.faces {
            let corners: String = face.iter().map(|v| format!(" {v}")).collect();
            writeln!(text, "{}{corners}", face.len()).expect("a string takes all");
        }
        text
    }

    /// The text of an ASCII PLY file.
    pub fn to_ply(&self) -> String {
        let head = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
             property double z\nelement face {}\nproperty list uint int vertex_indices\nend_header\n",
            self.points.len(),
            self.faces.len()
        );
        let off = self.to_off();
        let rows = off.lines().skip(2).map(|line| format!("{line}\n"));
        head + &rows.collect::<String>()
    }

    /// A binary STL file: corners in single precision, faces fanned from their first corner.
    pub fn to_stl(&self) -> Vec<u8> {
        let fan = |f: &Vec<usize>| -> Vec<[usize; 3]> {
            let sides = f.windows(2).skip(1);
            sides.map(|s| [f[0], s[0], s[1]]).collect()
        };
        let triangles: Vec<[usize; 3]> = self.faces.iter().flat_map(fan).collect();
        let mut bytes = vec![b' '; 80];
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            let coordinates = triangle.iter().flat_map(|&v| self.points[v]);
            bytes.extend(coordinates.flat_map(|x| (x as f32).to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    /// The same with moved points.
    pub fn mapped(mut self, map: impl FnMut(RawPoint) -> RawPoint) -> Self {
        self.points = self.points.into_iter().map(map).collect();
        self
    }

    /// The parts of both meshes side by side, not joined.
    pub fn beside(mut self, other: &Self) -> Self {
        let first = self.points.len();
        self.points.extend(&other.points);
        let shifted = |f: &Vec<usize>| f.iter().map(|v| v + first).collect();
        self.faces.extend(other.faces.iter().map(shifted));
        self
    }

    /// The same without vertices that no face names.
    pub fn without_unused(self) -> Self {
        let mut number = vec![usize::MAX; self.points.len()];
        self.faces.iter().flatten().for_each(|&v| number[v] = 0);
        let mut points = Vec::new();
        for (n, p) in number.iter_mut().zip(self.points).filter(|(n, _)| **n == 0) {
            *n = points.len();
            points.push(p);
        }
        let renumbered = |f: &Vec<usize>| f.iter().map(|&v| number[v]).collect();
        let faces = self.faces.iter().map(renumbered).collect();
        Self { points, faces }
    }
}

fn point_of<'a>(words: impl Iterator<Item = &'a str>) -> Option<RawPoint> {
    let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).collect();
    numbers.get(..3)?.try_into().ok()
}

fn face_of<'a>(mut words: impl Iterator<Item = &'a str>, vertices: usize) -> Option<Vec<usize>> {
    let corner = |w: &'a str| {
        let number: usize = w.split('/').next()?.parse().ok()?;
        (1..=vertices).contains(&number).then(|| number - 1)
    };
    words.try_fold(Vec::new(), |mut face, word| {
        face.push(corner(word)?);
        Some(face)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_of_an_obj_file_is_read_back() {
        let points = vec![[0.0, 0.1, 1e-300], [1.0, 0.0, 0.0], [0.0, 1.0, -2.5]];
        let mesh = RawMesh::triangles(points, &[[0, 1, 2], [2, 1, 0]]);
        assert_eq!(RawMesh::from_obj(&mesh.to_obj()), Ok(mesh));
        assert!(RawMesh::from_obj("v 0 0 0\nf 1 2 3\n").is_err());
        assert!(RawMesh::from_obj("v 0 zero 0\n").is_err());
    }
}
