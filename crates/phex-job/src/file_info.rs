//! What is in a file, and what is wrong with it.

use crate::input::MeshFile;
use crate::units::Unit;
use phex_mesh::polygon::sides;
use phex_mesh::{
    FaceId, PolygonSoup, SurfaceError, SurfaceParts, TopologyError, TriangleSurface, Vec3, VertexId,
};
use serde::Serialize;
use std::collections::{BTreeMap, HashSet};

/// What is known about a file; lengths in model units.
#[derive(Clone, Debug, Serialize)]
pub struct FileInfo {
    /// Path as it was given.
    pub path: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of faces by their number of corners.
    pub face_sizes: BTreeMap<usize, usize>,
    /// Corners of the bounding box.
    pub bounding_box: [[f64; 3]; 2],
    /// Length of the diagonal of the bounding box.
    pub diagonal: f64,
    /// Shortest side of a face.
    pub edge_length_min: f64,
    /// Mean length of a side.
    pub edge_length_mean: f64,
    /// Longest side.
    pub edge_length_max: f64,
    /// The connected surfaces, or nothing if there is a problem.
    pub components: Vec<ComponentInfo>,
    /// Area; nothing if there is a problem.
    pub area: Option<f64>,
    /// What would be repaired.
    pub notes: Vec<String>,
    /// Why the file is no surface.
    pub problem: Option<String>,
    /// Where the problem is: its vertices, or the middles of its faces where it names none.
    pub problem_at: Vec<[f64; 3]>,
    /// Where the problem is: faces by their numbers in the file, and points.
    #[serde(skip)]
    pub place: ProblemPlace,
}

/// A connected surface.
#[derive(Clone, Debug, Serialize)]
pub struct ComponentInfo {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of closed curves that bound it.
    pub boundary_loops: usize,
    /// Vertices minus edges plus faces.
    pub euler_characteristic: i64,
    /// Number of handles.
    pub genus: i64,
    /// Area; nothing if there is a problem.
    pub area: f64,
}

/// Where a file is no surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProblemPlace {
    /// Faces that take part.
    pub faces: Vec<usize>,
    /// Vertices that take part.
    pub vertices: Vec<usize>,
}

impl ProblemPlace {
    fn of(error: &SurfaceError, soup: &PolygonSoup) -> Self {
        let mut place = Self::default();
        place.add(error);
        place.faces.retain(|&f| f < soup.faces.len());
        place.vertices.retain(|&v| v < soup.positions.len());
        place
    }

    /// The vertices, or the middles of the faces where there are none; those that are anywhere.
    fn points(&self, soup: &PolygonSoup) -> Vec<[f64; 3]> {
        let at = |v: usize| soup.positions.get(v).copied().unwrap_or_default();
        let middle = |f: &usize| {
            let corners = &soup.faces[*f];
            let sum: Vec3 = corners.iter().map(|&v| at(v as usize)).sum();
            sum / corners.len().max(1) as f64
        };
        let points: Vec<Vec3> = match self.vertices.is_empty() {
            true => self.faces.iter().map(middle).collect(),
            false => self.vertices.iter().map(|&v| at(v)).collect(),
        };
        let finite = |p: &Vec3| p.iter().all(|x| x.is_finite());
        points.into_iter().filter(finite).map(Into::into).collect()
    }

    fn add(&mut self, error: &SurfaceError) {
        match error {
            SurfaceError::NonFinite { vertex } => self.vertices.push(vertex.index()),
            SurfaceError::Topology(error) => self.add_topology(error),
            SurfaceError::NotOrientable {
                from,
                to,
                first,
                second,
            } => self.add_edge([*from, *to], &[*first, *second]),
            SurfaceError::NotSimple { faces } | SurfaceError::ZeroArea { faces } => {
                self.faces.extend(faces.iter().map(|f| f.index()));
            }
            // The extent of the whole, say, has no place.
            _ => {}
        }
    }

    fn add_edge(&mut self, ends: [VertexId; 2], faces: &[FaceId]) {
        self.vertices.extend(ends.map(VertexId::index));
        self.faces.extend(faces.iter().map(|f| f.index()));
    }

    fn add_topology(&mut self, error: &TopologyError) {
        match error {
            TopologyError::TooFewCorners { face, .. }
            | TopologyError::IndexOutOfRange { face, .. } => self.faces.push(face.index()),
            TopologyError::RepeatedVertex { face, vertex } => {
                self.faces.push(face.index());
                self.vertices.push(vertex.index());
            }
            TopologyError::DoubledTriangle { first, second } => {
                self.faces.extend([first.index(), second.index()]);
            }
            TopologyError::NonManifoldEdge { from, to, faces } => {
                self.add_edge([*from, *to], faces);
            }
            TopologyError::InconsistentOrientation {
                from,
                to,
                first,
                second,
            } => self.add_edge([*from, *to], &[*first, *second]),
            TopologyError::BowTieVertex { vertex } | TopologyError::UnusedVertex { vertex } => {
                self.vertices.push(vertex.index());
            }
            _ => {}
        }
    }
}

impl FileInfo {
    /// Looks at a file.
    pub fn new(file: &MeshFile) -> Self {
        let soup = &file.soup;
        let (low, high) = bounding_box(soup);
        let lengths = edge_lengths(soup);
        let mut info = Self {
            path: file.record.path.clone(),
            sha256: file.record.sha256.clone(),
            vertices: file.record.vertices,
            faces: file.record.faces,
            face_sizes: BTreeMap::new(),
            bounding_box: [low.into(), high.into()],
            diagonal: (high - low).norm(),
            edge_length_min: lengths.iter().copied().fold(f64::INFINITY, f64::min),
            edge_length_mean: lengths.iter().sum::<f64>() / lengths.len() as f64,
            edge_length_max: lengths.iter().copied().fold(0.0, f64::max),
            components: Vec::new(),
            area: None,
            notes: Vec::new(),
            problem: None,
            problem_at: Vec::new(),
            place: ProblemPlace::default(),
        };
        for face in &soup.faces {
            *info.face_sizes.entry(face.len()).or_default() += 1;
        }
        match TriangleSurface::from_soup(soup) {
            Ok(mut parts) => {
                parts.notes.others = file.others;
                info.add_surface(&parts);
            }
            Err(error) => {
                info.problem = Some(error.to_string());
                info.place = ProblemPlace::of(&error, soup);
                info.problem_at = info.place.points(soup);
            }
        }
        info
    }

    fn add_surface(&mut self, parts: &SurfaceParts) {
        self.components = parts
            .components
            .iter()
            .map(|c| ComponentInfo::new(&c.surface))
            .collect();
        self.area = Some(self.components.iter().map(|c| c.area).sum());
        self.notes = parts.notes.sentences();
    }
}

impl ComponentInfo {
    fn new(surface: &TriangleSurface) -> Self {
        let topology = surface.topology();
        let boundary_loops = topology.boundary_loops().len();
        let euler_characteristic = topology.euler_characteristic();
        Self {
            vertices: topology.n_vertices(),
            triangles: topology.n_faces(),
            boundary_loops,
            euler_characteristic,
            genus: (2 - boundary_loops as i64 - euler_characteristic) / 2,
            area: surface.area(),
        }
    }
}

impl MeshFile {
    /// What is said of a model whose size in a unit is no building's, see [`Unit::doubted`].
    pub fn doubted(&self, unit: Unit) -> Option<String> {
        let (low, high) = bounding_box(&self.soup);
        unit.doubted((high - low).norm())
    }
}

fn bounding_box(soup: &PolygonSoup) -> (Vec3, Vec3) {
    let first = soup.positions.first().copied().unwrap_or_default();
    soup.positions
        .iter()
        .fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Length of each edge once.
fn edge_lengths(soup: &PolygonSoup) -> Vec<f64> {
    let sides = |face: &Vec<u32>| -> Vec<(u32, u32)> {
        sides(face).map(|[a, b]| (a.min(b), a.max(b))).collect()
    };
    let mut seen = HashSet::new();
    let edges = soup
        .faces
        .iter()
        .flat_map(sides)
        .filter(move |edge| seen.insert(*edge));
    let at = |v: u32| soup.positions.get(v as usize).copied().unwrap_or_default();
    edges.map(|(a, b)| (at(a) - at(b)).norm()).collect()
}
