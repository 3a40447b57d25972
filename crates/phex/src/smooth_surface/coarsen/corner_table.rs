//! A triangle mesh that changes: edges collapse and turn.
//!
//! Half-edge `3 f + k` is the `k`-th side of triangle `f`, so only its origin and its twin are
//! stored. Half-edges of a triangle that is gone have no origin, and vertices that are gone no
//! half-edge.

use phex_mesh::{HalfEdgeId, PerEdge, Topology};

/// No half-edge, no vertex.
pub(super) const NONE: u32 = u32::MAX;

/// See the module.
pub(super) struct CornerTable {
    origin: Vec<u32>,
    twin: Vec<u32>,
    /// For an inner vertex any half-edge that leaves it, for one at the boundary the one without a
    /// twin.
    outgoing: Vec<u32>,
    /// Whether a side lies on a crease, told by both of its half-edges.
    crease: Vec<bool>,
    n_vertices: usize,
}

/// The next side of a triangle.
pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The side before.
pub(super) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl CornerTable {
    /// The table of a triangle mesh.
    pub fn of(topology: &Topology, creases: &PerEdge<bool>) -> Self {
        let half_edge = |h: Option<HalfEdgeId>| h.map_or(NONE, |h| h.index() as u32);
        let first = |v| half_edge(topology.outgoing(v).next());
        let all = || topology.half_edges();
        Self {
            origin: all().map(|h| topology.origin(h).index() as u32).collect(),
            twin: all().map(|h| half_edge(topology.twin(h))).collect(),
            outgoing: topology.vertices().map(first).collect(),
            crease: all().map(|h| creases[topology.edge(h)]).collect(),
            n_vertices: topology.n_vertices(),
        }
    }

    /// Number of vertices that are left.
    pub fn n_vertices(&self) -> usize {
        self.n_vertices
    }

    /// Number of half-edges, with those that are gone.
    pub fn n_half_edges(&self) -> usize {
        self.origin.len()
    }

    pub fn origin(&self, h: u32) -> u32 {
        self.origin[h as usize]
    }

    pub fn target(&self, h: u32) -> u32 {
        self.origin[next(h) as usize]
    }

    pub fn ends(&self, h: u32) -> [u32; 2] {
        [self.origin(h), self.target(h)]
    }

    pub fn twin(&self, h: u32) -> Option<u32> {
        let twin = self.twin[h as usize];
        (twin != NONE).then_some(twin)
    }

    /// Whether a half-edge belongs to a triangle that is left.
    pub fn is_there(&self, h: u32) -> bool {
        self.origin[h as usize] != NONE
    }

    pub fn is_crease(&self, h: u32) -> bool {
        self.crease[h as usize]
    }

    /// The one half-edge that names an edge: that without a twin, or the lower of the two.
    pub fn edge(&self, h: u32) -> u32 {
        self.twin(h).map_or(h, |t| h.min(t))
    }

    /// Edges that are left, each by the half-edge that names it.
    pub fn edges(&self) -> impl Iterator<Item = u32> {
        let all = 0..self.origin.len() as u32;
        all.filter(|&h| self.is_there(h) && self.edge(h) == h)
    }

    /// Triangles that are left.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let triangles = self.origin.chunks_exact(3);
        let there = triangles.filter(|t| t[0] != NONE);
        there.map(|t| [t[0], t[1], t[2]])
    }

    /// Half-edges that leave a vertex, counter-clockwise.
    pub fn outgoing(&self, v: u32) -> impl Iterator<Item = u32> {
        let first = self.outgoing[v as usize];
        let turned = move |h: &u32| self.twin(prev(*h)).filter(|t| *t != first);
        std::iter::successors((first != NONE).then_some(first), turned)
    }

    /// Whether a vertex lies on the boundary.
    pub fn is_boundary(&self, v: u32) -> bool {
        self.twin(self.outgoing[v as usize]).is_none()
    }

    /// Vertices round a vertex, counter-clockwise.
    pub fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> {
        let last = |h: u32| self.twin(prev(h)).is_none().then(|| self.origin(prev(h)));
        let both = move |h: u32| std::iter::once(self.target(h)).chain(last(h));
        self.outgoing(v).flat_map(both)
    }

    /// Half-edges that name the edges at a vertex.
    pub fn edges_at(&self, v: u32) -> impl Iterator<Item = u32> {
        let last = |h: u32| self.twin(prev(h)).is_none().then(|| prev(h));
        let both = move |h: u32| std::iter::once(self.edge(h)).chain(last(h));
        self.outgoing(v).flat_map(both)
    }

    fn join(&mut self, g: Option<u32>, h: Option<u32>) {
        for (g, h) in [(g, h), (h, g)] {
            if let Some(g) = g {
                self.twin[g as usize] = h.unwrap_or(NONE);
            }
        }
    }

    /// Whether the surface stays the manifold that it is, with its boundary loops, if an edge
    /// collapses (T. Dey et al., "Topology preserving edge contraction", 1999).
    pub fn can_collapse(&self, h: u32) -> bool {
        let [u, v] = self.ends(h);
        let sides = [Some(h), self.twin(h)].into_iter().flatten();
        let mut opposite = 0;
        for side in sides.clone() {
            let outer = [next(side), prev(side)].map(|k| self.twin(k));
            let apex = self.origin(prev(side));
            let least = if self.is_boundary(apex) { 3 } else { 4 };
            if outer == [None, None] || self.neighbours(apex).count() < least {
                return false;
            }
            opposite += 1;
        }
        let boundary = |w: u32| self.is_boundary(w);
        if boundary(u) && boundary(v) && self.twin(h).is_some() {
            return false;
        }
        let shared = |w: &u32| self.neighbours(v).any(|x| x == *w);
        self.neighbours(u).filter(shared).count() == opposite
    }

    /// Collapses an edge, of whose ends `removed` goes and `kept` stays.
    pub fn collapse(&mut self, h: u32, removed: u32, kept: u32) {
        let there = |g: &u32| self.is_there(*g);
        let of = |v: u32| self.outgoing(v).filter(there).collect::<Vec<u32>>();
        let (moving, staying) = (of(removed), of(kept));
        for g in &moving {
            self.origin[*g as usize] = kept;
        }
        for side in [Some(h), self.twin(h)].into_iter().flatten() {
            self.close(side);
        }
        self.outgoing[removed as usize] = NONE;
        self.n_vertices -= 1;
        let left = moving.into_iter().chain(staying);
        if let Some(g) = left.into_iter().find(|g| self.is_there(*g)) {
            self.settle(kept, g);
        }
    }

    /// Takes out the triangle at a side, whose other two sides become one.
    fn close(&mut self, side: u32) {
        let (n, p) = (next(side), prev(side));
        let apex = self.origin(p);
        let [outer, other] = [n, p].map(|k| self.twin(k));
        if self.outgoing[apex as usize] == p {
            self.outgoing[apex as usize] = outer.unwrap_or(NONE);
        }
        let crease = self.is_crease(n) || self.is_crease(p);
        self.join(outer, other);
        for g in [outer, other].into_iter().flatten() {
            self.crease[g as usize] = crease;
        }
        for k in [side, n, p] {
            self.origin[k as usize] = NONE;
        }
    }

    /// Makes `h`, or the one at the boundary, the half-edge that leaves a vertex.
    fn settle(&mut self, v: u32, h: u32) {
        let mut first = h;
        while let Some(t) = self.twin(first) {
            first = next(t);
            if first == h {
                break;
            }
        }
        self.outgoing[v as usize] = first;
    }

    /// The vertices across an inner edge, left and right of `h`.
    pub fn apexes(&self, h: u32) -> Option<[u32; 2]> {
        let t = self.twin(h)?;
        Some([h, t].map(|k| self.origin(prev(k))))
    }

    /// Turns an inner edge within the quadrangle of its two triangles.
    pub fn flip(&mut self, h: u32) {
        let Some(t) = self.twin(h) else { return };
        let [u, v] = self.ends(h);
        let [a, b] = [h, t].map(|k| self.origin(prev(k)));
        let [n, p, m, q] = [next(h), prev(h), next(t), prev(t)];
        let old = [n, p, m, q].map(|k| (self.twin(k), self.is_crease(k)));
        for (k, w) in [(h, a), (n, b), (p, v), (t, b), (m, a), (q, u)] {
            self.origin[k as usize] = w;
        }
        // From `v` to `a`, from `a` to `u`, from `u` to `b`, from `b` to `v`.
        for (k, (twin, crease)) in [p, m, q, n].into_iter().zip(old) {
            self.join(Some(k), twin);
            self.crease[k as usize] = crease;
        }
        for (w, gone, now) in [
            (u, [h, m], q),
            (v, [t, n], p),
            (a, [p, p], m),
            (b, [q, q], n),
        ] {
            if gone.contains(&self.outgoing[w as usize]) {
                self.outgoing[w as usize] = now;
            }
        }
    }
}
