//! How meshes end where their surface ends: outline, areas and angles of the panels there,
//! coverage.
//!
//! `cargo run --release -p phex --example boundary_figures -- SURFACE.obj MESH.obj ...` prints rows
//! of the tables under "Boundaries" in `docs/layout.md`; the meshes are those that `phex mesh
//! SURFACE.obj -n N --boundary snap` writes.

use phex_mesh::measure::measure;
use phex_mesh::{FaceId, HexMesh, Topology, TriangleSurface, Vec3, VertexId, boundary_fit, io};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut files = std::env::args().skip(1);
    let file = files.next().ok_or("give a surface and its meshes")?;
    let parts = TriangleSurface::from_soup(&io::read_soup(Path::new(&file))?)?;
    let surface = &parts.components[0].surface;
    println!(
        "| mesh | outline | smallest | small | spread | least angle | covered, % | distance, % | clearance |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for file in files {
        let path = Path::new(&file);
        let mesh = HexMesh::from_soup(&io::read_soup(path)?)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let row = row(&mesh, surface).ok_or("the surface or a mesh is closed")?;
        println!("| {name} | {row}");
    }
    Ok(())
}

/// The figures of a mesh; `None` if it or the surface is closed.
fn row(mesh: &HexMesh, surface: &TriangleSurface) -> Option<String> {
    let fit = boundary_fit(mesh, surface)?;
    let topology = mesh.topology();
    let outline = outline(topology, |v| mesh.position(v))
        / outline(surface.topology(), |v| surface.positions()[v]);
    let measures = measure(mesh);
    let elements = &measures.per_element;
    let rim: Vec<FaceId> = topology.boundary_faces().collect();
    let areas: Vec<f64> = rim.iter().map(|f| elements.area[*f]).collect();
    let corners = rim.iter().flat_map(|f| topology.face_half_edges(*f));
    let angles = corners.map(|h| elements.corner_angle[h].to_degrees());
    Some(format!(
        "{outline:.2} | {:.2} | {} | {:.2} | {:.0} | {:.1} | {:.2} | {:.3} |",
        fit.rim_area.min,
        fit.small.len(),
        spread(&areas),
        angles.fold(f64::INFINITY, f64::min),
        100.0 * fit.covered_area,
        100.0 * fit.distance_max(),
        measures.clearance.min,
    ))
}

/// Length of the boundary.
fn outline(topology: &Topology, place: impl Fn(VertexId) -> Vec3) -> f64 {
    let edges = topology.boundary_edges();
    let ends = edges.map(|e| topology.edge_vertices(e).map(&place));
    ends.map(|[a, b]| (b - a).norm()).sum()
}

/// Standard deviation over mean.
fn spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (squares / n).sqrt() / mean
}
