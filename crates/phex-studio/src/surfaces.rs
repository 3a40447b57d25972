//! Surfaces that were dropped.

use crate::frames::frame;
use axum::body::Bytes;
use phex_html::{MeshData, PackedArray, PackedSurface, numbers, points};
use phex_job::{FileInfo, JobError, MeshFile, MeshJob, MeshSettings, ProblemPlace};
use phex_mesh::io::{Format, write_soup_to};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{PolygonSoup, Vec3, polygon};
use serde::Serialize;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

/// How many surfaces are kept; what was not used for longest goes first.
const KEPT: usize = 3;
/// Characters of a file's name that are kept.
const LONGEST_NAME: usize = 100;

/// A file that was dropped.
pub struct DroppedSurface {
    /// The first digits of the checksum of its bytes.
    pub id: String,
    /// Its name, without folders.
    pub name: String,
    /// What the page is told of it.
    pub told: Bytes,
    /// Where coordinates that the page is told have their origin, model units.
    pub origin: Vec3,
    /// A job on it without wishes, or what is wrong with it. Copies of the job share what was
    /// computed.
    pub job: Result<MeshJob, String>,
}

/// What the page is told of a surface.
#[derive(Serialize)]
struct ToldSurface<'a> {
    id: &'a str,
    name: &'a str,
    info: &'a FileInfo,
    origin: [f64; 3],
    /// The triangles, thinned out where they are many.
    surface: Option<PackedSurface>,
    /// The polygons where they are no surface, with what is wrong.
    broken: Option<Broken>,
}

#[derive(Serialize)]
struct Broken {
    mesh: MeshData,
    /// Sides of the faces that are named in the problem, as pairs of points.
    sides: PackedArray,
    /// Vertices that are named.
    points: PackedArray,
}

impl DroppedSurface {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// If the reader refuses them, in its words. A file that can be read and is no surface is none.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, JobError> {
        let name = plain_name(name);
        let file = MeshFile::from_bytes(Path::new(&name), bytes)?;
        let info = FileInfo::new(&file);
        let id = file.record.sha256[..16].to_owned();
        let origin = middle(&info);
        let parts = file.surfaces();
        let told = ToldSurface {
            id: &id,
            name: &name,
            info: &info,
            origin: origin.into(),
            surface: (parts.as_ref().ok()).map(|parts| PackedSurface::new(&parts.whole(), origin)),
            broken: (parts.is_err()).then(|| Broken::new(&file.soup, &info.place, origin)),
        };
        let told = frame(&told);
        let job = match parts {
            Ok(parts) => Ok(MeshJob::new(parts, file.record, MeshSettings::default())),
            Err(error) => Err(error.to_string()),
        };
        Ok(Self {
            id,
            name,
            told,
            origin,
            job,
        })
    }

    /// A built-in surface, as `phex shape` writes it.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn sample(name: &str) -> Result<Self, JobError> {
        let shape = Shape::from_name(name, &[]).map_err(JobError::input)?;
        let surface = triangulate(&shape, &TriangulationOptions::default());
        let surface = surface.map_err(JobError::input)?;
        let mut bytes = Vec::new();
        write_soup_to(&mut bytes, &surface.to_soup(), Format::Obj).map_err(JobError::input)?;
        Self::read(&format!("{name}.obj"), &bytes)
    }
}

/// Names of the built-in surfaces, with a sentence; the free-form roof first.
pub fn samples() -> Vec<[&'static str; 2]> {
    let mut samples: Vec<_> = (Shape::all().iter())
        .map(|shape| [shape.name, shape.summary])
        .collect();
    samples.sort_by_key(|[name, _]| *name != "roof");
    samples
}

/// A name without folders and of a sensible length; the extension stays.
fn plain_name(name: &str) -> String {
    let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let clean: String = last.chars().filter(|c| !c.is_control()).collect();
    let skipped = clean.chars().count().saturating_sub(LONGEST_NAME);
    clean.chars().skip(skipped).collect()
}

/// Middle of the bounding box, where it has one.
fn middle(info: &FileInfo) -> Vec3 {
    let [low, high] = info.bounding_box.map(Vec3::from);
    let middle = low / 2.0 + high / 2.0;
    match middle.iter().all(|x| x.is_finite()) {
        true => middle,
        false => Vec3::zeros(),
    }
}

impl Broken {
    fn new(soup: &PolygonSoup, place: &ProblemPlace, origin: Vec3) -> Self {
        let can_be_drawn = |face: &&Vec<u32>| {
            let finite = |&v: &u32| {
                let p = soup.positions.get(v as usize);
                p.is_some_and(|p| p.iter().all(|x| x.is_finite()))
            };
            face.len() > 2 && face.iter().all(finite)
        };
        let drawn = PolygonSoup {
            positions: soup.positions.clone(),
            faces: soup.faces.iter().filter(can_be_drawn).cloned().collect(),
        };
        let named = place.faces.iter().map(|&f| &soup.faces[f]);
        let ends = (named.filter(can_be_drawn)).flat_map(|face| polygon::sides(face).flatten());
        let sides: Vec<Vec3> = ends.map(|v| soup.positions[v as usize]).collect();
        let named: Vec<Vec3> = place.vertices.iter().map(|&v| soup.positions[v]).collect();
        Self {
            mesh: MeshData::new(&drawn, origin),
            sides: points(&sides, origin),
            points: points(&named, origin),
        }
    }
}

/// The surfaces that were dropped last.
#[derive(Default)]
pub struct DroppedSurfaces(VecDeque<Arc<DroppedSurface>>);

impl DroppedSurfaces {
    /// Keeps a surface; one with the same bytes keeps what was computed.
    pub fn add(&mut self, surface: DroppedSurface) -> Arc<DroppedSurface> {
        if let Some(same) = self.find(&surface.id).filter(|s| s.name == surface.name) {
            return same;
        }
        let surface = Arc::new(surface);
        self.0.retain(|other| other.id != surface.id);
        self.0.push_front(surface.clone());
        self.0.truncate(KEPT);
        surface
    }

    /// A surface, which counts as used.
    pub fn find(&mut self, id: &str) -> Option<Arc<DroppedSurface>> {
        let at = self.0.iter().position(|s| s.id == id)?;
        let surface = self.0.remove(at)?;
        self.0.push_front(surface.clone());
        Some(surface)
    }
}

/// The numbers of a list, for the page.
pub fn listed(ids: &[usize]) -> PackedArray {
    numbers(ids.iter().map(|&id| id as u32))
}
