//! Chamfers: an edge over which two panels fold by more than a right angle is cut off, so that they
//! turn in two steps.
//!
//! Where a body is thinner than its panels (a fin, the edge of a wing) two of them meet like the
//! sides of a blade. A plane parallel to their edge and as steep to one as to the other cuts the
//! edge off. It leaves a narrow quadrilateral; the planes of all other panels stay, so that
//! everything is as planar as before, and interior vertices still have three faces. A blade of
//! almost no angle takes two cuts.

use super::{Trimmed, compact};
use phex_mesh::{
    FaceId, FlatFace, HalfEdgeId, HexMesh, PerFace, Topology, ValidateOptions, Vec3, VertexId,
    polygon,
};

/// The mesh with the edge between two panels cut off at a share of the depth of the nearest vertex
/// below which an adjacent edge leads to; `None` if the panels that it changes are not simple or
/// lose their clearance. Panels keep their numbers, the new one follows; its parent is that of
/// `left`.
pub(super) fn cut_off(
    trimmed: &Trimmed,
    [left, right]: [FaceId; 2],
    depth: f64,
) -> Option<Trimmed> {
    let mesh = &trimmed.mesh;
    let topology = mesh.topology();
    let across = |h: &HalfEdgeId| topology.twin(*h).is_some_and(|t| topology.face(t) == right);
    let blade = Blade::new(topology, topology.face_half_edges(left).find(across)?)?;
    let mut draft = ChamferDraft {
        positions: mesh.positions.as_slice().to_vec(),
        faces: topology.face_lists(),
        least: ValidateOptions::default().clearance * mesh.mean_edge(),
    };
    if !draft.cut(&blade, mesh, depth) {
        return None;
    }
    let mut parent = trimmed.parent.as_slice().to_vec();
    parent.push(trimmed.parent[left]);
    Some(Trimmed {
        mesh: compact(&draft.positions, &draft.faces).ok()?,
        parent: PerFace::from_vec(parent),
    })
}

/// An edge between two panels and what is next to it.
struct Blade {
    /// The panels on its left and right.
    sides: [FaceId; 2],
    ends: [VertexId; 2],
    /// The next vertices of the left panel, before the first end and after the second one, and
    /// those of the right panel.
    beyond: [[VertexId; 2]; 2],
    /// The third panel at each end, if there is one.
    third: [Option<FaceId>; 2],
}

impl Blade {
    fn new(topology: &Topology, h: HalfEdgeId) -> Option<Self> {
        let t = topology.twin(h)?;
        let [before, after] = [topology.prev(h), topology.next(h)];
        let [right_after, right_before] = [topology.next(t), topology.prev(t)];
        let across = |h: HalfEdgeId| topology.twin(h).map(|t| topology.face(t));
        let third = [
            [across(before), across(right_after)],
            [across(after), across(right_before)],
        ];
        // With more panels at an end there is no one panel that a cut would end in.
        let single = third.iter().all(|[a, b]| a == b);
        single.then(|| Self {
            sides: [topology.face(h), topology.face(t)],
            ends: [topology.origin(h), topology.target(h)],
            beyond: [
                [topology.origin(before), topology.target(after)],
                [topology.target(right_after), topology.origin(right_before)],
            ],
            third: third.map(|[a, _]| a),
        })
    }

    /// The direction that the edge points in, like a blade's.
    fn outwards(&self, mesh: &HexMesh) -> Option<Vec3> {
        let [from, to] = self.ends.map(|v| mesh.position(v));
        let along = (to - from).try_normalize(0.0)?;
        let [left, right] = self.sides.map(|f| FlatFace::of(mesh, f).normal());
        let into = left.cross(&along) + along.cross(&right);
        into.try_normalize(0.0).map(|d| -d)
    }
}

/// Positions and faces that are being changed.
struct ChamferDraft {
    positions: Vec<Vec3>,
    faces: Vec<Vec<u32>>,
    /// Clearance that panels are to keep.
    least: f64,
}

impl ChamferDraft {
    /// Cuts an edge off at a share of the depth of the nearest vertex; false if that leaves panels
    /// that are not sound, and the draft is no use.
    fn cut(&mut self, blade: &Blade, mesh: &HexMesh, share: f64) -> bool {
        let Some(outwards) = blade.outwards(mesh) else {
            return false;
        };
        let adjacent = |side: usize, end: usize| {
            [blade.ends[end], blade.beyond[side][end]].map(|v| mesh.position(v))
        };
        let depth = |side: usize, end: usize| {
            let [top, beyond] = adjacent(side, end);
            outwards.dot(&(top - beyond))
        };
        let depths = [[depth(0, 0), depth(0, 1)], [depth(1, 0), depth(1, 1)]];
        let downwards = depths.iter().flatten().filter(|d| **d > 0.0);
        let nearest = downwards.copied().fold(f64::INFINITY, f64::min);
        // Where a panel turns inwards at the end, its adjacent edge is lengthened.
        let place = |side: usize, end: usize| {
            let [top, beyond] = adjacent(side, end);
            top + (beyond - top) * (share * nearest / depths[side][end])
        };
        let corners = [[place(0, 0), place(0, 1)], [place(1, 0), place(1, 1)]];
        nearest.is_finite() && self.replace(blade, corners)
    }

    /// Puts a quadrilateral in place of an edge: `corners` by side and end.
    fn replace(&mut self, blade: &Blade, corners: [[Vec3; 2]; 2]) -> bool {
        let first = self.positions.len() as u32;
        let number = |side: usize, end: usize| first + (2 * side + end) as u32;
        let sides = [0, 1].map(|side| {
            let f = blade.sides[side];
            let half = substituted(&self.faces[f.index()], blade.ends[0], &[number(side, 0)]);
            (f, substituted(&half, blade.ends[1], &[number(side, 1)]))
        });
        // The third panel at the first end goes from the right side to the left one, at the second
        // end the other way.
        let thirds = [0, 1].map(|end| {
            let new = [number(1 - end, end), number(end, end)];
            let face = |f: FaceId| {
                (
                    f,
                    substituted(&self.faces[f.index()], blade.ends[end], &new),
                )
            };
            blade.third[end].map(face)
        });
        let quadrilateral = vec![number(0, 1), number(0, 0), number(1, 0), number(1, 1)];
        self.positions.extend(corners.into_iter().flatten());
        let changed: Vec<(FaceId, Vec<u32>)> = sides
            .into_iter()
            .chain(thirds.into_iter().flatten())
            .collect();
        let sound =
            changed.iter().all(|(_, face)| self.is_sound(face)) && self.is_sound(&quadrilateral);
        for (f, face) in changed {
            self.faces[f.index()] = face;
        }
        self.faces.push(quadrilateral);
        sound
    }

    fn flat(&self, face: &[u32]) -> FlatFace {
        let corners: Vec<Vec3> = face.iter().map(|&v| self.positions[v as usize]).collect();
        FlatFace::new(&corners)
    }

    fn is_sound(&self, face: &[u32]) -> bool {
        let flat = self.flat(face);
        polygon::is_simple(&flat.polygon) && flat.clearance().distance >= self.least
    }
}

/// A face with new vertices in place of one.
fn substituted(face: &[u32], old: VertexId, new: &[u32]) -> Vec<u32> {
    let old = old.index() as u32;
    let put = |&v: &u32| if v == old { new.to_vec() } else { vec![v] };
    face.iter().flat_map(put).collect()
}
