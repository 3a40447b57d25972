//! `phex info`: what is in a file, and what is wrong with it.

use super::tell;
use crate::args::InfoCommand;
use crate::exit::{Exit, Failure};
use crate::output;
use crate::summary::SummaryTable;
use anyhow::Context;
use phex_job::MeshFile;
use phex_mesh::{PolygonSoup, SurfaceParts, TriangleSurface, Vec3};
use serde::Serialize;
use std::collections::{BTreeMap, HashSet};

/// How many components the table lists; JSON holds all of them.
const LISTED: usize = 10;

/// What is known about a file.
#[derive(Clone, Debug, Serialize)]
struct FileInfo {
    path: String,
    sha256: String,
    vertices: usize,
    faces: usize,
    /// Number of faces by their number of corners.
    face_sizes: BTreeMap<usize, usize>,
    /// Corners of the bounding box.
    bounding_box: [[f64; 3]; 2],
    diagonal: f64,
    edge_length_min: f64,
    edge_length_mean: f64,
    edge_length_max: f64,
    /// The connected surfaces, or nothing if there is a problem.
    components: Vec<ComponentInfo>,
    area: Option<f64>,
    /// What would be repaired.
    notes: Vec<String>,
    /// Why the file is no surface.
    problem: Option<String>,
}

/// A connected surface.
#[derive(Clone, Debug, Serialize)]
struct ComponentInfo {
    vertices: usize,
    triangles: usize,
    boundary_loops: usize,
    euler_characteristic: i64,
    genus: i64,
    area: f64,
}

/// Runs the command.
///
/// # Errors
/// If the file can't be read, or standard output can't be written.
pub fn run(command: &InfoCommand) -> Result<Exit, Failure> {
    let file = MeshFile::read(&command.input)?;
    let info = FileInfo::new(&file);
    if command.json {
        let json = serde_json::to_string_pretty(&info).context("the information")?;
        output::print(&(json + "\n"))?;
    } else {
        tell(command.talk.quiet, &info.table())?;
    }
    Ok(if info.problem.is_some() {
        Exit::InputUnusable
    } else {
        Exit::Success
    })
}

impl FileInfo {
    fn new(file: &MeshFile) -> Self {
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
        };
        for face in &soup.faces {
            *info.face_sizes.entry(face.len()).or_default() += 1;
        }
        match TriangleSurface::from_soup(soup) {
            Ok(parts) => info.add_surface(&parts),
            Err(error) => info.problem = Some(error.to_string()),
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

    fn table(&self) -> String {
        let mut table = SummaryTable::default();
        table.row("file", &self.path);
        table.row("vertices", self.vertices);
        table.row("faces", self.faces_by_size());
        let [low, high] = self.bounding_box;
        table.row(
            "box",
            format!("{low:?} to {high:?}, diagonal {}", self.diagonal),
        );
        let [min, mean, max] = [
            self.edge_length_min,
            self.edge_length_mean,
            self.edge_length_max,
        ];
        table.row(
            "edges",
            format!("from {min:.4e} to {max:.4e}, mean {mean:.4e}"),
        );
        if let Some(area) = self.area {
            table.row("area", area);
            table.row("components", self.components.len());
        }
        for component in self.components.iter().take(LISTED) {
            table.row("surface", component.sentence());
        }
        if self.components.len() > LISTED {
            table.row(
                "surface",
                format!("and {} more", self.components.len() - LISTED),
            );
        }
        for note in &self.notes {
            table.row("note", note);
        }
        if let Some(problem) = &self.problem {
            table.row("PROBLEM", problem);
        }
        table.into_text()
    }

    fn faces_by_size(&self) -> String {
        let sizes: Vec<String> = self
            .face_sizes
            .iter()
            .map(|(size, n)| format!("{n} with {size} corners"))
            .collect();
        format!("{} ({})", self.faces, sizes.join(", "))
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

    fn sentence(&self) -> String {
        let Self {
            vertices,
            triangles,
            boundary_loops,
            genus,
            area,
            ..
        } = self;
        let boundary = match boundary_loops {
            0 => "closed".to_owned(),
            1 => "1 boundary loop".to_owned(),
            n => format!("{n} boundary loops"),
        };
        format!(
            "{vertices} vertices, {triangles} triangles, {boundary}, genus {genus}, area {area}"
        )
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
        let next = face.iter().cycle().skip(1);
        face.iter()
            .zip(next)
            .map(|(&a, &b)| (a.min(b), a.max(b)))
            .collect()
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
