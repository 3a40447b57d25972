//! Pairs of small panels that are better one.
//!
//! About a cone the lattice's offsets do not close, and the lattice point at its apex may be named
//! twice; its panel then comes out as two small pentagons with a heptagon beside them, next to each
//! other or one panel apart. Two neighbours inside that together are hardly larger than one should
//! be become one where that, with a few edges turned afterwards, makes the panels more regular: a
//! dislocation climbs by one panel.

use super::glide::Sides;
use super::{flips, glide};
use crate::layout::Layout;
use crate::layout::lattice::eisenstein::CELL;
use crate::progress::Progress;
use phex_mesh::{EdgeId, FaceId, FlatFace, HexMesh, PerFace, PerVertex, Topology, VertexId};
use std::collections::BTreeSet;

/// Largest area of one of them, and of both together, over that of a panel of the size wanted
/// there.
const HALF: f64 = 1.2;
const BOTH: f64 = 1.8;

/// Joins pairs while that makes the layout more regular.
pub(crate) fn join_halves(mut layout: Layout, progress: &dyn Progress) -> Layout {
    loop {
        let joins = joins(&layout, progress);
        if joins.is_empty() {
            return layout;
        }
        let one = || {
            joins
                .iter()
                .find_map(|j| joined(&layout, std::slice::from_ref(j)))
        };
        // Side by side they rarely are no mesh, though each of them alone is one.
        match joined(&layout, &joins).or_else(one) {
            Some(next) => layout = next,
            None => return layout,
        }
    }
}

/// A pair to be joined, and the turns after that.
struct Join {
    pair: PanelPair,
    turns: Vec<Sides>,
}

/// Pairs that make the layout more regular where they are joined, no two of which change the same
/// panel.
fn joins(layout: &Layout, progress: &dyn Progress) -> Vec<Join> {
    let topology = layout.mesh.topology();
    let mut taken = BTreeSet::new();
    let pairs = topology.edges().filter_map(|e| pair(topology, e));
    let small = pairs.filter(|p| has_pentagon(topology, p) && are_halves(layout, p));
    let mut found = Vec::new();
    for pair in small {
        if progress.is_cancelled() {
            return Vec::new();
        }
        if let Some((turns, changed)) = glide::turns_after_join(topology, pair.halves, &taken) {
            taken.extend(changed);
            found.push(Join { pair, turns });
        }
    }
    found
}

/// Two panels, the panels at the ends of their common edge, and that edge's ends.
struct PanelPair {
    halves: [FaceId; 2],
    at_ends: [FaceId; 2],
    ends: [VertexId; 2],
}

fn pair(topology: &Topology, e: EdgeId) -> Option<PanelPair> {
    let h = topology.edge_half_edge(e);
    let [before, after] = [topology.prev(h), topology.next(h)].map(|h| topology.across(h));
    let at_ends = [before?, after?];
    let halves = topology.faces_beside(e)?;
    let all: BTreeSet<FaceId> = halves.iter().chain(&at_ends).copied().collect();
    let inside = all.iter().all(|f| !topology.is_boundary_face(*f));
    (all.len() == 4 && inside).then_some(PanelPair {
        halves,
        at_ends,
        ends: topology.edge_vertices(e),
    })
}

fn has_pentagon(topology: &Topology, pair: &PanelPair) -> bool {
    pair.halves.iter().any(|f| topology.valence(*f) < 6)
}

fn are_halves(layout: &Layout, pair: &PanelPair) -> bool {
    let [a, b] = pair.halves.map(|f| area(layout, f));
    a.max(b) < HALF && a + b < BOTH
}

/// Area of a panel over that of a cell of its size.
fn area(layout: &Layout, f: FaceId) -> f64 {
    FlatFace::of(&layout.mesh, f).area() / (CELL * layout.face_length[f].powi(2))
}

/// The layout with the second halves given to the first, whose seeds stay, and with edges turned
/// afterwards; `None` if that is no mesh.
fn joined(layout: &Layout, joins: &[Join]) -> Option<Layout> {
    let topology = layout.mesh.topology();
    let mut faces = topology.face_lists();
    let mut face_point = layout.face_point.clone();
    let mut gone = PerVertex::filled(topology.n_vertices(), false);
    let mut given = PerFace::filled(topology.n_faces(), false);
    for Join { pair, .. } in joins {
        let [first, second] = pair.halves;
        join_outlines(topology, &mut faces, pair);
        face_point[first] = (face_point[first] + face_point[second]) * 0.5;
        given[second] = true;
        pair.ends.iter().for_each(|v| gone[*v] = true);
    }
    let vertices: Vec<VertexId> = topology.vertices().filter(|v| !gone[*v]).collect();
    let kept: Vec<FaceId> = topology.faces().filter(|f| !given[*f]).collect();
    let mut number = PerVertex::filled(topology.n_vertices(), 0);
    (vertices.iter().zip(0u32..)).for_each(|(v, i)| number[*v] = i);
    let lists = kept.iter().map(|f| {
        let list = faces[f.index()].iter();
        list.map(|w| number[VertexId::new(*w)]).collect()
    });
    let lists: Vec<Vec<u32>> = lists.collect();
    let positions = vertices.iter().map(|v| layout.mesh.position(*v)).collect();
    let mesh = HexMesh::new(positions, &lists).ok()?;
    let joined = Layout {
        face_point: face_point.picked(&kept),
        ..layout.part(mesh, &vertices, &kept)
    };
    flips::turned_between(joined, &renumbered(joins, &kept, topology.n_faces()))
}

/// The outline of the first half goes round the second, too, and the panels at the ends of their
/// common edge lose a corner.
fn join_outlines(topology: &Topology, faces: &mut [Vec<u32>], pair: &PanelPair) {
    let [first, second] = pair.halves;
    let [u, v] = pair.ends;
    let mut outline = after_edge(topology.face_vertices(first), u, v);
    outline.extend(after_edge(topology.face_vertices(second), v, u));
    faces[first.index()] = outline.iter().map(|w| w.index() as u32).collect();
    let gone = [u, v].map(|w| w.index() as u32);
    for f in pair.at_ends {
        faces[f.index()].retain(|w| !gone.contains(w));
    }
}

/// The turns after joins, by the numbers of the panels that are kept.
fn renumbered(joins: &[Join], kept: &[FaceId], n_faces: usize) -> Vec<Vec<Sides>> {
    let mut number = PerFace::filled(n_faces, FaceId::new(0));
    (kept.iter().zip(0..)).for_each(|(f, i)| number[*f] = FaceId::new(i));
    let turns = joins.iter().map(|j| j.turns.iter());
    turns
        .map(|t| t.map(|s| s.map(|f| number[f])).collect())
        .collect()
}

/// The corners of an outline behind the edge from `u` to `v`, without its ends.
fn after_edge(outline: &[VertexId], u: VertexId, v: VertexId) -> Vec<VertexId> {
    let n = outline.len();
    let at = (0..n).find(|i| outline[*i] == u && outline[(i + 1) % n] == v);
    let start = at.map_or(0, |i| i + 2);
    (0..n - 2).map(|k| outline[(start + k) % n]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{cut_in_two, lattice_patch};
    use crate::progress::Silent;

    /// A panel of a lattice cut in two: its halves are joined, and all is as before.
    #[test]
    fn a_panel_cut_in_two_is_whole_again() {
        let layout = lattice_patch(5);
        let cut = cut_in_two(&layout, FaceId::new(12));
        assert_eq!(cut.mesh.topology().n_faces(), 26);
        let after = join_halves(cut, &Silent);
        assert_eq!(after.mesh.topology().n_faces(), 25);
        let topology = after.mesh.topology();
        // The patch has rim panels with fewer neighbours, but all are hexagons.
        assert!(topology.faces().all(|f| topology.valence(f) == 6));
        assert_eq!(after.vertex_kind.len(), topology.n_vertices());
    }

    /// Panels of a lattice are no halves.
    #[test]
    fn whole_panels_stay() {
        let layout = lattice_patch(4);
        let after = join_halves(layout.clone(), &Silent);
        assert_eq!(
            after.mesh.topology().face_lists(),
            layout.mesh.topology().face_lists()
        );
    }
}
