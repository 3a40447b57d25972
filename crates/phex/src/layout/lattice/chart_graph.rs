//! Vertices that see their neighbours through charts: what waves diffuse over, and the same more
//! coarsely.
//!
//! Charts are turned first so that they agree along a spanning tree, and vertices are taken in the
//! order of that tree: almost no neighbour is seen turned then, and neighbours are near each other
//! in memory.

use super::boundary::{Pin, PinnedTo};
use super::charted::ChartedSurface;
use super::eisenstein::{Charts, Plane, Transition, rotate, waves};
use phex_mesh::{EdgeId, PerVertex, Topology, VertexId};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};
use std::collections::VecDeque;

/// Weight, over the area, of the hold on the offsets before.
pub(super) const ANCHOR: f64 = 1e-8;

/// A spanning tree along which charts agree once they are turned.
pub(super) struct Combing {
    /// Vertices in the order in which the tree reaches them.
    pub order: Vec<VertexId>,
    /// Place of each vertex in that order.
    pub rank: PerVertex<u32>,
    /// Sixths of a turn by which each vertex's chart is turned.
    pub turned: PerVertex<u8>,
}

impl Combing {
    /// Breadth first from the first vertex of each component.
    pub fn new(topology: &Topology, charts: &Charts) -> Self {
        let mut turned = PerVertex::filled(topology.n_vertices(), None);
        let mut order = Vec::with_capacity(topology.n_vertices());
        let mut queue = VecDeque::new();
        for root in topology.vertices() {
            if turned[root].is_none() {
                turned[root] = Some(0);
                queue.push_back(root);
            }
            while let Some(v) = queue.pop_front() {
                order.push(v);
                let here = turned[v].unwrap_or(0);
                for_each_view(topology, charts, v, |w, _, view| {
                    if turned[w].is_none() {
                        turned[w] = Some((here + view.turn) % 6);
                        queue.push_back(w);
                    }
                });
            }
        }
        let mut rank = PerVertex::filled(order.len(), 0);
        for (k, &v) in order.iter().enumerate() {
            rank[v] = k as u32;
        }
        Self {
            order,
            rank,
            turned: turned.map(|t| t.unwrap_or(0)),
        }
    }

    /// Values in the order of the tree.
    pub fn in_order<T>(&self, value: impl FnMut(VertexId) -> T) -> Vec<T> {
        self.order.iter().copied().map(value).collect()
    }

    /// Positions in turned charts, in the order of the tree, as those of the vertices in their own.
    pub fn restored(&self, positions: impl Iterator<Item = Plane>) -> PerVertex<Plane> {
        let mut restored = PerVertex::filled(self.order.len(), Plane::new(0.0, 0.0));
        for (&v, z) in self.order.iter().zip(positions) {
            restored[v] = rotate(z, 6 - self.turned[v]);
        }
        restored
    }

    /// The turn of a transition between turned charts, from `w` to `v`.
    fn turn(&self, v: VertexId, w: VertexId, view: Transition) -> u8 {
        (view.turn + self.turned[v] + 6 - self.turned[w]) % 6
    }
}

/// Calls `visit` for every neighbour of a vertex with the edge and the neighbour's transition to
/// the vertex.
pub(super) fn for_each_view(
    topology: &Topology,
    charts: &Charts,
    v: VertexId,
    mut visit: impl FnMut(VertexId, EdgeId, Transition),
) {
    for h in topology.outgoing(v) {
        let view = charts.half_edge(topology, h);
        visit(topology.target(h), topology.edge(h), view);
        let before = topology.prev(h);
        if topology.twin(before).is_none() {
            let view = charts.half_edge(topology, before).inverse();
            visit(topology.origin(before), topology.edge(before), view);
        }
    }
}

/// Lists of many vertices in one: those of vertex `v` are `start[v]..start[v + 1]`.
pub(super) struct Lists<T> {
    start: Vec<u32>,
    pub items: Vec<T>,
}

impl<T> Lists<T> {
    pub fn new() -> Self {
        Self {
            start: vec![0],
            items: Vec::new(),
        }
    }

    /// Ends a vertex's list.
    pub fn end(&mut self) {
        self.start.push(self.items.len() as u32);
    }

    #[inline]
    pub fn of(&self, v: usize) -> &[T] {
        &self.items[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

/// How a vertex sees a neighbour.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// The neighbour's number.
    pub to: u32,
    /// Sixths of a turn from its chart to the vertex's.
    pub turn: u8,
    /// Its position in the vertex's chart.
    pub offset: Plane,
    /// Weight of the edge.
    pub weight: f64,
}

/// What holds the three waves of a vertex.
#[derive(Clone, Copy, Default)]
pub(super) struct WaveHold {
    pub weight: [f64; 3],
    /// Weights times the values to which waves are drawn.
    pub drawn: [Plane; 3],
    /// Weights of the bonds between two waves that mirror planes across rows set, times the phase
    /// between them: `w_0 = c w_2`, `w_0 = c conj(w_1)`, `w_1 = c conj(w_2)`.
    pub bonds: [Plane; 3],
}

/// The waves that each bond binds.
pub(super) const BOUND: [[usize; 2]; 3] = [[0, 2], [0, 1], [1, 2]];

/// Vertices with charts, and how they see each other.
pub(super) struct ChartGraph {
    /// Areas.
    pub mass: Vec<f64>,
    pub views: Lists<View>,
    pub holds: Vec<WaveHold>,
}

/// The group of a vertex, and the position of the vertex's origin in the group's chart.
#[derive(Clone, Copy)]
pub(super) struct GroupMember {
    pub group: u32,
    pub offset: Plane,
}

impl GroupMember {
    /// No group yet.
    const NONE: Self = Self {
        group: u32::MAX,
        offset: Plane::new(0.0, 0.0),
    };

    fn is_free(&self) -> bool {
        self.group == Self::NONE.group
    }

    /// The vertex's position of a lattice point, from those of the groups.
    pub fn of(&self, groups: &[Plane]) -> Plane {
        groups[self.group as usize] - self.offset
    }
}

impl ChartGraph {
    /// The vertices of a surface in the order of the combing.
    pub fn new(charted: &ChartedSurface<'_>, combing: &Combing) -> Self {
        let ChartedSurface {
            topology,
            mesh,
            charts,
            pins,
        } = *charted;
        let mut views = Lists::new();
        for &v in &combing.order {
            for_each_view(topology, charts, v, |w, e, view| {
                views.items.push(View {
                    to: combing.rank[w],
                    turn: combing.turn(v, w, view),
                    offset: rotate(view.offset, combing.turned[v]),
                    weight: mesh.weight[e],
                });
            });
            views.end();
        }
        Self {
            mass: combing.in_order(|v| mesh.mass[v]),
            views,
            holds: combing.in_order(|v| WaveHold::of_pin(&pins[v], combing.turned[v])),
        }
    }

    /// Positions of a lattice point in the charts that fit all views best.
    ///
    /// # Errors
    /// If the system is singular to rounding.
    pub(crate) fn best_positions(&self) -> Result<Vec<Plane>, NumericError> {
        let n = self.mass.len();
        let (mut entries, mut rhs) = (Vec::new(), vec![Plane::new(0.0, 0.0); n]);
        for (v, rhs) in rhs.iter_mut().enumerate() {
            let mut own = ANCHOR * self.mass[v];
            for view in self.views.of(v) {
                own += view.weight;
                *rhs += view.offset * view.weight;
                if (view.to as usize) < v {
                    let seen = rotate(Plane::new(view.weight, 0.0), view.turn);
                    entries.push((v as u32, view.to, -seen));
                }
            }
            entries.push((v as u32, v as u32, Plane::new(own, 0.0)));
        }
        let matrix = SymmetricMatrix::from_triplets(n, entries.into_iter())?;
        let mut positions = rhs.clone();
        Cholesky::new(&matrix)?.precondition(&rhs, &mut positions);
        Ok(positions)
    }

    /// Vertices in groups of a few that are joined, charts of a group agreeing, and how groups see
    /// each other.
    pub fn coarse(&self) -> (Self, Vec<GroupMember>) {
        let (groups, members) = self.groups();
        let mut inside = vec![Vec::new(); groups];
        for (v, member) in members.iter().enumerate() {
            inside[member.group as usize].push(v);
        }
        let mut views = Lists::new();
        for inside in &inside {
            let first = views.items.len();
            for &v in inside {
                for view in self.views.of(v) {
                    let seen = seen_by_group(&members[v], view, &members[view.to as usize]);
                    if let Some(seen) = seen {
                        add_view(&mut views.items, first, seen);
                    }
                }
            }
            for view in &mut views.items[first..] {
                view.offset /= view.weight;
            }
            views.end();
        }
        let mut coarse = Self {
            mass: vec![0.0; groups],
            views,
            holds: vec![WaveHold::default(); groups],
        };
        for (v, member) in members.iter().enumerate() {
            let group = member.group as usize;
            coarse.mass[group] += self.mass[v];
            coarse.holds[group].add(&self.holds[v], member.offset);
        }
        (coarse, members)
    }

    /// A vertex with all its neighbours where those are free, and then what is left with a
    /// neighbour or alone.
    fn groups(&self) -> (usize, Vec<GroupMember>) {
        let mut members = vec![GroupMember::NONE; self.mass.len()];
        let mut groups = 0;
        for v in 0..members.len() {
            let is_free = |view: &View| members[view.to as usize].is_free();
            if !members[v].is_free() || !self.agreeing(v).all(is_free) {
                continue;
            }
            let mut join = |v: usize, offset| {
                members[v] = GroupMember {
                    group: groups,
                    offset,
                }
            };
            join(v, Plane::new(0.0, 0.0));
            self.agreeing(v).for_each(|w| join(w.to as usize, w.offset));
            groups += 1;
        }
        let grouped = members.clone();
        let left = members.iter_mut().enumerate();
        for (v, member) in left.filter(|(_, m)| m.is_free()) {
            *member = self.beside(v, &grouped).unwrap_or_else(|| {
                groups += 1;
                GroupMember {
                    group: groups - 1,
                    ..GroupMember::NONE
                }
            });
        }
        (groups as usize, members)
    }

    /// Neighbours whose charts are not turned.
    fn agreeing(&self, v: usize) -> impl Iterator<Item = &View> {
        self.views.of(v).iter().filter(|view| view.turn == 0)
    }

    /// A vertex as a member of its nearest neighbour's group, if one has a group.
    fn beside(&self, v: usize, members: &[GroupMember]) -> Option<GroupMember> {
        let near = self
            .agreeing(v)
            .filter(|w| !members[w.to as usize].is_free());
        let nearest = near.min_by(|a, b| a.offset.norm_sqr().total_cmp(&b.offset.norm_sqr()))?;
        let beside = members[nearest.to as usize];
        Some(GroupMember {
            group: beside.group,
            offset: beside.offset - nearest.offset,
        })
    }
}

/// How the group of a vertex sees that of a neighbour, the offset times the weight; `None` for the
/// same group, and where the edge has no weight. An edge is softer by its length over that of the
/// whole way between the groups' origins: so many of them lie on it one after the other.
fn seen_by_group(of: &GroupMember, view: &View, to: &GroupMember) -> Option<View> {
    let length = view.offset.norm();
    let way = length + of.offset.norm() + to.offset.norm();
    let weight = view.weight.max(0.0) * (length / way.max(f64::MIN_POSITIVE));
    let offset = of.offset + view.offset - rotate(to.offset, view.turn);
    (of.group != to.group && weight > 0.0).then(|| View {
        to: to.group,
        turn: view.turn,
        offset: offset * weight,
        weight,
    })
}

/// Adds weight and offset to those of the view of the same group.
fn add_view(views: &mut Vec<View>, first: usize, view: View) {
    let same = |v: &&mut View| v.to == view.to && v.turn == view.turn;
    match views[first..].iter_mut().find(same) {
        Some(known) => {
            known.weight += view.weight;
            known.offset += view.offset;
        }
        None => views.push(view),
    }
}

impl WaveHold {
    /// Weights times the values to which waves are drawn that have some values now.
    pub fn drawn_at(&self, waves: &[Plane; 3]) -> [Plane; 3] {
        let mut drawn = self.drawn;
        let [a, b, c] = *waves;
        let partners = [[c, a], [b.conj(), a.conj()], [c.conj(), b.conj()]];
        for (k, [p, q]) in partners.into_iter().enumerate() {
            let back = if k == 0 {
                self.bonds[k].conj()
            } else {
                self.bonds[k]
            };
            drawn[BOUND[k][0]] += self.bonds[k] * p;
            drawn[BOUND[k][1]] += back * q;
        }
        drawn
    }

    fn of_pin(pin: &Option<Pin>, turned: u8) -> Self {
        let mut hold = Self::default();
        if let Some(pin) = pin {
            let wave = (pin.wave + usize::from(turned)) % 3;
            // Half a row inside the wave is at its trough, on a row at its crest.
            let value = match pin.to {
                PinnedTo::HalfRow => -1.0,
                PinnedTo::Row => 1.0,
                PinnedTo::Column => {
                    BOUND[wave]
                        .iter()
                        .for_each(|m| hold.weight[*m] = pin.weight);
                    hold.bonds[wave] = Plane::new(pin.weight, 0.0);
                    return hold;
                }
            };
            hold.weight[wave] = pin.weight;
            hold.drawn[wave] = Plane::new(value * pin.weight, 0.0);
        }
        hold
    }

    /// Adds another vertex's hold, seen from a chart in which its origin lies at `offset`.
    fn add(&mut self, other: &Self, offset: Plane) {
        for (m, seen) in waves(offset).iter().enumerate() {
            self.weight[m] += other.weight[m];
            self.drawn[m] += seen * other.drawn[m];
        }
        let [a, b, c] = waves(offset);
        for (k, phase) in [a * c.conj(), a * b, b * c].iter().enumerate() {
            self.bonds[k] += phase * other.bonds[k];
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::curvature::curvature;
    use crate::directions::directions;
    use crate::directions::intrinsic::IntrinsicMesh;
    use phex_mesh::TriangleSurface;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    /// The charts of a shape, which turn against each other.
    pub(crate) fn charts_of(name: &str) -> (TriangleSurface, IntrinsicMesh, Charts) {
        let options = TriangulationOptions {
            triangles: 500,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &options).unwrap();
        let length = 0.2 * surface.diagonal();
        let curvature = curvature(&surface, length, &Default::default());
        let directions = directions(&surface, &curvature, length, &Default::default()).unwrap();
        let charts = Charts::new(surface.topology(), &directions);
        (surface, directions.intrinsic, charts)
    }

    /// Its vertices, free at the boundary.
    pub(crate) fn graph_of(name: &str) -> ChartGraph {
        let (surface, mesh, charts) = charts_of(name);
        let topology = surface.topology();
        let charted = ChartedSurface {
            topology,
            mesh: &mesh,
            charts: &charts,
            pins: &PerVertex::filled(topology.n_vertices(), None),
        };
        ChartGraph::new(&charted, &Combing::new(topology, &charts))
    }

    #[test]
    fn charts_are_turned_so_that_most_agree() {
        let (surface, _, charts) = charts_of("torus");
        let topology = surface.topology();
        let combing = Combing::new(topology, &charts);
        let (mut agree, mut all) = (0, 0);
        for v in topology.vertices() {
            for_each_view(topology, &charts, v, |w, _, view| {
                all += 1;
                agree += usize::from(combing.turn(v, w, view) == 0);
            });
        }
        assert!(agree > all * 4 / 5, "{agree} of {all}");
    }

    /// What vertex `v` sees, and what is seen of it from there, are the same edge.
    #[test]
    fn groups_see_each_other() {
        for name in ["torus", "sphere", "wave"] {
            let graph = graph_of(name);
            let (coarse, members) = graph.coarse();
            let groups = coarse.mass.len();
            assert!(groups * 4 < members.len() && groups * 12 > members.len());
            let [all, grouped] = [&graph, &coarse].map(|g| g.mass.iter().sum::<f64>());
            assert!((all - grouped).abs() < 1e-12 * all);
            for v in 0..groups {
                for view in coarse.views.of(v) {
                    let turned_back = |b: &View| (b.turn + view.turn).is_multiple_of(6);
                    let mut back = coarse.views.of(view.to as usize).iter();
                    let back = back.find(|b| b.to as usize == v && turned_back(b)).unwrap();
                    let round = rotate(back.offset, view.turn) + view.offset;
                    assert!(round.norm() < 1e-9, "{name}: {round}");
                    assert!((back.weight - view.weight).abs() < 1e-9 * view.weight);
                }
            }
        }
    }

    /// On a plane views fit each other: the best positions of groups are those of their vertices.
    #[test]
    fn positions_of_groups_are_those_of_their_vertices() {
        let graph = graph_of("plane");
        let (coarse, members) = graph.coarse();
        let groups = coarse.best_positions().unwrap();
        for (v, member) in members.iter().enumerate() {
            for view in graph.views.of(v) {
                let there = members[view.to as usize].of(&groups);
                let seen = rotate(there, view.turn) + view.offset;
                let apart = (member.of(&groups) - seen).norm();
                assert!(apart < 0.02 * view.offset.norm(), "{apart}");
            }
        }
    }
}
