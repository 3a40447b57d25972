//! Panels whose edges can be flipped, and who can be taken out.

use phex_mesh::polygon::sides;
use phex_mesh::{EdgeId, FaceId, HexMesh, PerVertex, TopologyError, Vec3, VertexId, turn_edge};

/// Outlines of the panels as lists of vertices, and the panels at each vertex inside.
#[derive(Clone)]
pub(super) struct PanelOutlines {
    /// The outlines; that of a panel which was taken out is empty.
    corners: Vec<Vec<u32>>,
    /// The three panels at a vertex inside.
    around: PerVertex<Option<[u32; 3]>>,
}

/// The four panels at an edge: on its left and right, before its first and behind its second end.
pub(super) struct Star {
    pub ends: [u32; 2],
    pub left: u32,
    pub right: u32,
    pub before: u32,
    pub behind: u32,
}

impl Star {
    /// The panels round each end of the edge after its flip.
    pub fn turned(&self) -> [[u32; 3]; 2] {
        [
            [self.left, self.before, self.behind],
            [self.right, self.behind, self.before],
        ]
    }
}

/// What flips made of panels.
#[derive(Clone, Debug)]
pub struct Flipped {
    /// The panels. Vertices keep their places, though the planes that meet there are others.
    pub mesh: HexMesh,
    /// The panel of the given mesh that each one is. Those that are missing were taken out: their
    /// planes cut nothing off.
    pub faces: Vec<FaceId>,
    /// The vertex of the given mesh that each one was.
    pub vertices: Vec<VertexId>,
    /// Number of flips and of panels taken out.
    pub steps: usize,
}

impl Flipped {
    /// Panels that stay as they are.
    pub(crate) fn unchanged(mesh: &HexMesh) -> Self {
        Self {
            mesh: mesh.clone(),
            faces: mesh.topology().faces().collect(),
            vertices: mesh.topology().vertices().collect(),
            steps: 0,
        }
    }
}

impl PanelOutlines {
    pub fn new(mesh: &HexMesh) -> Self {
        let topology = mesh.topology();
        let around = |v: VertexId| {
            let faces = topology.faces_at(v).map(|f| f.index() as u32);
            let faces: Vec<u32> = faces.collect();
            let inside = !topology.is_boundary_vertex(v);
            inside.then(|| faces.try_into().ok()).flatten()
        };
        Self {
            corners: topology.face_lists(),
            around: PerVertex::from_fn(topology.n_vertices(), around),
        }
    }

    /// Edges between vertices inside, by their ends.
    pub fn inner_edges(&self, mesh: &HexMesh) -> Vec<[u32; 2]> {
        let topology = mesh.topology();
        let inside = |e: EdgeId| {
            let ends = topology.edge_vertices(e);
            let inner = ends.iter().all(|v| self.around[*v].is_some());
            inner.then(|| sorted(ends.map(|v| v.index() as u32)))
        };
        topology.edges().filter_map(inside).collect()
    }

    /// The three panels at a vertex inside.
    pub(crate) fn faces_at(&self, v: u32) -> Option<[u32; 3]> {
        self.around[VertexId::new(v)]
    }

    /// The outline of a panel.
    pub fn corners(&self, f: u32) -> &[u32] {
        &self.corners[f as usize]
    }

    pub fn valence(&self, f: u32) -> usize {
        self.corners(f).len()
    }

    /// The panels round an edge; `None` if its vertices are no longer neighbours.
    pub fn star(&self, [a, b]: [u32; 2]) -> Option<Star> {
        let (at_a, at_b) = (self.faces_at(a)?, self.faces_at(b)?);
        let follows = |f: &u32, p: u32, q: u32| sides(self.corners(*f)).any(|side| side == [p, q]);
        let left = at_a.into_iter().find(|f| follows(f, a, b))?;
        let right = at_a.into_iter().find(|f| follows(f, b, a))?;
        let other = |faces: [u32; 3]| faces.into_iter().find(|&f| f != left && f != right);
        Some(Star {
            ends: [a, b],
            left,
            right,
            before: other(at_a)?,
            behind: other(at_b)?,
        })
    }

    /// Whether the panels on both sides keep `least` corners, and two panels share one edge at the
    /// most.
    pub(crate) fn can_flip(&self, star: &Star, least: usize) -> bool {
        let shared = self.corners[star.before as usize]
            .iter()
            .filter(|v| self.corners[star.behind as usize].contains(v));
        [star.left, star.right]
            .iter()
            .all(|&f| self.valence(f) > least)
            && shared.count() == 0
    }

    /// Afterwards the first vertex has the left panel, the second the right one, and both the
    /// panels at the ends.
    pub(crate) fn flip(&mut self, star: &Star) {
        let Star {
            ends: [a, b],
            left,
            right,
            before,
            behind,
        } = *star;
        let sides = [left, right].map(|f| f as usize);
        let at_ends = [before, behind].map(|f| Some(f as usize));
        turn_edge(&mut self.corners, [a, b], sides, at_ends);
        self.around[VertexId::new(a)] = Some([left, before, behind]);
        self.around[VertexId::new(b)] = Some([right, behind, before]);
    }

    /// Takes out a triangle inside, whose neighbours keep three corners; they then meet in the
    /// vertex that is returned.
    pub(crate) fn take_out(&mut self, f: u32) -> Option<u32> {
        let [a, b, c]: [u32; 3] = self.corners[f as usize].clone().try_into().ok()?;
        let across = |v: u32, w: u32| {
            let mut others = self.faces_at(v)?.into_iter().filter(|&g| g != f);
            others.find(|&g| self.corners[g as usize].contains(&w))
        };
        let neighbours = [across(a, b)?, across(b, c)?, across(c, a)?];
        if neighbours.iter().any(|&g| self.valence(g) <= 3) {
            return None;
        }
        let [at_ab, at_bc, at_ca] = neighbours.map(|g| g as usize);
        self.corners[at_ab].retain(|&v| v != b);
        self.corners[at_ca].retain(|&v| v != c);
        self.corners[at_bc].retain(|&v| v != c);
        let kept = self.corners[at_bc].iter_mut().find(|v| **v == b)?;
        *kept = a;
        self.corners[f as usize].clear();
        self.around[VertexId::new(a)] = Some(neighbours);
        self.around[VertexId::new(b)] = None;
        self.around[VertexId::new(c)] = None;
        Some(a)
    }

    /// The edges of the panels at some vertices that begin there.
    pub(crate) fn edges_round(&self, vertices: &[u32]) -> Vec<[u32; 2]> {
        let at = |&v: &u32| {
            let faces = self.faces_at(v).into_iter().flatten();
            faces.filter_map(move |f| {
                let [_, next] = sides(self.corners(f)).find(|[w, _]| *w == v)?;
                self.faces_at(next).map(|_| sorted([v, next]))
            })
        };
        vertices.iter().flat_map(at).collect()
    }

    /// The mesh of the panels that are left.
    pub(crate) fn into_mesh(self, mesh: &HexMesh, steps: usize) -> Result<Flipped, TopologyError> {
        let mut used = vec![false; mesh.positions.len()];
        self.corners
            .iter()
            .flatten()
            .for_each(|&v| used[v as usize] = true);
        let topology = mesh.topology();
        let vertices: Vec<VertexId> = topology.vertices().filter(|v| used[v.index()]).collect();
        let mut number = vec![0u32; used.len()];
        for (i, v) in vertices.iter().enumerate() {
            number[v.index()] = i as u32;
        }
        let left = |f: &FaceId| !self.corners[f.index()].is_empty();
        let faces: Vec<FaceId> = topology.faces().filter(left).collect();
        let outline = |f: &FaceId| -> Vec<u32> {
            let corners = self.corners[f.index()].iter();
            corners.map(|&v| number[v as usize]).collect()
        };
        let outlines: Vec<Vec<u32>> = faces.iter().map(outline).collect();
        let positions: Vec<Vec3> = vertices.iter().map(|v| mesh.positions[*v]).collect();
        Ok(Flipped {
            mesh: HexMesh::new(positions, &outlines)?,
            faces,
            vertices,
            steps,
        })
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
