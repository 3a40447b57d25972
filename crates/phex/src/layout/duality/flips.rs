//! Flips that make a triangulation of touching points convex in dual space.

use super::hull::behind;
use super::{DualityError, Plane, Quadric, clear_centre};
use phex_mesh::{EdgeId, FaceId, HexMesh, PerFace, PerVertex, Vec3, VertexId};
use std::collections::BTreeSet;

/// Flips per edge at the most: far more than are needed where the poles lie on a convex surface, and an end where they do not.
const FLIPS_PER_EDGE: usize = 20;

/// Panels joined as the hull of their planes' poles is, by [`convex_flips`], and the number of flips; nothing changes where no centre avoids the planes.
/// The hull does not depend on the centre: it is the dual of the convex body that the planes bound.
///
/// # Errors
/// If a plane passes through the centre that avoids them best.
pub fn convex_panels(
    mesh: &HexMesh,
    planes: &PerFace<Plane>,
    points: &PerFace<Vec3>,
) -> Result<(HexMesh, usize), DualityError> {
    let (centre, clearness) = clear_centre(planes.as_slice(), points.as_slice());
    if clearness <= 0.0 {
        return Ok((mesh.clone(), 0));
    }
    hull_about(mesh, planes, &Quadric::sphere(centre, 1.0)?)
}

/// The same with the poles in a given quadric, whose centre must lie on one side of all planes.
///
/// # Errors
/// If a plane passes through the centre.
pub fn hull_about(
    mesh: &HexMesh,
    planes: &PerFace<Plane>,
    quadric: &Quadric,
) -> Result<(HexMesh, usize), DualityError> {
    let pole = |(face, plane)| {
        let pole = quadric.pole(plane);
        pole.ok_or(DualityError::PoleAtInfinity { face })
    };
    let poles: Result<Vec<Vec3>, _> = planes.enumerate().map(pole).collect();
    Ok(convex_flips(mesh, &PerFace::from_vec(poles?)))
}

/// Panels whose touching points are joined as the poles are in their convex hull, inside the given rim.
///
/// An edge between two panels whose dual edge is reflex is replaced by one between the panels at its ends (Lawson's flips, seen from the
/// dual). On a convex dual surface this ends with the part of the hull that lies over the panels; every panel is then convex. Returns
/// the panels (positions are kept where a vertex is, new vertices get their old places) and the number of flips.
pub fn convex_flips(mesh: &HexMesh, poles: &PerFace<Vec3>) -> (HexMesh, usize) {
    let mut panels = Panels::new(mesh, poles);
    let mut waiting: BTreeSet<[u32; 2]> = panels.inner_edges.iter().copied().collect();
    let limit = FLIPS_PER_EDGE * waiting.len();
    let mut flips = 0;
    while let Some(edge) = waiting.pop_first() {
        let Some(star) = panels.star(edge) else {
            continue;
        };
        if flips == limit || !panels.is_reflex(&star) || !panels.can_flip(&star) {
            continue;
        }
        panels.flip(edge, &star);
        flips += 1;
        waiting.extend(panels.edges_round(edge));
    }
    if flips == 0 {
        return (mesh.clone(), 0);
    }
    let flipped = HexMesh::new(mesh.positions.as_slice().to_vec(), &panels.corners);
    flipped.map_or_else(|_| (mesh.clone(), 0), |m| (m, flips))
}

/// Outlines of the panels as lists of vertices, and the panels at each vertex inside.
struct Panels<'a> {
    corners: Vec<Vec<u32>>,
    /// The three panels at a vertex inside, counter-clockwise.
    around: PerVertex<Option<[u32; 3]>>,
    poles: &'a PerFace<Vec3>,
    /// 1 where the poles of panels round a vertex are seen counter-clockwise from outside their hull, else -1.
    sense: f64,
    inner_edges: Vec<[u32; 2]>,
}

/// The four panels at an edge: on its left and right, before its first and behind its second end.
struct Star {
    left: u32,
    right: u32,
    before: u32,
    behind: u32,
}

impl<'a> Panels<'a> {
    fn new(mesh: &HexMesh, poles: &'a PerFace<Vec3>) -> Self {
        let topology = mesh.topology();
        let around = PerVertex::from_fn(topology.n_vertices(), |v: VertexId| {
            let faces: Vec<u32> = topology
                .outgoing(v)
                .map(|h| topology.face(h).index() as u32)
                .collect();
            (!topology.is_boundary_vertex(v))
                .then(|| faces.try_into().ok())
                .flatten()
        });
        let inside = |e: EdgeId| {
            let ends = topology.edge_vertices(e);
            let inner = ends.iter().all(|v| around[*v].is_some());
            inner.then(|| sorted(ends.map(|v| v.index() as u32)))
        };
        let mut panels = Self {
            corners: topology.face_lists(),
            inner_edges: topology.edges().filter_map(inside).collect(),
            around,
            poles,
            sense: 1.0,
        };
        let stars = panels.inner_edges.iter().filter_map(|e| panels.star(*e));
        let votes: f64 = stars.map(|s| panels.bend(&s).signum()).sum();
        panels.sense = if votes < 0.0 { -1.0 } else { 1.0 };
        panels
    }

    fn faces_at(&self, v: u32) -> Option<[u32; 3]> {
        self.around[VertexId::new(v)]
    }

    /// The panels round an edge; `None` if its vertices are no longer neighbours.
    fn star(&self, [a, b]: [u32; 2]) -> Option<Star> {
        let (at_a, at_b) = (self.faces_at(a)?, self.faces_at(b)?);
        let follows = |f: &u32, p: u32, q: u32| {
            let list = &self.corners[*f as usize];
            let i = list.iter().position(|&v| v == p);
            i.is_some_and(|i| list[(i + 1) % list.len()] == q)
        };
        let left = at_a.into_iter().find(|f| follows(f, a, b))?;
        let right = at_a.into_iter().find(|f| follows(f, b, a))?;
        let other = |faces: [u32; 3]| faces.into_iter().find(|&f| f != left && f != right);
        Some(Star {
            left,
            right,
            before: other(at_a)?,
            behind: other(at_b)?,
        })
    }

    /// Positive where the dual edge is convex, with the sense of the panels.
    fn bend(&self, star: &Star) -> f64 {
        let pole = |f: u32| self.poles[FaceId::new(f)];
        // Round the first end the panels run: left, before, right.
        let (left, before, right) = (pole(star.left), pole(star.before), pole(star.right));
        self.sense * behind(left, before, right, pole(star.behind))
    }

    fn is_reflex(&self, star: &Star) -> bool {
        self.bend(star) < 0.0
    }

    /// Panels keep three corners, and two panels share one edge at the most.
    fn can_flip(&self, star: &Star) -> bool {
        let valence = |f: u32| self.corners[f as usize].len();
        let shared = self.corners[star.before as usize]
            .iter()
            .filter(|v| self.corners[star.behind as usize].contains(v));
        valence(star.left) > 3 && valence(star.right) > 3 && shared.count() == 0
    }

    /// Afterwards the first vertex has the left panel, the second the right one, and both the panels at the ends.
    fn flip(&mut self, [a, b]: [u32; 2], star: &Star) {
        let Star {
            left,
            right,
            before,
            behind,
        } = *star;
        self.corners[left as usize].retain(|&v| v != b);
        self.corners[right as usize].retain(|&v| v != a);
        // The panel before comes from the right panel's side to the left one's, the panel behind goes the other way.
        replace(&mut self.corners[before as usize], a, [b, a]);
        replace(&mut self.corners[behind as usize], b, [a, b]);
        self.around[VertexId::new(a)] = Some([left, before, behind]);
        self.around[VertexId::new(b)] = Some([right, behind, before]);
    }

    fn edges_round(&self, edge: [u32; 2]) -> Vec<[u32; 2]> {
        let at = |v: u32| {
            let faces = self.faces_at(v).into_iter().flatten();
            faces.filter_map(move |f| {
                let list = &self.corners[f as usize];
                let i = list.iter().position(|&w| w == v)?;
                let next = list[(i + 1) % list.len()];
                self.faces_at(next).map(|_| sorted([v, next]))
            })
        };
        edge.into_iter().flat_map(at).collect()
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn replace(list: &mut Vec<u32>, old: u32, new: [u32; 2]) {
    if let Some(i) = list.iter().position(|&v| v == old) {
        list.splice(i..=i, new);
    }
}
