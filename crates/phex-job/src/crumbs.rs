//! Crumbs: small parts beside a surface, as scans and level sets leave them behind. No panels cover
//! them unless every part is asked for.

use phex_mesh::{HexMesh, TriangleSurface, VertexId, numbered};

/// Area of a part over that of the largest one below which it is a crumb.
const CRUMB: f64 = 1e-3;

/// Which parts are crumbs, by their areas.
pub(crate) fn crumbs(areas: &[f64]) -> Vec<bool> {
    let least = CRUMB * areas.iter().copied().fold(0.0, f64::max);
    areas.iter().map(|area| *area < least).collect()
}

/// What is said of crumbs that are left out; nothing if there are none.
pub(crate) fn left_out(parts: usize, triangles: usize) -> Option<String> {
    (parts > 0).then(|| {
        format!(
            "parts with less than a thousandth of the area of the largest one were left out \
             (parts: {parts}, their triangles: {triangles})"
        )
    })
}

/// What a mesh stands for of a surface: all of it if the mesh has as many parts, else what is left
/// without crumbs; and what is said of these.
///
/// ```
/// use phex_job::without_crumbs;
/// use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// use phex_mesh::{HexMesh, TriangleSurface, Vec3};
///
/// let sphere = triangulate(&Shape::from_name("sphere", &[])?, &TriangulationOptions::default())?;
/// let mut soup = sphere.to_soup();
/// let mesh = HexMesh::new(soup.positions.clone(), &soup.faces)?;
/// let first = soup.positions.len() as u32;
/// soup.positions.extend([[9.0, 0.0, 0.0], [9.01, 0.0, 0.0], [9.0, 0.01, 0.0]].map(Vec3::from));
/// soup.faces.push(vec![first, first + 1, first + 2]);
/// let triangles: Vec<[u32; 3]> = soup.faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
/// let scan = TriangleSurface::new(soup.positions, &triangles)?;
/// let (covered, said) = without_crumbs(scan, &mesh);
/// assert_eq!(covered.topology().n_faces(), sphere.topology().n_faces());
/// assert!(said.unwrap().contains("(parts: 1, their triangles: 1)"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn without_crumbs(
    surface: TriangleSurface,
    mesh: &HexMesh,
) -> (TriangleSurface, Option<String>) {
    let topology = surface.topology();
    let (part, parts) = topology.components();
    if parts <= mesh.topology().components().1 {
        return (surface, None);
    }
    let mut areas = vec![0.0; parts];
    for f in topology.faces() {
        areas[part[f] as usize] += surface.face_area(f);
    }
    let is_crumb = crumbs(&areas);
    let kept = topology.faces().filter(|f| !is_crumb[part[*f] as usize]);
    let (vertices, faces) = numbered(kept.map(|f| topology.face_vertices(f).iter().copied()));
    let left = topology.n_faces() - faces.len();
    let said = left_out(is_crumb.iter().filter(|crumb| **crumb).count(), left);
    let place = |v: &VertexId| surface.positions()[*v];
    let triangles: Vec<[u32; 3]> = faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
    match TriangleSurface::new(vertices.iter().map(place).collect(), &triangles) {
        Ok(covered) if said.is_some() => (covered, said),
        _ => (surface, None),
    }
}
