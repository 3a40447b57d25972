//! Slivers taken over by the panels behind them.
//!
//! A sliver at the boundary whose neighbours lie in other planes goes if a neighbour's plane is
//! continued over it: the edges that ended at the sliver's inner corners go on along their lines,
//! in which two planes meet, to the boundary curve, and the boundary is followed in the neighbour's
//! plane. Where those lines meet before the boundary the neighbours on both sides share the sliver.
//! So panels stay planar exactly, and interior vertices keep their degree.

use super::curve::Curve;
use super::follow::is_simple;
use super::{Trimmed, compact, grow, omit};
use nalgebra::Matrix3;
use phex_mesh::{
    FaceId, FacePlane, FlatFace, HalfEdgeId, HexMesh, LEAST_RIM_AREA, PerFace, Vec3, VertexId,
    small_rim_faces,
};
use std::collections::BTreeSet;

/// Share of the sliver's area by which the area may change.
const SPARE: f64 = 0.3;
/// How far an edge goes on, in lengths of the sliver's edge beside it.
const REACH: f64 = 3.0;
/// What small panels lack less, areas of one that is not small, is worth a change.
const LESS: f64 = 0.05;
/// Steps in which the place is sought where it leaves the surface, and bisections that locate it.
const STEPS: usize = 24;
const BISECTIONS: usize = 40;

/// How neighbours take slivers over.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Takeover {
    /// Clearance that changed panels keep, mean edges.
    pub room: f64,
    /// Whether those on both sides may share a sliver; they get long then.
    pub shared: bool,
    /// Whether panels were cut: slivers then also grow into their neighbours, or are left out where
    /// they are narrow.
    pub cut: bool,
}

/// Clearance, mean edges, that panels keep which take over parts of cut ones.
const ROOM_OF_CUTS: f64 = 0.06;

impl Takeover {
    /// Of panels that were cut along the boundary.
    pub fn of_cuts() -> Self {
        Self {
            room: ROOM_OF_CUTS,
            shared: false,
            cut: true,
        }
    }
}

/// Lets neighbours take over small panels at the boundary, where there are fewer small ones
/// afterwards. `inside` tells whether a point lies on the surface's side of the boundary.
pub(super) fn without_slivers(
    mut trimmed: Trimmed,
    inside: &impl Fn(Vec3) -> bool,
    curve: &Curve,
    how: Takeover,
) -> Trimmed {
    let room = how.room * trimmed.mesh.mean_edge();
    let mut tried: BTreeSet<FaceId> = BTreeSet::new();
    loop {
        let small = small_rim_faces(&trimmed.mesh);
        // A panel that was cut may leave several slivers.
        let name = |f: FaceId| if how.cut { f } else { trimmed.parent[f] };
        let open = small.iter().find(|f| !tried.contains(&name(**f)));
        let Some(&sliver) = open else {
            return trimmed;
        };
        tried.insert(name(sliver));
        let heirs = heirs(&trimmed.mesh, sliver);
        let taken = heirs.iter().flat_map(|heir| {
            let whole = heir.take_over(&trimmed, inside, curve, room);
            let shared = || heir.close_over(&trimmed, inside, curve, room);
            whole.or_else(|| how.shared.then(shared)?)
        });
        let before = smallness(&trimmed.mesh, &small);
        let better = |next: &Trimmed| {
            let small = small_rim_faces(&next.mesh);
            let (count, lacking) = smallness(&next.mesh, &small);
            // What goes makes the mean larger, and with it what is small.
            let less = how.cut && count == before.0 && lacking < before.1 - LESS;
            count < before.0 || less
        };
        let grown = || grow::grown(&trimmed, sliver, curve, room);
        let left_out = || omit::without(&trimmed, sliver, curve);
        let next = taken.into_iter().find(better);
        let next = next.or_else(|| how.cut.then(grown)?.filter(better));
        let next = next.or_else(|| how.cut.then(left_out)?.filter(better));
        if let Some(next) = next {
            trimmed = next;
            if how.cut {
                // Numbers have changed, and there is less to do each time, so this ends.
                tried.clear();
            }
        }
    }
}

/// How many faces are small, and how much area they lack, in areas of one that is not.
fn smallness(mesh: &HexMesh, small: &[FaceId]) -> (usize, f64) {
    let n = mesh.topology().n_faces() as f64;
    let area = |f: FaceId| FlatFace::of(mesh, f).area();
    let least = LEAST_RIM_AREA * mesh.topology().faces().map(area).sum::<f64>() / n;
    let lacking = small.iter().map(|f| 1.0 - area(*f) / least);
    (small.len(), lacking.sum())
}

/// A neighbour that could take over a sliver.
struct Heir {
    sliver: FaceId,
    /// The sliver's edge to it.
    edge: HalfEdgeId,
    /// The sliver's edge before that, to a neighbour at the boundary, if there is one; and the one
    /// after it.
    sides: [Option<HalfEdgeId>; 2],
}

/// Who could take over a sliver with one stretch of boundary: whoever has the middle of the edges
/// inside.
fn heirs(mesh: &HexMesh, sliver: FaceId) -> Vec<Heir> {
    let Some(chain) = grow::inner_chain(mesh.topology(), sliver) else {
        return Vec::new();
    };
    let heir = |j: usize| Heir {
        sliver,
        edge: chain[j],
        sides: [
            j.checked_sub(1).map(|i| chain[i]),
            chain.get(j + 1).copied(),
        ],
    };
    match chain.len() {
        1 => vec![heir(0)],
        2 => vec![heir(0), heir(1)],
        3 => vec![heir(1)],
        _ => Vec::new(),
    }
}

/// Positions and faces that are being changed.
struct DissolveDraft<'a> {
    mesh: &'a HexMesh,
    curve: &'a Curve,
    positions: Vec<Vec3>,
    faces: Vec<Vec<u32>>,
}

impl Heir {
    /// The mesh without the sliver; `None` where that gives no sound panels.
    fn take_over(
        &self,
        trimmed: &Trimmed,
        inside: &impl Fn(Vec3) -> bool,
        curve: &Curve,
        room: f64,
    ) -> Option<Trimmed> {
        let mesh = &trimmed.mesh;
        let topology = mesh.topology();
        let across = |h: HalfEdgeId| topology.twin(h).map(|t| topology.face(t));
        let heir = across(self.edge)?;
        if !self.is_free(mesh) {
            return None;
        }
        let [before, after] = self.sides;
        let sides = [
            before.map(|h| (h, topology.target(h), topology.origin(h))),
            after.map(|h| (h, topology.origin(h), topology.target(h))),
        ];
        let mut draft = DissolveDraft::new(mesh, curve);
        let mut ends =
            [topology.origin(self.edge), topology.target(self.edge)].map(|v| v.index() as u32);
        let mut changed = vec![heir];
        for (k, side) in sides.into_iter().enumerate() {
            let Some((h, corner, rim)) = side else {
                continue;
            };
            let neighbour = across(h).filter(|f| *f != heir)?;
            let end = self.lengthened(mesh, inside, corner, rim)?;
            let w = draft.add(end);
            draft.move_end(neighbour, [corner, rim], w, k == 0)?;
            replace(&mut draft.faces[heir.index()], ends[k], w);
            ends[k] = w;
            changed.push(neighbour);
        }
        draft.follow(heir, ends[1], ends[0])?;
        draft
            .is_sound(self.sliver, &changed, room)
            .then(|| draft.without(self.sliver, &trimmed.parent))?
    }

    /// The mesh with the sliver shared by the neighbours on both sides, where the lines along which
    /// the heir would go on meet before the boundary: it ends in their meet, and from there the
    /// planes of the two meet up to the boundary.
    fn close_over(
        &self,
        trimmed: &Trimmed,
        inside: &impl Fn(Vec3) -> bool,
        curve: &Curve,
        room: f64,
    ) -> Option<Trimmed> {
        let mesh = &trimmed.mesh;
        let topology = mesh.topology();
        let across = |h: HalfEdgeId| topology.twin(h).map(|t| topology.face(t));
        let [before, after] = [self.sides[0]?, self.sides[1]?];
        let faces = [across(before)?, across(self.edge)?, across(after)?];
        if !self.is_free(mesh) || faces[0] == faces[2] {
            return None;
        }
        let planes = faces.map(|f| FacePlane::fit(&mesh.corners(f).collect::<Vec<_>>()));
        let normals = Matrix3::from_rows(&planes.map(|p| p.normal.transpose()));
        let heights = Vec3::from(planes.map(|p| p.normal.dot(&p.centre)));
        let meet = normals.lu().solve(&heights)?;
        let corners = [topology.origin(self.edge), topology.target(self.edge)];
        let rims = [topology.origin(before), topology.target(after)];
        let rim = (mesh.position(rims[0]) + mesh.position(rims[1])) * 0.5;
        let along = planes[0]
            .normal
            .cross(&planes[2].normal)
            .try_normalize(0.0)?;
        let way = along * along.dot(&(rim - meet)).signum();
        let end = leaves(inside, meet, way, REACH * (rim - meet).norm())?;
        let mut draft = DissolveDraft::new(mesh, curve);
        let (p, w) = (draft.add(meet), draft.add(end));
        for (k, f) in [faces[0], faces[2]].into_iter().enumerate() {
            draft.move_end(f, [corners[k], rims[k]], w, k == 0)?;
            let face = &mut draft.faces[f.index()];
            let at = face.iter().position(|v| *v == w)?;
            face.insert(at + k, p);
        }
        let [first, second] = corners.map(|v| v.index() as u32);
        let heir = &mut draft.faces[faces[1].index()];
        replace(heir, first, p);
        heir.retain(|v| *v != second);
        draft
            .is_sound(self.sliver, &faces, room)
            .then(|| draft.without(self.sliver, &trimmed.parent))?
    }

    /// Whether nobody but the sliver and a neighbour meet where its stretch of boundary ends.
    fn is_free(&self, mesh: &HexMesh) -> bool {
        let topology = mesh.topology();
        let corners = topology.face_vertices(self.sliver).iter();
        let mut rim = corners.filter(|v| topology.is_boundary_vertex(**v));
        rim.all(|v| topology.face_degree(*v) <= 2)
    }

    /// Where the edge that ends at an inner corner of the sliver meets the boundary if it goes on.
    fn lengthened(
        &self,
        mesh: &HexMesh,
        inside: &impl Fn(Vec3) -> bool,
        corner: VertexId,
        rim: VertexId,
    ) -> Option<Vec3> {
        let topology = mesh.topology();
        let own = topology.face_vertices(self.sliver);
        let around = topology.neighbours(corner);
        let mut others = around.iter().filter(|v| !own.contains(v));
        let (behind, None) = (others.next()?, others.next()) else {
            return None;
        };
        let start = mesh.position(corner);
        let way = (start - mesh.position(*behind)).try_normalize(0.0)?;
        let reach = REACH * (mesh.position(rim) - start).norm();
        leaves(inside, start, way, reach)
    }
}

/// Where a way leaves the surface, within `reach`.
fn leaves(inside: &impl Fn(Vec3) -> bool, start: Vec3, way: Vec3, reach: f64) -> Option<Vec3> {
    let inside = |t: f64| inside(start + way * (t * reach));
    let at = |i: usize| i as f64 / STEPS as f64;
    let i = (0..STEPS).find(|&i| inside(at(i)) && !inside(at(i + 1)))?;
    let (mut low, mut high) = (at(i), at(i + 1));
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if inside(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(start + way * (0.5 * (low + high) * reach))
}

impl<'a> DissolveDraft<'a> {
    fn new(mesh: &'a HexMesh, curve: &'a Curve) -> Self {
        Self {
            mesh,
            curve,
            positions: mesh.positions.as_slice().to_vec(),
            faces: mesh.topology().face_lists(),
        }
    }

    fn add(&mut self, p: Vec3) -> u32 {
        self.positions.push(p);
        self.positions.len() as u32 - 1
    }

    /// Moves the end of a neighbour's edge from the sliver's inner corner to the boundary, and
    /// takes out the corner that it had there; `next`: the boundary follows after it, else it comes
    /// before.
    fn move_end(
        &mut self,
        f: FaceId,
        [corner, rim]: [VertexId; 2],
        w: u32,
        next: bool,
    ) -> Option<()> {
        let [corner, rim] = [corner, rim].map(|v| v.index() as u32);
        let face = &mut self.faces[f.index()];
        let (n, i) = (face.len(), face.iter().position(|v| *v == rim)?);
        let beyond = if next {
            face[(i + 1) % n]
        } else {
            face[(i + n - 1) % n]
        };
        let place = |v: u32| self.curve.closest(self.positions[v as usize]);
        // The new end lies between the ends of the two panels' stretches of boundary.
        let other = self.curve.closest(self.positions[rim as usize]);
        let [to_end, to_beyond] = if next {
            [
                self.curve.ahead(place(w), place(beyond)),
                self.curve.ahead(other, place(beyond)),
            ]
        } else {
            [
                self.curve.ahead(place(beyond), place(w)),
                self.curve.ahead(place(beyond), other),
            ]
        };
        let half = 0.5 * self.curve.length_of(other);
        if !(to_end < half && to_beyond < half) {
            return None;
        }
        replace(face, corner, w);
        face.retain(|v| *v != rim);
        let ends = if next { [w, beyond] } else { [beyond, w] };
        self.follow(f, ends[0], ends[1])
    }

    /// Gives a face corners along the curve between two that follow each other.
    fn follow(&mut self, f: FaceId, from: u32, to: u32) -> Option<()> {
        let [begin, end] = [from, to].map(|v| self.positions[v as usize]);
        let [a, b] = [begin, end].map(|p| self.curve.closest(p));
        let plane = FacePlane::fit(&self.mesh.corners(f).collect::<Vec<_>>());
        let way = self.curve.between(a, b, begin, end);
        let first = self.positions.len() as u32;
        self.positions
            .extend(way.iter().map(|p| p - plane.normal * plane.height(*p)));
        let new = first..self.positions.len() as u32;
        let face = &mut self.faces[f.index()];
        let at = face.iter().position(|v| *v == from)?;
        face.splice(at + 1..at + 1, new);
        Some(())
    }

    /// Whether the changed faces are simple, have room, and fill the sliver's place.
    fn is_sound(&self, sliver: FaceId, changed: &[FaceId], room: f64) -> bool {
        let plane = |f: FaceId| FacePlane::fit(&self.mesh.corners(f).collect::<Vec<_>>());
        let simple = |f: &FaceId| is_simple(&self.faces[f.index()], &self.positions, &plane(*f));
        let roomy = |f: &FaceId| self.flat(*f).clearance().distance >= room;
        changed.iter().all(|f| simple(f) && roomy(f)) && self.fills(sliver, changed)
    }

    fn flat(&self, f: FaceId) -> FlatFace {
        let corners = self.faces[f.index()].iter();
        let corners: Vec<Vec3> = corners.map(|v| self.positions[*v as usize]).collect();
        FlatFace::new(&corners)
    }

    /// Whether the changed faces have the area that they and the sliver had.
    fn fills(&self, sliver: FaceId, changed: &[FaceId]) -> bool {
        let before = |f: &FaceId| FlatFace::of(self.mesh, *f).area();
        let after = |f: &FaceId| self.flat(*f).area();
        let gone = before(&sliver);
        let gained =
            changed.iter().map(after).sum::<f64>() - changed.iter().map(before).sum::<f64>();
        (gained - gone).abs() < SPARE * gone
    }

    /// The mesh without a face.
    fn without(&self, sliver: FaceId, parent: &PerFace<FaceId>) -> Option<Trimmed> {
        let kept = self.mesh.topology().faces().filter(|f| *f != sliver);
        let kept: Vec<FaceId> = kept.collect();
        let faces: Vec<Vec<u32>> = kept.iter().map(|f| self.faces[f.index()].clone()).collect();
        Some(Trimmed {
            mesh: compact(&self.positions, &faces).ok()?,
            parent: PerFace::from_vec(kept.iter().map(|f| parent[*f]).collect()),
        })
    }
}

fn replace(face: &mut [u32], old: u32, new: u32) {
    face.iter_mut()
        .filter(|v| **v == old)
        .for_each(|v| *v = new);
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::Domain;
    use super::*;
    use crate::smooth_surface::extend::{self, Extension};
    use phex_mesh::{TriangleSurface, measure};

    /// A flat square from 0 to 3 as a domain, and panels on it: two in the lower row, one behind,
    /// and between the two in front a narrow one with its inner end at `(1.5, 0.4)`.
    fn panels() -> Trimmed {
        let p = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let positions = vec![
            p(0.0, 0.0),
            p(1.4, 0.0),
            p(1.6, 0.0),
            p(3.0, 0.0),
            p(1.5, 0.4),
            p(1.5, 1.5),
            p(0.0, 1.5),
            p(3.0, 1.5),
            p(3.0, 3.0),
            p(0.0, 3.0),
        ];
        let faces: [&[u32]; 4] = [
            &[0, 1, 4, 5, 6],
            &[1, 2, 4],
            &[2, 3, 7, 5, 4],
            &[6, 5, 7, 8, 9],
        ];
        let mesh = HexMesh::new(positions, &faces).unwrap();
        let parent = PerFace::from_vec(mesh.topology().faces().collect());
        Trimmed { mesh, parent }
    }

    pub fn square() -> TriangleSurface {
        let n = 12;
        let at = |v: u32| Vec3::new(f64::from(v % (n + 1)), f64::from(v / (n + 1)), 0.0) * 0.25;
        let cells = (0..n * n).map(|c| c % n + (c / n) * (n + 1));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]])
            .collect();
        TriangleSurface::new((0..(n + 1) * (n + 1)).map(at).collect(), &triangles).unwrap()
    }

    /// The square in two panels with a triangle between them at the boundary, of a width and with
    /// its tip at `(1.5, tip)`; `height` over `x`.
    pub fn with_triangle(width: f64, tip: f64, height: impl Fn(f64) -> f64) -> Trimmed {
        let p = |x: f64, y: f64| Vec3::new(x, y, height(x));
        let (a, b) = (1.5 - 0.5 * width, 1.5 + 0.5 * width);
        let positions = vec![
            p(0.0, 0.0),
            p(a, 0.0),
            p(b, 0.0),
            p(3.0, 0.0),
            p(1.5, tip),
            p(1.5, 3.0),
            p(0.0, 3.0),
            p(3.0, 3.0),
        ];
        let faces: [&[u32]; 3] = [&[0, 1, 4, 5, 6], &[1, 2, 4], &[2, 3, 7, 5, 4]];
        let mesh = HexMesh::new(positions, &faces).unwrap();
        let parent = PerFace::from_vec(mesh.topology().faces().collect());
        Trimmed { mesh, parent }
    }

    /// An extended surface as it is, without refinement.
    pub fn domain<'a>(original: &'a TriangleSurface, extension: &'a Extension) -> Domain<'a> {
        Domain {
            extended: &extension.surface,
            extension,
            levels: 0,
            original,
            corner_angle: 0.7,
        }
    }

    #[test]
    fn a_neighbour_takes_a_sliver_over() {
        let original = square();
        let extension = extend::extend(&original, 0.5, 0.0).unwrap();
        let domain = domain(&original, &extension);
        let curve = Curve::of(&original, 0.7, 1e-3);
        let after = without_slivers(
            panels(),
            &|p| domain.contains(p),
            &curve,
            Takeover::default(),
        );
        assert_eq!(after.mesh.topology().n_faces(), 3);
        assert_eq!(small_rim_faces(&after.mesh), []);
        assert!((measure(&after.mesh).area - 9.0).abs() < 1e-9);
        // The edge between the two in front goes on to the boundary.
        let end = Vec3::new(1.5, 0.0, 0.0);
        let nearest = after.mesh.positions.iter().map(|p| (p - end).norm());
        assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9);
    }

    /// Three slightly tilted planes through `(1.5, 0.3, 0)`, which a narrow panel in front cuts
    /// off: the lines along which the panel behind it would go on meet there, before the boundary.
    fn cut_off() -> Trimmed {
        let side = |x: f64| -1e-3 * (x - 1.5f64).abs();
        let back = |y: f64| -1e-3 * (y - 0.3);
        let place = |[x, y]: [f64; 2]| Vec3::new(x, y, side(x).min(back(y)));
        let positions = [
            [0.0, 0.0],
            [1.4, 0.0],
            [1.6, 0.0],
            [3.0, 0.0],
            [1.6, 0.4],
            [1.4, 0.4],
            [3.0, 1.8],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 1.8],
        ];
        let faces: [&[u32]; 4] = [
            &[0, 1, 5, 9],
            &[1, 2, 4, 5],
            &[2, 3, 6, 4],
            &[5, 4, 6, 7, 8, 9],
        ];
        let mesh = HexMesh::new(positions.map(place).to_vec(), &faces).unwrap();
        let parent = PerFace::from_vec(mesh.topology().faces().collect());
        Trimmed { mesh, parent }
    }

    #[test]
    fn neighbours_on_both_sides_share_a_sliver() {
        let curve = Curve::of(&square(), 0.7, 1e-3);
        let inside = |p: Vec3| p.y > 0.0;
        let dissolved = |shared: bool| {
            let how = Takeover {
                room: 0.1,
                shared,
                cut: false,
            };
            without_slivers(cut_off(), &inside, &curve, how).mesh
        };
        assert_eq!(dissolved(false).topology().n_faces(), 4);
        let after = dissolved(true);
        let topology = after.topology();
        assert_eq!(topology.n_faces(), 3);
        let at = |p: Vec3| {
            let near = |v: &VertexId| (after.position(*v) - p).norm() < 1e-9;
            topology.vertices().find(near).expect("a vertex there")
        };
        assert_eq!(topology.face_degree(at(Vec3::new(1.5, 0.3, 0.0))), 3);
        assert_eq!(topology.face_degree(at(Vec3::new(1.5, 0.0, 0.0))), 2);
        let flat = |f: FaceId| FlatFace::of(&after, f).planarity_length < 1e-12;
        assert!(topology.faces().all(flat));
    }
}
