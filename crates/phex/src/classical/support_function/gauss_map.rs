//! Whether the Gauss map is one to one.

use crate::classical::domain::LocatedVertex;
use nalgebra::Matrix3;
use phex_mesh::{FaceId, PerVertex, TriangleSurface, Vec3, VertexId};
use std::collections::HashMap;

/// How far outside a triangle of the Gauss image a normal may lie, in barycentric coordinates:
/// symmetric surfaces have vertices with equal normals, up to rounding.
const OUTSIDE: f64 = 1e-6;
/// How far apart two points must be, in mean edges of the surface, that their normals may not
/// agree.
const FAR: f64 = 4.0;

/// Pairs of far vertices, the second a corner of a triangle whose Gauss image holds the first one's
/// normal. At most one for each vertex.
pub(crate) fn shared_normals(
    surface: &TriangleSurface,
    normals: &PerVertex<Vec3>,
) -> Vec<[LocatedVertex; 2]> {
    let topology = surface.topology();
    let size = cell_size(surface, normals);
    let cell = |n: Vec3| -> [i32; 3] { n.map(|x| (x / size).floor() as i32).into() };
    let mut cells: HashMap<[i32; 3], Vec<FaceId>> = HashMap::new();
    for f in topology.faces() {
        let corners = topology.face_vertices(f);
        let first = normals[corners[0]];
        let box_of = |fold: fn(&Vec3, &Vec3) -> Vec3| {
            cell(corners.iter().fold(first, |b, v| fold(&b, &normals[*v])))
        };
        let (low, high) = (box_of(|a, b| a.inf(b)), box_of(|a, b| a.sup(b)));
        for key in keys(low, high) {
            cells.entry(key).or_default().push(f);
        }
    }
    let far = FAR * surface.mean_edge();
    let place = |v: VertexId| LocatedVertex::of(surface, v);
    let twin = |v: VertexId| {
        let holds = |f: &&FaceId| {
            let corners = topology.face_vertices(**f);
            let distant =
                |w: &VertexId| (surface.positions()[*w] - surface.positions()[v]).norm() > far;
            corners.iter().all(distant) && contains(normals, corners, normals[v])
        };
        let found = cells.get(&cell(normals[v]))?.iter().find(holds)?;
        Some([place(v), place(topology.face_vertices(*found)[0])])
    };
    topology.vertices().filter_map(twin).collect()
}

fn keys(low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (low[0]..=high[0]).flat_map(move |i| {
        (low[1]..=high[1]).flat_map(move |j| (low[2]..=high[2]).map(move |k| [i, j, k]))
    })
}

/// Whether a direction lies inside the spherical triangle.
fn contains(normals: &PerVertex<Vec3>, corners: &[VertexId], direction: Vec3) -> bool {
    let matrix = Matrix3::from_columns(&[
        normals[corners[0]],
        normals[corners[1]],
        normals[corners[2]],
    ]);
    let inverse = matrix.try_inverse();
    inverse.is_some_and(|m| (m * direction).iter().all(|x| *x > -OUTSIDE))
}

/// Twice the mean length of an edge of the Gauss image.
fn cell_size(surface: &TriangleSurface, normals: &PerVertex<Vec3>) -> f64 {
    let t = surface.topology();
    let length = |[a, b]: [VertexId; 2]| (normals[a] - normals[b]).norm();
    let sum: f64 = t.edges().map(|e| length(t.edge_vertices(e))).sum();
    (2.0 * sum / t.n_edges() as f64).max(1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn pairs(name: &str) -> (usize, usize) {
        let options = TriangulationOptions {
            triangles: 3000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &options).unwrap();
        let found = shared_normals(&surface, surface.normals());
        for [a, b] in &found {
            let angle = surface.normals()[a.vertex].angle(&surface.normals()[b.vertex]);
            assert!(angle < 0.3, "{name}: normals {angle} apart");
        }
        (found.len(), surface.positions().len())
    }

    #[test]
    fn one_to_one_on_convex_surfaces_and_simple_saddles() {
        assert_eq!(pairs("ellipsoid").0, 0);
        assert_eq!(pairs("elliptic-paraboloid").0, 0);
        assert_eq!(pairs("hyperbolic-paraboloid").0, 0);
        assert_eq!(pairs("plane").0, 0);
    }

    #[test]
    fn monkey_saddle_and_torus_take_normals_twice() {
        for name in ["monkey-saddle", "torus"] {
            let (found, vertices) = pairs(name);
            assert!(found * 2 > vertices, "{name}: {found} of {vertices}");
        }
    }
}
