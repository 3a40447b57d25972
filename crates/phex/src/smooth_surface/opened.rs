//! A surface cut open along its creases, and closed again after it was refined.
//!
//! What is fitted to a surface that is open there (normals, cubics over edges) knows nothing of
//! what is beyond. Each vertex of a crease becomes one for each of the parts that meet in it.

use super::creases::creases;
use phex_mesh::{
    EdgeId, FaceId, HalfEdgeId, PerEdge, PerVertex, Topology, TriangleSurface, Vec3, VertexId,
};
use std::collections::HashMap;

/// Which vertices of an open surface are one.
pub(super) struct Opened {
    /// Number of each vertex on the closed surface.
    number: Vec<u32>,
    /// A vertex for each of these numbers.
    first: Vec<u32>,
    /// Vertices that the surface had when it was opened, and those that it has open.
    before: usize,
    open: usize,
    /// The number of the vertex in the middle of an edge between two.
    middle: HashMap<[u32; 2], u32>,
}

impl Opened {
    /// The surface cut open, numbered as it was: those of a closed surface are its vertices.
    pub(super) fn along_creases(surface: &TriangleSurface) -> (Self, TriangleSurface) {
        let topology = surface.topology();
        let (before, creases) = (topology.n_vertices(), creases(surface));
        let mut corners: Vec<[u32; 3]> = surface.triangles().collect();
        let mut number: Vec<u32> = (0..before as u32).collect();
        for v in topology.vertices() {
            for part in parts(topology, &creases, v).into_iter().skip(1) {
                let new = number.len() as u32;
                number.push(v.index() as u32);
                for f in part {
                    let face = corners[f.index()].iter_mut();
                    face.filter(|w| **w == v.index() as u32)
                        .for_each(|w| *w = new);
                }
            }
        }
        let place = |v: &u32| surface.positions()[VertexId::new(*v)];
        let open = match number.len() == before {
            true => surface.clone(),
            false => TriangleSurface::new(number.iter().map(place).collect(), &corners)
                .expect("the parts of a manifold round its vertices are manifolds"),
        };
        let opened = Self {
            first: (0..before as u32).collect(),
            before,
            open: number.len(),
            number,
            middle: HashMap::new(),
        };
        (opened, open)
    }

    /// Takes in the new vertices of a surface of which these edges were split.
    pub(super) fn split(&mut self, surface: &TriangleSurface, edges: &[EdgeId]) {
        let topology = surface.topology();
        for e in edges {
            let new = self.number.len() as u32;
            let ends = topology.edge_vertices(*e).map(|v| self.number[v.index()]);
            let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let fresh = self.first.len() as u32;
            let number = match topology.is_boundary_edge(*e) {
                true => *self.middle.entry(ends).or_insert(fresh),
                false => fresh,
            };
            if number == fresh {
                self.first.push(new);
            }
            self.number.push(number);
        }
    }

    /// The refined surface with the vertices that are one at one place, so that edges on both sides
    /// of a crease are split together: cubics over them differ where a corner is on one side alone.
    pub(super) fn in_step(&self, surface: TriangleSurface) -> TriangleSurface {
        if self.open == self.before {
            return surface;
        }
        let one = |v: VertexId| VertexId::new(self.first[self.number[v.index()] as usize]);
        let places = PerVertex::from_fn(self.number.len(), |v| surface.positions()[one(v)]);
        let normals = surface.normals().clone();
        TriangleSurface::from_topology(places, surface.topology().clone()).with_normals(normals)
    }

    /// The refined surface with what was cut open closed again; `None` if that is no manifold.
    pub(super) fn glued(&self, surface: &TriangleSurface) -> Option<TriangleSurface> {
        if self.open == self.before {
            return Some(surface.clone());
        }
        let faces = surface.triangles();
        let faces: Vec<[u32; 3]> = faces.map(|f| f.map(|v| self.number[v as usize])).collect();
        let places = self.closed(surface.positions());
        let mut normals = PerVertex::filled(self.first.len(), Vec3::zeros());
        for (v, n) in surface.normals().enumerate() {
            normals[VertexId::new(self.number[v.index()])] += n;
        }
        let glued = TriangleSurface::new(places.iter().copied().collect(), &faces).ok()?;
        let normals = normals.enumerate().map(|(v, n)| {
            let normal = n.try_normalize(0.0);
            normal.unwrap_or(glued.normals()[v])
        });
        let normals = PerVertex::from_vec(normals.collect());
        Some(glued.with_normals(normals))
    }

    /// Values at the vertices of the surface as it was, at those of the open one.
    pub(super) fn opened<T: Copy>(&self, values: &PerVertex<T>) -> PerVertex<T> {
        let number = &self.number[..self.open];
        let values = number.iter().map(|&v| values[VertexId::new(v)]);
        PerVertex::from_vec(values.collect())
    }

    /// Values at the vertices of the refined open surface, at those of the closed one.
    pub(super) fn closed<T: Copy>(&self, values: &PerVertex<T>) -> PerVertex<T> {
        let values = self.first.iter().map(|&v| values[VertexId::new(v)]);
        PerVertex::from_vec(values.collect())
    }
}

/// The faces at a vertex, those together that no crease is between.
fn parts(topology: &Topology, creases: &PerEdge<bool>, v: VertexId) -> Vec<Vec<FaceId>> {
    let out: Vec<HalfEdgeId> = topology.outgoing(v).collect();
    let is_crease = |h: HalfEdgeId| creases[topology.edge(h)];
    let mut parts: Vec<Vec<FaceId>> = Vec::new();
    for h in &out {
        match parts.last_mut().filter(|_| !is_crease(*h)) {
            Some(part) => part.push(topology.face(*h)),
            None => parts.push(vec![topology.face(*h)]),
        }
    }
    let goes_round = !topology.is_boundary_vertex(v);
    if parts.len() > 1 && goes_round && !is_crease(out[0]) {
        let last = parts.pop().unwrap_or_default();
        parts[0].extend(last);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of twelve triangles.
    fn cuboid() -> TriangleSurface {
        let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, 2.0 * (k >> 2) as f64);
        let sides = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let cut = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        let triangles: Vec<[u32; 3]> = sides.into_iter().flat_map(cut).collect();
        TriangleSurface::new((0..8).map(corner).collect(), &triangles).unwrap()
    }

    #[test]
    fn a_box_falls_into_its_sides_and_closes_again() {
        let cuboid = cuboid();
        let (mut opened, open) = Opened::along_creases(&cuboid);
        assert_eq!(open.positions().len(), 24);
        assert_eq!(open.topology().components().1, 6);
        let faces = |s: &TriangleSurface| s.topology().face_lists();
        let closed = opened.glued(&open).unwrap();
        assert_eq!(faces(&closed), faces(&cuboid));
        assert_eq!(closed.positions(), cuboid.positions());
        let numbers = PerVertex::from_fn(8, |v| v.index());
        assert_eq!(opened.closed(&opened.opened(&numbers)), numbers);
        // Of the 30 edges that the sides have, 12 are two, so that 18 have a middle.
        let edges: Vec<EdgeId> = open.topology().edges().collect();
        opened.split(&open, &edges);
        assert_eq!((edges.len(), opened.first.len()), (30, 8 + 18));
    }
}
