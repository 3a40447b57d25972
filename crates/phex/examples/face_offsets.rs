//! Face offsets of many meshes, to either side, with their errors.
//!
//! `cargo run --release -p phex --example face_offsets -- MESH...` takes files of planar meshes;
//! without any the built-in surfaces are covered with panels and offset. Each line: panels, safe
//! distances in diagonals, and for offsets by half of them (a tenth of a diagonal at the most) the
//! largest error of a face's distance in diagonals, the largest height of a corner over its plane
//! in mean edges, and the estimate.

use phex::offset::{
    OffsetKind, OffsetOptions, distance_error, face_gauss_image, face_offset, layer, safe_distances,
};
use phex::{MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::measure::diagonal;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{FlatFace, HexMesh, PerFace};
use std::error::Error;

/// Largest distance, over the diagonal.
const MOST: f64 = 0.1;

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    println!("mesh  panels  safe outward, inward  distance error  planarity  estimate");
    let mut worst = [0.0f64; 3];
    let mut add = |name: &str, mesh: &HexMesh| match figures(name, mesh) {
        Ok(found) => worst.iter_mut().zip(found).for_each(|(w, f)| *w = w.max(f)),
        Err(e) => println!("{name}: {e}"),
    };
    if files.is_empty() {
        for name in Shape::all().iter().map(|info| info.name) {
            add(name, &panelled(name)?);
        }
    }
    for file in &files {
        let soup = phex_mesh::io::read_soup(file.as_ref())?;
        add(file, &HexMesh::from_soup(&soup)?);
    }
    let [distance, planarity, estimate] = worst;
    println!(
        "worst: distances {distance:.1e} diagonals, planarity {planarity:.1e} mean edges, estimate {estimate:.1e}"
    );
    Ok(())
}

fn panelled(name: &str) -> Result<HexMesh, Box<dyn Error>> {
    let surface = triangulate(
        &Shape::from_name(name, &[])?,
        &TriangulationOptions::default(),
    )?;
    let options = MeshOptions {
        size: PanelSize::Panels(300),
        ..Default::default()
    };
    Ok(mesh_surface(&surface, &options, &Silent)?.mesh)
}

/// Largest errors of distances and planarity in two offsets, and the largest estimate.
fn figures(name: &str, mesh: &HexMesh) -> Result<[f64; 3], Box<dyn Error>> {
    let options = OffsetOptions::default();
    let (size, panels) = (diagonal(mesh), mesh.topology().n_faces());
    let (_, estimate) = face_offset(mesh, &PerFace::filled(panels, 1.0), &options)?.worst();
    let image = face_gauss_image(mesh, &options)?;
    let safe = safe_distances(mesh, &image, &options);
    let [outward, inward] = [safe.outward.distance, safe.inward.distance];
    let [mut distance, mut planarity] = [0.0f64; 2];
    for d in [
        outward.min(2.0 * MOST * size) / 2.0,
        -inward.min(2.0 * MOST * size) / 2.0,
    ] {
        let moved = layer(mesh, &image, d, &options)?;
        let error = distance_error(mesh, &moved, OffsetKind::Face, d)? / size;
        let faces = FlatFace::all(&moved);
        let bent = faces.iter().map(|f| f.planarity_length).fold(0.0, f64::max);
        distance = distance.max(error);
        planarity = planarity.max(bent / moved.mean_edge());
    }
    println!(
        "{name}  {panels}  {:.4} {:.4}  {distance:.1e}  {planarity:.1e}  {estimate:.1e}",
        outward / size,
        inward / size
    );
    Ok([distance, planarity, estimate])
}
