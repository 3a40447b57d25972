//! Edges collapse, the shortest first, until as many vertices are left as are wanted.

use super::corner_table::{next, prev};
use super::{ChangingMesh, flips};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What an edge on the boundary or on a crease is longer by where the shortest is sought: these
/// lines are sampled more finely.
const LINE: f64 = 1.5;

/// Cosine of the angle by which a triangle may turn.
const TURN: f64 = 0.8;
/// Cosine of the angle between the normals at the ends of an edge up to which it may collapse:
/// panels that resolve a surface are no longer than 0.8 of its least radius of curvature, and five
/// vertices apart on each of them make 0.16.
const BEND: f64 = 0.98;
/// Least quality of a triangle, or that of the worst one round the vertex that goes: among thin
/// triangles in rows, each is a little thinner until its neighbours follow.
const QUALITY: f64 = 0.3;
/// Longest edge, in units of the spacing.
const LONGEST: f64 = 1.8;
/// Farthest that the boundary or a crease may move, in units of the spacing.
const OFF: f64 = 0.02;
/// Shortest edge that stays, in units of the spacing: where lines keep many vertices, their
/// neighbourhood is not to pay for it.
const SPACED: f64 = 1.0;
/// Share of the vertices that must go in a round for another to be made.
const WORTHWHILE: f64 = 0.002;

/// Collapses edges until `wanted` vertices are left, or none can.
pub(super) fn collapse_short(mesh: &mut ChangingMesh, wanted: usize) {
    while mesh.table.n_vertices() > wanted {
        let before = mesh.table.n_vertices();
        collapse_to(mesh, wanted.max(before / 2));
        flips::turn_edges(mesh);
        let gone = before - mesh.table.n_vertices();
        if (gone as f64) < WORTHWHILE * before as f64 {
            break;
        }
    }
}

/// Edges by their lengths, the shortest first. Those that a round begins with are sorted once: in a
/// heap of millions every step would wait for memory.
struct Queue {
    /// The first edges, the shortest last.
    first: Vec<(u64, u32)>,
    /// Those whose length has changed since.
    changed: BinaryHeap<Reverse<(u64, u32)>>,
    /// The length with which each edge waits, as bits; [`TAKEN`] for none.
    waits: Vec<u64>,
}

/// The bits of no length.
const TAKEN: u64 = u64::MAX;

impl Queue {
    fn of(mesh: &ChangingMesh) -> Self {
        let edges = mesh.table.edges();
        let mut first: Vec<(u64, u32)> = edges.map(|h| (key(mesh, h), h)).collect();
        let mut waits = vec![TAKEN; mesh.table.n_half_edges()];
        first.iter().for_each(|(k, h)| waits[*h as usize] = *k);
        first.sort_unstable_by_key(|e| Reverse(*e));
        Self {
            first,
            changed: BinaryHeap::new(),
            waits,
        }
    }

    /// Puts an edge with its length of now.
    fn push(&mut self, mesh: &ChangingMesh, h: u32) {
        let key = key(mesh, h);
        let waits = &mut self.waits[h as usize];
        if *waits != key {
            *waits = key;
            self.changed.push(Reverse((key, h)));
        }
    }

    /// The shortest edge that waits with the length that it has.
    fn pop(&mut self) -> Option<u32> {
        loop {
            let next = self.changed.peek().map(|e| e.0);
            let (key, h) = match (self.first.last(), next) {
                (Some(a), Some(b)) if *a > b => self.changed.pop().map(|e| e.0),
                (Some(_), _) => self.first.pop(),
                (None, _) => self.changed.pop().map(|e| e.0),
            }?;
            let waits = &mut self.waits[h as usize];
            if *waits == key {
                *waits = TAKEN;
                return Some(h);
            }
        }
    }
}

fn collapse_to(mesh: &mut ChangingMesh, wanted: usize) {
    let mut queue = Queue::of(mesh);
    while mesh.table.n_vertices() > wanted {
        let Some(h) = queue.pop() else {
            return;
        };
        let names = mesh.table.is_there(h) && mesh.table.edge(h) == h;
        if !names || !mesh.table.can_collapse(h) {
            continue;
        }
        if weight(mesh, h) > SPACED {
            return;
        }
        let [u, v] = mesh.table.ends(h);
        let ways = [(u, v), (v, u)].map(|(removed, kept)| worth(mesh, h, removed, kept));
        let (removed, kept) = match ways {
            [None, None] => continue,
            [a, b] if a >= b => (u, v),
            _ => (v, u),
        };
        mesh.table.collapse(h, removed, kept);
        mesh.gone[removed as usize] = true;
        for edge in mesh.table.edges_at(kept) {
            queue.push(mesh, edge);
        }
    }
}

/// Length by which edges are ordered, in units of the spacing.
fn weight(mesh: &ChangingMesh, h: u32) -> f64 {
    let line = mesh.table.twin(h).is_none() || mesh.table.is_crease(h);
    mesh.length(h) * if line { LINE } else { 1.0 }
}

/// The same as bits, which sort as the lengths do.
fn key(mesh: &ChangingMesh, h: u32) -> u64 {
    weight(mesh, h).to_bits()
}

/// Quality of the worst triangle if `removed` moves to `kept`; `None` if that must not be.
fn worth(mesh: &ChangingMesh, h: u32, removed: u32, kept: u32) -> Option<f64> {
    let [m, n] = [removed, kept].map(|v| mesh.normal[v as usize]);
    if mesh.corner[removed as usize] || m.dot(&n) < BEND || !stays_on_lines(mesh, h, removed, kept)
    {
        return None;
    }
    let quality = |g: u32| mesh.quality([g, next(g), prev(g)].map(|k| mesh.table.origin(k)));
    let ring = mesh.table.outgoing(removed).map(quality);
    let least = ring.fold(QUALITY, f64::min);
    let mut worst = f64::INFINITY;
    for g in mesh.table.outgoing(removed) {
        let [b, c] = [next(g), prev(g)].map(|k| mesh.table.origin(k));
        if b == kept || c == kept {
            continue;
        }
        let (old, new) = ([removed, b, c], [kept, b, c]);
        let [before, after] = [old, new].map(|t| mesh.area_vector(t));
        if after.dot(&before) < TURN * after.norm() * before.norm() {
            return None;
        }
        let quality = mesh.quality(new);
        if quality < least || too_long(mesh, kept, b) {
            return None;
        }
        worst = worst.min(quality);
    }
    Some(worst)
}

fn too_long(mesh: &ChangingMesh, u: u32, v: u32) -> bool {
    (mesh.place(u) - mesh.place(v)).norm() > LONGEST * mesh.spacing
}

/// Whether a vertex of the boundary or of a crease stays on it, and the line where it is.
fn stays_on_lines(mesh: &ChangingMesh, h: u32, removed: u32, kept: u32) -> bool {
    let table = &mesh.table;
    let is_line = |g: u32| table.twin(g).is_none() || table.is_crease(g);
    let lines: Vec<u32> = table.edges_at(removed).filter(|g| is_line(*g)).collect();
    let other = match lines.as_slice() {
        [] => return true,
        [g, k] if table.edge(*g) == table.edge(h) => *k,
        [g, k] if table.edge(*k) == table.edge(h) => *g,
        _ => return false,
    };
    let [a, b] = table.ends(other);
    let far = mesh.place(if a == removed { b } else { a });
    let (along, to) = (mesh.place(kept) - far, mesh.place(removed) - far);
    let t = (to.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (to - along * t).norm() <= OFF * mesh.spacing
}
