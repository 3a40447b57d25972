//! Closed walks from a root that generate all loops that even faces do not close: round odd faces
//! inside, and round loops that are no faces.
//!
//! A spanning tree of the vertices and one of the faces (with the outside as one more) that share
//! no edge leave an edge for each loop (tree-cotree decomposition, D. Eppstein 2003).

use phex_mesh::{Cotree, EdgeId, FaceId, HexMesh, PerEdge, PerVertex, Topology, VertexId};
use std::collections::VecDeque;
use std::ops::Range;

/// A closed walk from the root.
#[derive(Debug)]
pub(in crate::optimise) struct Walk {
    vertices: Vec<u32>,
    /// Whether it goes round an odd face, all of whose reflections keep the face's normal; else
    /// round a loop that is no face.
    round_face: bool,
    /// Its first equation.
    pub first: usize,
}

impl Walk {
    pub(crate) fn n_steps(&self) -> usize {
        self.vertices.len() - 1
    }

    /// Whether its reflections make one reflection: those along the edges of an odd planar face do.
    pub(crate) fn is_mirror(&self) -> bool {
        self.round_face
    }

    /// Its vertices, each once, in ascending order.
    pub fn distinct(&self) -> Vec<u32> {
        let mut distinct = self.vertices.clone();
        distinct.sort_unstable();
        distinct.dedup();
        distinct
    }

    /// Its equations.
    pub fn equations(&self) -> Range<usize> {
        let count = if self.is_mirror() { 1 } else { 2 };
        self.first..self.first + count
    }

    pub fn steps(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.vertices.windows(2).map(|w| [w[0], w[1]])
    }
}

/// All walks of a mesh, and which equations each vertex has a part in.
#[derive(Debug)]
pub(in crate::optimise) struct Walks {
    pub walks: Vec<Walk>,
    /// Edges of the spanning tree, from the root.
    pub tree: Vec<[u32; 2]>,
    at: Vec<Vec<u32>>,
    start: Vec<usize>,
}

impl Walks {
    /// Those of a mesh in one piece; there are none in a mesh of several.
    pub fn of(mesh: &HexMesh) -> Self {
        let topology = mesh.topology();
        let mut walks = Self {
            walks: Vec::new(),
            tree: Vec::new(),
            at: vec![Vec::new(); topology.n_vertices()],
            start: vec![0; topology.n_vertices() + 1],
        };
        if topology.components().1 == 1 {
            let tree = Tree::new(mesh);
            walks.tree = tree.branches.clone();
            let odd = |f: &FaceId| topology.valence(*f) % 2 == 1 && !topology.is_boundary_face(*f);
            for f in topology.faces().filter(odd) {
                walks.push(tree.round_face(topology, f), true);
            }
            for e in tree.generators(topology) {
                walks.push(tree.round_edge(topology, e), false);
            }
            walks.index();
        }
        walks
    }

    fn push(&mut self, vertices: Vec<u32>, round_face: bool) {
        let first = self.n_equations();
        self.walks.push(Walk {
            vertices,
            round_face,
            first,
        });
    }

    /// Finds out which equations there are at each vertex.
    fn index(&mut self) {
        for walk in &self.walks {
            let equations = walk.equations();
            for &v in &walk.vertices {
                let at = &mut self.at[v as usize];
                if at.last() != Some(&(equations.end as u32 - 1)) {
                    at.extend(equations.clone().map(|k| k as u32));
                }
            }
        }
        for (v, at) in self.at.iter().enumerate() {
            self.start[v + 1] = self.start[v] + at.len();
        }
    }

    pub fn n_equations(&self) -> usize {
        self.walks.last().map_or(0, |w| w.equations().end)
    }

    /// Pairs of a vertex and an equation.
    pub(crate) fn n_places(&self) -> usize {
        self.start[self.at.len()]
    }

    /// Equations that a vertex has a part in, in ascending order.
    pub fn at(&self, vertex: usize) -> &[u32] {
        &self.at[vertex]
    }

    /// Their places.
    pub fn places(&self, vertex: usize) -> Range<usize> {
        self.start[vertex]..self.start[vertex + 1]
    }

    /// The place of a vertex on the walk of an equation.
    pub fn place(&self, vertex: usize, equation: usize) -> usize {
        let before = self.at[vertex].partition_point(|&k| (k as usize) < equation);
        self.start[vertex] + before
    }
}

/// A spanning tree, breadth first from the middle, and the edges that are to turn freely.
struct Tree {
    parent: PerVertex<Option<VertexId>>,
    branches: Vec<[u32; 2]>,
    used: PerEdge<bool>,
    free: Vec<(FaceId, EdgeId)>,
}

impl Tree {
    fn new(mesh: &HexMesh) -> Self {
        let topology = mesh.topology();
        let free = free_edges(mesh);
        let mut used = PerEdge::filled(topology.n_edges(), false);
        free.iter().for_each(|&(_, e)| used[e] = true);
        let mut neighbours = PerVertex::filled(topology.n_vertices(), Vec::new());
        for e in topology.edges().filter(|&e| !used[e]) {
            let [a, b] = topology.edge_vertices(e);
            neighbours[a].push((e, b));
            neighbours[b].push((e, a));
        }
        let root = middle_vertex(mesh);
        let mut parent = PerVertex::filled(topology.n_vertices(), None);
        let (mut branches, mut queue) = (Vec::new(), VecDeque::from([root]));
        while let Some(from) = queue.pop_front() {
            for &(e, to) in &neighbours[from] {
                if to != root && parent[to].is_none() {
                    parent[to] = Some(from);
                    used[e] = true;
                    branches.push([from, to].map(number));
                    queue.push_back(to);
                }
            }
        }
        Self {
            parent,
            branches,
            used,
            free,
        }
    }

    /// From the root to a vertex.
    fn path(&self, to: VertexId) -> Vec<u32> {
        let up = std::iter::successors(Some(to), |&v| self.parent[v]);
        let mut path: Vec<u32> = up.map(number).collect();
        path.reverse();
        path
    }

    /// There along the tree, round the face, and back.
    fn round_face(&self, topology: &Topology, f: FaceId) -> Vec<u32> {
        let corners = topology.face_vertices(f);
        let nearest = (0..corners.len()).min_by_key(|&k| self.path(corners[k]).len());
        let first = nearest.unwrap_or(0);
        let mut walk = self.path(corners[first]);
        let back: Vec<u32> = walk.iter().rev().copied().collect();
        let others = (1..corners.len()).map(|k| corners[(first + k) % corners.len()]);
        walk.extend(others.map(number));
        walk.extend(back);
        walk
    }

    /// Out to one end of an edge, over it, and back from the other.
    fn round_edge(&self, topology: &Topology, e: EdgeId) -> Vec<u32> {
        let [a, b] = topology.edge_vertices(e);
        let mut walk = self.path(a);
        walk.extend(self.path(b).iter().rev());
        walk
    }

    /// Edges of neither tree: one for each loop.
    fn generators(&self, topology: &Topology) -> Vec<EdgeId> {
        let at_outside = self.free.iter().map(|(f, _)| *f);
        Cotree::new(topology, self.used.clone(), at_outside).generators
    }
}

/// The longest boundary edge of every odd face on the boundary.
pub(crate) fn free_edges(mesh: &HexMesh) -> Vec<(FaceId, EdgeId)> {
    let topology = mesh.topology();
    let longest = |f| {
        let edges = topology.face_half_edges(f).map(|h| topology.edge(h));
        edges
            .filter(|&e| topology.is_boundary_edge(e))
            .max_by(|&a, &b| mesh.edge_length(a).total_cmp(&mesh.edge_length(b)))
            .map(|e| (f, e))
    };
    let odd = topology.faces().filter(|&f| topology.valence(f) % 2 == 1);
    odd.filter_map(longest).collect()
}

fn number(v: VertexId) -> u32 {
    v.index() as u32
}

/// The vertex nearest to the mean of all, from which walks are short.
pub(crate) fn middle_vertex(mesh: &HexMesh) -> VertexId {
    let mean = mesh.positions.iter().sum::<phex_mesh::Vec3>() / mesh.positions.len() as f64;
    let distance = |v: VertexId| (mesh.position(v) - mean).norm_squared();
    let vertices = mesh.topology().vertices();
    let nearest = vertices.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    nearest.unwrap_or(VertexId::new(0))
}
