//! From labelled vertices to a polygon mesh whose interior vertices have degree 3.
//!
//! Rule of the half-edge `p -> q` with different labels: the cell of `p` leaves through the middle
//! of `pq` into the triangle on its left, the cell of `q` comes in there. Triangles with three
//! labels are vertices of the panelling, edges of the boundary with two labels are boundary
//! vertices, sharp corners of the boundary are corners of their cell. The loops that these steps
//! close are the panels; no map from pairs of cells to vertices is needed, which would break where
//! two cells touch twice.

use super::voronoi::{PartCells, UNREACHED};
use crate::directions::intrinsic::IntrinsicMesh;
use crate::layout::seeds::Seed;
use phex_mesh::{EdgeId, FaceId, HalfEdgeId, IdMap, IdSet, PerVertex, Topology, VertexId};
use std::collections::{HashMap, HashSet};

/// A place where the outline of a cell passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    /// Middle of an edge (a vertex of the panelling only on the boundary).
    Edge(EdgeId),
    /// Middle of a triangle with three labels.
    Triangle(FaceId),
    /// Sharp corner of the boundary.
    Corner(VertexId),
    /// Vertex of the boundary that one panel has in addition, to follow a curved boundary.
    Rim(VertexId),
}

/// The outline of a cell: its vertices, in order, of each loop that could be closed.
#[derive(Clone, Debug, Default)]
struct Outline {
    loops: Vec<Vec<Node>>,
    open: bool,
}

/// Cells with their outlines.
#[derive(Clone, Debug)]
pub(crate) struct CellComplex {
    /// Label of each vertex.
    pub label: PerVertex<u32>,
    /// Seed vertex of each label; labels without a panel keep theirs.
    pub seed: Vec<VertexId>,
    /// Label and outline of each panel, in the order of the labels.
    pub panels: Vec<(u32, Vec<Node>)>,
}

/// Cells that could not be made discs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotDiscs {
    /// How many.
    pub cells: usize,
    /// The seed of the first one.
    pub seed: VertexId,
}

/// Vertices of a cell inside, and of one at the boundary, at the least.
const LEAST_INSIDE: usize = 4;
const LEAST_AT_BOUNDARY: usize = 3;
/// Area of a cell at the boundary, over the median of all, below which it is a sliver; and the same
/// for one with fewer vertices than [`LEAST_INSIDE`] that are no corners of the boundary.
const SLIVER: f64 = 0.25;
const SMALL: f64 = 0.5;
/// Rounds of relabelling.
const ROUNDS: usize = 20;

/// Relabels until every cell is a disc with at least four vertices inside and three at the
/// boundary, and none surrounds a hole; boundary cells that are mere slivers are given to a
/// neighbour.
///
/// # Errors
/// The cells that remain when that does not end.
pub(crate) fn disc_cells(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    corners: &HashSet<VertexId>,
    label: PerVertex<u32>,
    seed: Vec<VertexId>,
) -> Result<CellComplex, NotDiscs> {
    let mut complex = CellComplex {
        label,
        seed,
        panels: Vec::new(),
    };
    let mut rounds_left = ROUNDS;
    let mut outlines = Vec::new();
    let mut changed = vec![true; complex.seed.len()];
    let holes = topology.boundary_loops();
    loop {
        outlines.resize_with(complex.seed.len(), Outline::default);
        outline_again(topology, corners, &complex.label, &changed, &mut outlines);
        let area = areas(mesh, &complex.label, complex.seed.len());
        let surrounding = surrounding(&holes, &complex.label);
        let faults = faults(&outlines, &area, &surrounding);
        if faults.is_empty() {
            complex.panels = panels(outlines);
            return Ok(complex);
        }
        if rounds_left == 0 {
            return Err(NotDiscs {
                cells: faults.len(),
                seed: complex.seed[faults[0].0 as usize],
            });
        }
        rounds_left -= 1;
        let before = complex.label.clone();
        mend((topology, mesh), &holes, &mut complex, &faults);
        changed = changed_cells(topology, &before, &complex);
    }
}

/// Which cells have other vertices, or other cells beside them, than before.
fn changed_cells(topology: &Topology, before: &PerVertex<u32>, complex: &CellComplex) -> Vec<bool> {
    let mut changed = vec![false; complex.seed.len()];
    let moved = before.enumerate().filter(|(v, l)| complex.label[*v] != **l);
    for (v, _) in moved {
        for w in topology.neighbours(v).into_iter().chain([v]) {
            changed[before[w] as usize] = true;
            changed[complex.label[w] as usize] = true;
        }
    }
    changed
}

fn panels(outlines: Vec<Outline>) -> Vec<(u32, Vec<Node>)> {
    let single = |(cell, outline): (u32, Outline)| Some((cell, outline.loops.into_iter().next()?));
    (0..).zip(outlines).filter_map(single).collect()
}

fn areas(mesh: &IntrinsicMesh, label: &PerVertex<u32>, count: usize) -> Vec<f64> {
    let mut area = vec![0.0; count];
    let mut images = vec![1; count];
    for ((l, m), k) in label.iter().zip(&mesh.mass).zip(&mesh.multiplicity) {
        area[*l as usize] += m;
        images[*l as usize] = *k.max(&images[*l as usize]);
    }
    // What mirror planes cut is whole with its images.
    area.iter()
        .zip(images)
        .map(|(a, k)| a * f64::from(k))
        .collect()
}

/// What is wrong with a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CellFault {
    /// Not a disc: several loops, one that does not close, or a hole.
    NotADisc,
    /// Too few corners, or a sliver.
    TooSmall,
}

/// Cells that hold all of a boundary curve, which their outlines do not show.
fn surrounding(holes: &[Vec<VertexId>], label: &PerVertex<u32>) -> HashSet<u32> {
    let single = |hole: &Vec<VertexId>| {
        let first = label[hole[0]];
        hole.iter().all(|v| label[*v] == first).then_some(first)
    };
    holes.iter().filter_map(single).collect()
}

/// Whether two cells hold all of a boundary curve together.
fn surround(holes: &[Vec<VertexId>], label: &PerVertex<u32>, cells: [u32; 2]) -> bool {
    let between = |hole: &Vec<VertexId>| hole.iter().all(|v| cells.contains(&label[*v]));
    holes.iter().any(between)
}

fn faults(outlines: &[Outline], area: &[f64], surrounding: &HashSet<u32>) -> Vec<(u32, CellFault)> {
    let mut present: Vec<f64> = area.iter().copied().filter(|a| *a > 0.0).collect();
    present.sort_by(f64::total_cmp);
    let median = present.get(present.len() / 2).copied().unwrap_or(0.0);
    let mut list = Vec::new();
    for (c, outline) in outlines.iter().enumerate() {
        if area[c] == 0.0 {
            continue;
        }
        let is_disc = !outline.open && outline.loops.len() == 1;
        if !is_disc || surrounding.contains(&(c as u32)) {
            list.push((c as u32, CellFault::NotADisc));
        } else if too_small(&outline.loops[0], area[c], median) {
            list.push((c as u32, CellFault::TooSmall));
        }
    }
    list
}

fn too_small(nodes: &[Node], area: f64, median: f64) -> bool {
    let corners = nodes
        .iter()
        .filter(|n| matches!(n, Node::Corner(_)))
        .count();
    let inside = nodes.iter().all(|n| matches!(n, Node::Triangle(_)));
    if inside {
        return nodes.len() < LEAST_INSIDE;
    }
    let is_plain = nodes.len() - corners < LEAST_INSIDE;
    let least = if is_plain { SMALL } else { SLIVER };
    nodes.len() < LEAST_AT_BOUNDARY || area < least * median
}

/// Splits cells that are not discs and gives small ones to the neighbour with the longest common
/// outline with which they surround no hole.
fn mend(
    (topology, mesh): (&Topology, &IntrinsicMesh),
    holes: &[Vec<VertexId>],
    complex: &mut CellComplex,
    faults: &[(u32, CellFault)],
) {
    let mut touched = HashSet::new();
    let mut parts = PartCells::new(topology, mesh);
    // A cell that is not touched has the members with which the round began.
    let members = members_of(complex, faults);
    for (&(cell, fault), members) in faults.iter().zip(members) {
        if !touched.insert(cell) {
            continue;
        }
        let neighbours = neighbours(topology, &complex.label, &members, cell);
        let fits = |n: &&(u32, usize)| {
            fault == CellFault::NotADisc || !surround(holes, &complex.label, [cell, n.0])
        };
        let Some(&(largest, _)) = neighbours.iter().find(fits) else {
            continue;
        };
        if fault == CellFault::NotADisc && release_islands(topology, complex, &members, cell) {
            touched.extend(neighbours.iter().map(|n| n.0));
        } else if fault == CellFault::NotADisc && split(&mut parts, complex, &members, cell) {
            touched.extend(neighbours.iter().map(|n| n.0));
        } else if touched.insert(largest) || fault == CellFault::TooSmall {
            members.iter().for_each(|&v| complex.label[v] = largest);
            touched.extend(neighbours.iter().map(|n| n.0));
        }
    }
}

/// Vertices of the cells that have faults.
fn members_of(complex: &CellComplex, faults: &[(u32, CellFault)]) -> Vec<Vec<VertexId>> {
    let mut place = vec![None; complex.seed.len()];
    for (i, (cell, _)) in faults.iter().enumerate() {
        place[*cell as usize] = Some(i);
    }
    let mut members = vec![Vec::new(); faults.len()];
    for (v, l) in complex.label.enumerate() {
        if let Some(i) = place[*l as usize] {
            members[i].push(v);
        }
    }
    members
}

/// Gives all but the largest connected part of a cell to neighbours; false if the cell is
/// connected.
fn release_islands(
    topology: &Topology,
    complex: &mut CellComplex,
    members: &[VertexId],
    cell: u32,
) -> bool {
    let mut parts = connected_parts(topology, &complex.label, members, cell);
    parts.sort_by_key(|p| std::cmp::Reverse(p.len()));
    for island in parts.iter().skip(1) {
        if let Some(&(to, _)) = neighbours(topology, &complex.label, island, cell).first() {
            island.iter().for_each(|&v| complex.label[v] = to);
        }
    }
    if parts.len() > 1 && !parts[0].contains(&complex.seed[cell as usize]) {
        complex.seed[cell as usize] = parts[0][0];
    }
    parts.len() > 1
}

fn connected_parts(
    topology: &Topology,
    label: &PerVertex<u32>,
    members: &[VertexId],
    cell: u32,
) -> Vec<Vec<VertexId>> {
    let mut seen = HashSet::new();
    let mut parts = Vec::new();
    for &start in members {
        if !seen.insert(start) {
            continue;
        }
        let mut part = vec![start];
        let mut next = 0;
        while next < part.len() {
            for w in topology.neighbours(part[next]) {
                if label[w] == cell && seen.insert(w) {
                    part.push(w);
                }
            }
            next += 1;
        }
        parts.push(part);
    }
    parts
}

/// Neighbouring cells, the one with the most common edges first.
fn neighbours(
    topology: &Topology,
    label: &PerVertex<u32>,
    members: &[VertexId],
    cell: u32,
) -> Vec<(u32, usize)> {
    let mut count: HashMap<u32, usize> = HashMap::new();
    for &v in members {
        for w in topology.neighbours(v) {
            if label[w] != cell {
                *count.entry(label[w]).or_default() += 1;
            }
        }
    }
    let mut list: Vec<(u32, usize)> = count.into_iter().collect();
    list.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    list
}

/// Splits a cell between its two vertices farthest from each other; false if it has only one.
fn split(
    parts: &mut PartCells<'_>,
    complex: &mut CellComplex,
    members: &[VertexId],
    cell: u32,
) -> bool {
    let mut farthest = |from: VertexId| {
        let grown = parts.grow(&[Seed::at(from)], members);
        let reached = members.iter().zip(grown).filter(|(_, g)| g.1.is_finite());
        let farthest = reached.max_by(|(v, a), (w, b)| a.1.total_cmp(&b.1).then(w.cmp(v)));
        farthest.map(|(v, _)| *v)
    };
    let Some(first) = farthest(members[0]) else {
        return false;
    };
    let Some(second) = farthest(first).filter(|s| *s != first) else {
        return false;
    };
    let halves = parts.grow(&[first, second].map(Seed::at), members);
    let new = complex.seed.len() as u32;
    complex.seed[cell as usize] = first;
    complex.seed.push(second);
    for (&v, (half, _)) in members.iter().zip(halves) {
        // A part that neither half reaches is a piece of its own and goes with the second.
        if half == 1 || half == UNREACHED {
            complex.label[v] = new;
        }
    }
    true
}

/// Successor of each node on the outline of each cell that is wanted.
struct OutlineWalk<'a> {
    wanted: &'a [bool],
    next: IdMap<(u32, Node), Node>,
    order: Vec<(u32, Node)>,
}

impl OutlineWalk<'_> {
    fn link(&mut self, cell: u32, from: Node, to: Node) {
        let wanted = self.wanted[cell as usize];
        if wanted && self.next.insert((cell, from), to).is_none() {
            self.order.push((cell, from));
        }
    }
}

/// Outlines the cells that are wanted; the others stay as they are.
fn outline_again(
    topology: &Topology,
    corners: &HashSet<VertexId>,
    label: &PerVertex<u32>,
    wanted: &[bool],
    outlines: &mut [Outline],
) {
    let again = outlines.iter_mut().zip(wanted).filter(|(_, w)| **w);
    again.for_each(|(outline, _)| *outline = Outline::default());
    let mut walk = OutlineWalk {
        wanted,
        next: IdMap::default(),
        order: Vec::new(),
    };
    for f in topology.faces() {
        link_triangle(topology, label, f, &mut walk);
    }
    for h in topology.half_edges() {
        if topology.twin(h).is_none() && label[topology.origin(h)] != label[topology.target(h)] {
            link_boundary(topology, corners, label, h, &mut walk);
        }
    }
    add_closed_loops(topology, &walk, outlines);
}

fn link_triangle(
    topology: &Topology,
    label: &PerVertex<u32>,
    f: FaceId,
    walk: &mut OutlineWalk<'_>,
) {
    let (mut leaves, mut enters) = (Vec::with_capacity(3), Vec::with_capacity(3));
    for h in topology.face_half_edges(f) {
        let (a, b) = (label[topology.origin(h)], label[topology.target(h)]);
        if a != b {
            leaves.push((a, Node::Edge(topology.edge(h))));
            enters.push((b, Node::Edge(topology.edge(h))));
        }
    }
    let middle = (leaves.len() == 3).then_some(Node::Triangle(f));
    for &(cell, from) in &leaves {
        let Some(&(_, to)) = enters.iter().find(|e| e.0 == cell) else {
            continue;
        };
        match middle {
            Some(m) => {
                walk.link(cell, from, m);
                walk.link(cell, m, to);
            }
            None => walk.link(cell, from, to),
        }
    }
}

/// Follows the boundary from the edge `h`, where a new cell begins, to the edge where it ends.
fn link_boundary(
    topology: &Topology,
    corners: &HashSet<VertexId>,
    label: &PerVertex<u32>,
    h: HalfEdgeId,
    walk: &mut OutlineWalk<'_>,
) {
    let mut at = topology.target(h);
    let cell = label[at];
    let mut from = Node::Edge(topology.edge(h));
    loop {
        if corners.contains(&at) {
            walk.link(cell, from, Node::Corner(at));
            from = Node::Corner(at);
        }
        let along = topology
            .outgoing(at)
            .next()
            .expect("every vertex has an outgoing half-edge");
        at = topology.target(along);
        if label[at] != cell {
            walk.link(cell, from, Node::Edge(topology.edge(along)));
            return;
        }
    }
}

fn add_closed_loops(topology: &Topology, walk: &OutlineWalk<'_>, outlines: &mut [Outline]) {
    let is_vertex = |n: &Node| match n {
        Node::Edge(e) => topology.is_boundary_edge(*e),
        _ => true,
    };
    let mut seen = IdSet::with_capacity_and_hasher(walk.order.len(), Default::default());
    for &(cell, start) in &walk.order {
        let (mut nodes, mut at) = (Vec::new(), start);
        while seen.insert((cell, at)) {
            nodes.push(at);
            match walk.next.get(&(cell, at)) {
                Some(&next) => at = next,
                None => outlines[cell as usize].open = true,
            }
        }
        if !nodes.is_empty() {
            nodes.retain(is_vertex);
            outlines[cell as usize].loops.push(nodes);
        }
    }
}
