//! Slivers that grow into the panels beside them.
//!
//! Where no plane of a neighbour can be continued over a sliver at the boundary, the sliver gets a
//! plane of its own: through points on the two neighbours' stretches of boundary, and through one
//! of its inner corners moved back along the edge behind it, in which the planes of two neighbours
//! meet; its other inner corners are where the plane meets the edges behind them. Neighbours are
//! only cut, or go on in their planes, so they stay planar.

use super::curve::Curve;
use super::{Trimmed, compact};
use phex_mesh::{
    FaceId, FacePlane, FlatFace, HalfEdgeId, HexMesh, LEAST_RIM_AREA, Topology, Vec3, VertexId,
    polygon,
};

/// Shares of the edge behind, and of the neighbours' stretches of boundary, that are tried.
const BACK: [f64; 8] = [0.0, 0.06, 0.13, 0.2, 0.3, 0.42, 0.55, 0.7];
const ALONG: [f64; 7] = [0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9];
/// Shares of the edges behind the other corners between which these may come to lie; below 0 the
/// edge gets longer.
const BETWEEN: std::ops::Range<f64> = -0.3..0.8;
/// Area that a sliver grows to, and its neighbours keep, over the least that is not small.
const ENOUGH: f64 = 1.05;
/// Cosine of the angle by which the plane of a sliver turns at the most.
const TURN: f64 = 0.8;
/// Distance, in tolerances of the curve, by which corners along it leave it for the sliver's plane.
const OFF: f64 = 2.0;

/// The mesh with a sliver of more than the least area; of several ways the one that leaves most
/// room, `room` at least.
pub(super) fn grown(
    trimmed: &Trimmed,
    sliver: FaceId,
    curve: &Curve,
    room: f64,
) -> Option<Trimmed> {
    let growth = Growth::of(&trimmed.mesh, sliver, curve)?;
    let cuts = growth.cuts().into_iter();
    let clear = cuts.filter_map(|c| Some((growth.clearance(&c)?, c)));
    let clear = clear.filter(|c| c.0 >= room);
    let (_, cut) = clear.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Trimmed {
        mesh: growth.applied(&cut)?,
        parent: trimmed.parent.clone(),
    })
}

/// A place on a stretch of boundary, and how many of its vertices lie before it.
type StretchPlace = (Vec3, usize);

struct Growth<'a> {
    mesh: &'a HexMesh,
    curve: &'a Curve,
    sliver: FaceId,
    /// Inner corners in the sliver's order, each with the vertex behind it.
    corners: Vec<[VertexId; 2]>,
    /// Who is across the edges inside, in their order.
    beside: Vec<FaceId>,
    /// The first and the last neighbour's boundary, from the sliver's end on.
    stretches: [Vec<VertexId>; 2],
    least: f64,
}

/// New places of the sliver's corners.
struct SliverCut {
    corners: Vec<Vec3>,
    stops: [StretchPlace; 2],
    /// Corners along the curve, from the second stop to the first.
    way: Vec<Vec3>,
}

impl<'a> Growth<'a> {
    fn of(mesh: &'a HexMesh, sliver: FaceId, curve: &'a Curve) -> Option<Self> {
        let topology = mesh.topology();
        let chain = inner_chain(topology, sliver)?;
        let across = |h: &HalfEdgeId| topology.twin(*h).map(|t| topology.face(t));
        let beside: Vec<FaceId> = chain.iter().filter_map(across).collect();
        let distinct = (1..beside.len()).all(|i| !beside[..i].contains(&beside[i]));
        let (first, last) = (*beside.first()?, *beside.last()?);
        let (begin, end) = (chain[0], chain[chain.len() - 1]);
        if !distinct || chain.len() < 2 {
            return None;
        }
        let behind = |h: &HalfEdgeId| {
            let corner = topology.origin(*h);
            let own = topology.face_vertices(sliver);
            let mut others = topology.neighbours(corner);
            others.retain(|v| !own.contains(v));
            match others[..] {
                [behind] => Some([corner, behind]),
                _ => None,
            }
        };
        let corners: Option<Vec<[VertexId; 2]>> = chain[1..].iter().map(behind).collect();
        let area: Vec<f64> = topology
            .faces()
            .map(|f| FlatFace::of(mesh, f).area())
            .collect();
        Some(Self {
            mesh,
            curve,
            sliver,
            corners: corners?,
            beside,
            stretches: [
                stretch(topology, first, topology.origin(begin), true)?,
                stretch(topology, last, topology.target(end), false)?,
            ],
            least: ENOUGH * LEAST_RIM_AREA * area.iter().sum::<f64>() / area.len() as f64,
        })
    }

    fn cuts(&self) -> Vec<SliverCut> {
        let mut cuts = Vec::new();
        for corner in 0..self.corners.len() {
            for back in BACK {
                for one in ALONG {
                    let other = ALONG.into_iter();
                    cuts.extend(other.filter_map(|other| self.cut(corner, back, [one, other])));
                }
            }
        }
        cuts
    }

    /// The cut by the plane through a corner moved back and ends moved along.
    fn cut(&self, corner: usize, back: f64, along: [f64; 2]) -> Option<SliverCut> {
        let place = |v: VertexId| self.mesh.position(v);
        let behind = |[c, b]: &[VertexId; 2]| (place(*c), place(*b) - place(*c));
        let (start, way) = behind(&self.corners[corner]);
        let at = start + way * back;
        let stops = [0, 1].map(|k| self.at(k, along[k]));
        let old = self.plane(self.sliver).normal;
        let normal = (stops[0].0 - at).cross(&(stops[1].0 - at));
        let normal = normal.try_normalize(0.0)?;
        let normal = normal * normal.dot(&old).signum();
        if normal.dot(&old) < TURN {
            return None;
        }
        let meet = |pair: &[VertexId; 2]| {
            let (start, way) = behind(pair);
            let share = normal.dot(&(at - start)) / normal.dot(&way);
            BETWEEN.contains(&share).then(|| start + way * share)
        };
        let mut corners = Vec::with_capacity(self.corners.len());
        for (k, pair) in self.corners.iter().enumerate() {
            corners.push(if k == corner { at } else { meet(pair)? });
        }
        let [from, to] = [stops[1].0, stops[0].0];
        let [a, b] = [from, to].map(|p| self.curve.closest(p));
        let height = |p: &Vec3| normal.dot(&(p - at));
        let mut way = self.curve.between(a, b, from, to);
        let off = OFF * self.curve.tolerance();
        if way.iter().any(|p| height(p).abs() > off) {
            return None;
        }
        way.iter_mut().for_each(|p| *p -= normal * height(p));
        Some(SliverCut {
            corners,
            stops,
            way,
        })
    }

    fn plane(&self, f: FaceId) -> FacePlane {
        FacePlane::fit(&self.mesh.corners(f).collect::<Vec<_>>())
    }

    /// The place at a share of a stretch.
    fn at(&self, k: usize, share: f64) -> StretchPlace {
        let points: Vec<Vec3> = self.points(k);
        let lengths = points.windows(2).map(|w| (w[1] - w[0]).norm());
        let mut left = share * lengths.sum::<f64>();
        for (i, w) in points.windows(2).enumerate() {
            let length = (w[1] - w[0]).norm();
            if left <= length {
                return (
                    w[0] + (w[1] - w[0]) * (left / length.max(f64::MIN_POSITIVE)),
                    i,
                );
            }
            left -= length;
        }
        (points[0], 0)
    }

    fn points(&self, k: usize) -> Vec<Vec3> {
        let stretch = self.stretches[k].iter();
        stretch.map(|v| self.mesh.position(*v)).collect()
    }

    /// Where a vertex goes; `None` if the sliver has taken its part of the boundary.
    fn moved(&self, cut: &SliverCut, v: VertexId) -> Option<Vec3> {
        if let Some(i) = self.corners.iter().position(|[c, _]| *c == v) {
            return Some(cut.corners[i]);
        }
        for (stretch, (stop, passed)) in self.stretches.iter().zip(&cut.stops) {
            match stretch.iter().position(|w| *w == v) {
                Some(0) => return Some(*stop),
                Some(i) if i <= *passed => return None,
                _ => {}
            }
        }
        Some(self.mesh.position(v))
    }

    /// Least clearance of the changed faces, if they are sound and none becomes small.
    fn clearance(&self, cut: &SliverCut) -> Option<f64> {
        let ends = cut.stops.map(|s| s.0);
        let own = std::iter::once(ends[0]).chain(cut.corners.iter().copied());
        let own: Vec<Vec3> = own
            .chain([ends[1]])
            .chain(cut.way.iter().copied())
            .collect();
        let mut least = self.sound(self.sliver, &own, false)?;
        for f in &self.beside {
            let vertices = self.mesh.topology().face_vertices(*f).iter();
            let corners: Vec<Vec3> = vertices.filter_map(|v| self.moved(cut, *v)).collect();
            let was_small = FlatFace::of(self.mesh, *f).area() < self.least;
            least = least.min(self.sound(*f, &corners, was_small)?);
        }
        Some(least)
    }

    /// The clearance of a face with these corners, if it is simple, wound as before and not small,
    /// unless it may be.
    fn sound(&self, f: FaceId, corners: &[Vec3], may_be_small: bool) -> Option<f64> {
        let plane = self.plane(f);
        let points: Vec<_> = corners.iter().map(|p| plane.project(*p)).collect();
        let area = polygon::signed_area(&points);
        let enough = area >= self.least || (may_be_small && area > 0.0);
        (corners.len() >= 3 && enough && polygon::is_simple(&points))
            .then(|| FlatFace::new(corners).clearance().distance)
    }

    /// The mesh with a cut.
    fn applied(&self, cut: &SliverCut) -> Option<HexMesh> {
        let topology = self.mesh.topology();
        let mut positions = self.mesh.positions.as_slice().to_vec();
        let mut faces = topology.face_lists();
        let gone = |v: &u32| self.moved(cut, VertexId::new(*v)).is_none();
        for f in &self.beside {
            faces[f.index()].retain(|v| !gone(v));
        }
        for v in topology.vertices() {
            if let Some(p) = self.moved(cut, v) {
                positions[v.index()] = p;
            }
        }
        let [first, last] = [0, 1].map(|k| self.stretches[k][0].index() as u32);
        let inner = self.corners.iter().map(|[c, _]| c.index() as u32);
        let mut outline: Vec<u32> = std::iter::once(first).chain(inner).chain([last]).collect();
        for p in &cut.way {
            outline.push(positions.len() as u32);
            positions.push(*p);
        }
        faces[self.sliver.index()] = outline;
        compact(&positions, &faces).ok()
    }
}

/// The edges of a face with one stretch of boundary that have a panel across, in their order.
pub(super) fn inner_chain(topology: &Topology, face: FaceId) -> Option<Vec<HalfEdgeId>> {
    let ring: Vec<HalfEdgeId> = topology.face_half_edges(face).collect();
    let n = ring.len();
    let inside = |i: usize| topology.twin(ring[i % n]).is_some();
    let mut starts = (0..n).filter(|&i| inside(i) && !inside(i + n - 1));
    let (Some(start), None) = (starts.next(), starts.next()) else {
        return None;
    };
    let chain = (start..start + n).take_while(|i| inside(*i));
    Some(chain.map(|i| ring[i % n]).collect())
}

/// The boundary of a face from one of its vertices on, to the next that another face has, forwards
/// or backwards; that vertex alone where a third face meets.
fn stretch(
    topology: &Topology,
    face: FaceId,
    from: VertexId,
    forwards: bool,
) -> Option<Vec<VertexId>> {
    let ring = topology.face_vertices(face);
    let n = ring.len();
    let at = ring.iter().position(|v| *v == from)?;
    let step = |k: usize| match forwards {
        true => ring[(at + k) % n],
        false => ring[(at + n - k) % n],
    };
    let mut stretch = vec![from];
    if topology.face_degree(from) > 2 {
        return Some(stretch);
    }
    for k in 1..n {
        stretch.push(step(k));
        if topology.face_degree(step(k)) > 1 {
            break;
        }
    }
    Some(stretch)
}

#[cfg(test)]
mod tests {
    use super::super::dissolve::tests::{square, with_triangle};
    use super::*;
    use phex_mesh::small_rim_faces;

    /// Three panels with the planes of a low pyramid with its tip at `(1.5, 0.1)`, the one in front
    /// a triangle of `width` at the boundary.
    fn pyramid(width: f64) -> Trimmed {
        with_triangle(width, 0.1, |x| -0.01 * (x - 1.5).abs())
    }

    #[test]
    fn a_sliver_grows_into_planar_panels() {
        let before = pyramid(0.2);
        let sliver = FaceId::new(1);
        assert_eq!(small_rim_faces(&before.mesh), [sliver]);
        let curve = Curve::of(&square(), 0.7, 0.1);
        let after = grown(&before, sliver, &curve, 0.05).unwrap().mesh;
        assert_eq!(small_rim_faces(&after), []);
        let flat = FlatFace::all(&after);
        assert!(flat.iter().all(|f| f.planarity_length < 1e-12));
        assert!(flat.iter().all(|f| f.clearance().distance >= 0.05));
        // Seen from above the panels fill the square as before, but for corners over the curve that
        // lie in the sliver's plane now.
        let above = |f: FaceId| {
            let corners: Vec<_> = after.corners(f).map(|p| p.xy()).collect();
            polygon::signed_area(&corners)
        };
        let filled: f64 = after.topology().faces().map(above).sum();
        assert!((filled - 9.0).abs() < 1e-3, "{filled}");
        let inner = |v: &VertexId| !after.topology().is_boundary_vertex(*v);
        let tip = after.topology().vertices().find(inner).unwrap();
        let tip = after.position(tip);
        assert!((tip.x - 1.5).abs() < 1e-12 && tip.y > 0.1, "{tip}");
    }

    #[test]
    fn no_sliver_grows_where_there_is_no_room() {
        let curve = Curve::of(&square(), 0.7, 0.1);
        assert!(grown(&pyramid(0.2), FaceId::new(1), &curve, 2.0).is_none());
    }
}
