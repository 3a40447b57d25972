//! A surface with fewer vertices, for inputs that are finer than the panels need.
//!
//! Edges collapse, the shortest first, until as many vertices are left as are wanted; in between
//! edges turn where that makes triangles Delaunay. Vertices that are left are vertices of the
//! surface. Those at the two ends of an edge that collapses have normals that hardly differ: where
//! the surface bends within the spacing it stays as fine as it is. The boundary and creases
//! collapse along themselves only, and twice as late.
//!
//! *Guaranteed*: topology and boundary loops are those of the surface, corners stay; the same
//! result for any number of threads. *Fails* never; on a surface that is rough from vertex to
//! vertex, and where collapses would fold it, more vertices are left than were asked for.

mod collapse;
mod corner_table;
mod flips;

use super::creases::creases;
use super::spacing;
use corner_table::{CornerTable, NONE};
use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};

/// A surface with fewer vertices.
#[derive(Clone)]
pub struct Coarsened {
    /// The surface, with the normals of the finer one.
    pub surface: TriangleSurface,
    /// The vertex of the finer surface that each vertex is.
    pub source: PerVertex<VertexId>,
}

/// A surface with about `wanted` of its vertices, evenly spread; `corners` stay.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let options = TriangulationOptions { triangles: 20_000, ..Default::default() };
/// # let torus = triangulate(&Shape::from_name("torus", &[])?, &options)?;
/// use phex::smooth_surface::coarsened;
///
/// let coarse = coarsened(&torus, &[], 2000);
/// let count = coarse.surface.positions().len();
/// assert!((2000..2200).contains(&count));
/// let (v, place) = coarse.surface.positions().enumerate().next().unwrap();
/// assert_eq!(*place, torus.positions()[coarse.source[v]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn coarsened(surface: &TriangleSurface, corners: &[VertexId], wanted: usize) -> Coarsened {
    let mut mesh = ChangingMesh::of(surface, corners, wanted);
    flips::turn_edges(&mut mesh);
    collapse::collapse_short(&mut mesh, wanted);
    mesh.finished()
}

/// The surface with edges turned where that makes triangles Delaunay.
pub(super) fn delaunay(surface: &TriangleSurface) -> TriangleSurface {
    let mut mesh = ChangingMesh::of(surface, &[], surface.positions().len());
    flips::turn_edges(&mut mesh);
    mesh.finished().surface
}

/// The mesh that changes, with what is known at its vertices.
struct ChangingMesh {
    table: CornerTable,
    position: Vec<Vec3>,
    normal: Vec<Vec3>,
    /// Side of equilateral triangles that cover the surface with as many vertices as are wanted.
    spacing: f64,
    corner: Vec<bool>,
    /// Whether each vertex is gone.
    gone: Vec<bool>,
}

impl ChangingMesh {
    fn of(surface: &TriangleSurface, corners: &[VertexId], wanted: usize) -> Self {
        let topology = surface.topology();
        let creases = creases(surface);
        let n = topology.n_vertices();
        let mut corner = vec![false; n];
        corners.iter().for_each(|v| corner[v.index()] = true);
        Self {
            table: CornerTable::of(topology, &creases),
            position: surface.positions().as_slice().to_vec(),
            normal: surface.normals().as_slice().to_vec(),
            spacing: spacing(surface, wanted),
            corner,
            gone: vec![false; n],
        }
    }

    fn place(&self, v: u32) -> Vec3 {
        self.position[v as usize]
    }

    /// Length of an edge in units of the spacing.
    fn length(&self, h: u32) -> f64 {
        let [u, v] = self.table.ends(h);
        (self.place(u) - self.place(v)).norm() / self.spacing
    }

    /// Twice the area of a triangle times its normal.
    fn area_vector(&self, [a, b, c]: [u32; 3]) -> Vec3 {
        let [a, b, c] = [a, b, c].map(|v| self.place(v));
        (b - a).cross(&(c - a))
    }

    /// Quality of a triangle, 1 if it is equilateral, 0 if it has no area.
    fn quality(&self, [a, b, c]: [u32; 3]) -> f64 {
        let square = |p: u32, q: u32| (self.place(p) - self.place(q)).norm_squared();
        let squares = square(a, b) + square(b, c) + square(c, a);
        2.0 * 3.0_f64.sqrt() * self.area_vector([a, b, c]).norm() / squares.max(f64::MIN_POSITIVE)
    }

    fn finished(self) -> Coarsened {
        let mut number = vec![NONE; self.gone.len()];
        let left = (0..number.len()).filter(|v| !self.gone[*v]);
        let left: Vec<usize> = left.collect();
        for (i, v) in left.iter().enumerate() {
            number[*v] = i as u32;
        }
        let of = |values: &[Vec3]| left.iter().map(|v| values[*v]).collect::<Vec<_>>();
        let triangles = self.table.triangles();
        let triangles: Vec<[u32; 3]> = triangles.map(|t| t.map(|v| number[v as usize])).collect();
        let surface = TriangleSurface::new(of(&self.position), &triangles)
            .expect("collapses keep a manifold a manifold");
        let source = left.iter().map(|v| VertexId::new(*v as u32));
        Coarsened {
            surface: surface.with_normals(PerVertex::from_vec(of(&self.normal))),
            source: PerVertex::from_vec(source.collect()),
        }
    }
}
