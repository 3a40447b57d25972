//! Slivers joined to a neighbour in the same plane.
//!
//! Where two neighbours lie in one plane, as on flat parts of a surface, their union is a planar
//! panel. The vertex at which the edge between them ended inside has two panels left and goes: both
//! stay planar, since it lies on a straight edge, or all three panels are in one plane.

use super::follow::is_simple;
use super::{TrimError, Trimmed, compact};
use phex_mesh::{FaceId, FacePlane, HexMesh, PerFace, Vec3, small_rim_faces};

/// Distance of a corner from a plane, mean edges, that is rounding.
const ROUNDING: f64 = 1e-11;

/// Joins the small panels at the boundary to neighbours in their planes.
pub(super) fn without_slivers(trimmed: Trimmed) -> Result<Trimmed, TrimError> {
    let mesh = &trimmed.mesh;
    let mut union = Union::of(mesh);
    let small = small_rim_faces(mesh);
    let joined = small.iter().filter(|f| union.absorb(f.index())).count();
    if joined == 0 {
        return Ok(trimmed);
    }
    let kept = (0..union.faces.len()).filter(|f| !union.faces[*f].is_empty());
    let kept: Vec<usize> = kept.collect();
    let faces: Vec<Vec<u32>> = kept.iter().map(|f| union.faces[*f].clone()).collect();
    let parent = kept.iter().map(|f| trimmed.parent[FaceId::new(*f as u32)]);
    Ok(Trimmed {
        mesh: compact(mesh.positions.as_slice(), &faces)?,
        parent: PerFace::from_vec(parent.collect()),
    })
}

/// Faces that are being joined; those that are gone are empty.
struct Union<'a> {
    positions: &'a [Vec3],
    faces: Vec<Vec<u32>>,
    tolerance: f64,
}

impl<'a> Union<'a> {
    fn of(mesh: &'a HexMesh) -> Self {
        Self {
            positions: mesh.positions.as_slice(),
            faces: mesh.topology().face_lists(),
            tolerance: ROUNDING * mesh.mean_edge(),
        }
    }

    /// Joins a face to the neighbour in its plane with which it shares most corners; whether there
    /// was one.
    fn absorb(&mut self, sliver: usize) -> bool {
        let own = self.faces[sliver].clone();
        let shared = |f: usize| self.faces[f].iter().filter(|v| own.contains(v)).count();
        let mut neighbours: Vec<(usize, usize)> = (0..self.faces.len())
            .filter(|f| *f != sliver)
            .map(|f| (shared(f), f))
            .filter(|(count, _)| *count >= 2)
            .collect();
        neighbours.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        neighbours.iter().any(|(_, f)| self.join(sliver, *f))
    }

    fn join(&mut self, sliver: usize, into: usize) -> bool {
        let Some((outline, ends)) = outline(&self.faces[into], &self.faces[sliver]) else {
            return false;
        };
        let plane = self.plane(&self.faces[into]);
        let flat = |v: &u32| plane.height(self.positions[*v as usize]).abs() <= self.tolerance;
        if !outline.iter().all(flat) {
            return false;
        }
        let mut next = self.faces.clone();
        next[into] = outline;
        next[sliver] = Vec::new();
        for end in ends {
            remove_loose(&mut next, end);
        }
        let changed = (0..next.len()).filter(|f| next[*f] != self.faces[*f] && *f != sliver);
        let sound = changed.into_iter().all(|f| self.is_simple(&next[f]));
        if sound {
            self.faces = next;
        }
        sound
    }

    fn plane(&self, face: &[u32]) -> FacePlane {
        let corners: Vec<Vec3> = face.iter().map(|v| self.positions[*v as usize]).collect();
        FacePlane::fit(&corners)
    }

    fn is_simple(&self, face: &[u32]) -> bool {
        is_simple(face, self.positions, &self.plane(face))
    }
}

/// The outline of two faces that share one path of edges, and the ends of that path; `None` if they
/// share something else.
fn outline(a: &[u32], b: &[u32]) -> Option<(Vec<u32>, [u32; 2])> {
    let (n, m) = (a.len(), b.len());
    let in_b = |i: usize| b.contains(&a[i % n]);
    // The path in `a` starts where the corner before is not shared.
    let mut starts = (0..n).filter(|&i| in_b(i) && !in_b(i + n - 1));
    let (start, None) = (starts.next()?, starts.next()) else {
        return None;
    };
    let length = (0..n).take_while(|k| in_b(start + k)).count();
    let (first, last) = (a[start], a[(start + length - 1) % n]);
    let from = b.iter().position(|v| *v == first)?;
    let backwards = (0..length).all(|k| b[(from + m - k) % m] == a[(start + k) % n]);
    if length < 2 || !backwards {
        return None;
    }
    // Round `a` from the end of the path to its start, then round `b` from there to its end.
    let own = (0..=n - length + 1).map(|k| a[(start + length - 1 + k) % n]);
    let other = (1..=m - length).map(|k| b[(from + k) % m]);
    Some((own.chain(other).collect(), [first, last]))
}

/// Takes a vertex with two faces out of both, if they follow each other round it: it is inside, and
/// nothing ends there.
fn remove_loose(faces: &mut [Vec<u32>], v: u32) {
    let holders: Vec<usize> = (0..faces.len())
        .filter(|f| faces[*f].contains(&v))
        .collect();
    let [f, g] = holders[..] else { return };
    let beside = |face: &[u32]| {
        let n = face.len();
        let i = face.iter().position(|w| *w == v).unwrap_or(0);
        [face[(i + n - 1) % n], face[(i + 1) % n]]
    };
    let ([a, b], [c, d]) = (beside(&faces[f]), beside(&faces[g]));
    if a == d && b == c {
        faces[f].retain(|w| *w != v);
        faces[g].retain(|w| *w != v);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side over a strip of two rectangles, the right one narrow; `lift` raises
    /// its free corners.
    fn strip(lift: f64) -> Trimmed {
        let p = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let mut positions = vec![
            p(0.0, 0.0),
            p(1.0, 0.0),
            p(1.1, 0.0),
            p(0.0, 1.0),
            p(1.0, 1.0),
            p(1.1, 1.0),
            p(0.0, 2.0),
            p(1.1, 2.0),
        ];
        positions[2].z += lift;
        positions[5].z += lift;
        positions[7].z += lift;
        let faces: [&[u32]; 3] = [&[0, 1, 4, 3], &[1, 2, 5, 4], &[3, 4, 5, 7, 6]];
        let mesh = HexMesh::new(positions, &faces).unwrap();
        let parent = PerFace::from_vec(mesh.topology().faces().collect());
        Trimmed { mesh, parent }
    }

    #[test]
    fn a_sliver_in_its_neighbours_plane_is_joined_to_it() {
        let before = strip(0.0);
        assert_eq!(small_rim_faces(&before.mesh), [FaceId::new(1)]);
        let after = without_slivers(before).unwrap();
        let topology = after.mesh.topology();
        assert_eq!(topology.n_faces(), 2);
        // The vertex at which three panels met has gone: it had two left.
        assert_eq!(topology.n_vertices(), 7);
        let area = phex_mesh::measure(&after.mesh).area;
        assert!((area - 2.2).abs() < 1e-12);
        assert_eq!(small_rim_faces(&after.mesh), []);
        assert_eq!(after.parent.as_slice(), [FaceId::new(0), FaceId::new(2)]);
    }

    #[test]
    fn a_sliver_in_another_plane_stays() {
        let after = without_slivers(strip(0.05)).unwrap();
        assert_eq!(after.mesh.topology().n_faces(), 3);
    }

    #[test]
    fn faces_that_share_two_paths_have_no_outline() {
        assert_eq!(outline(&[0, 1, 2, 3], &[4, 1, 0, 5, 3, 2]), None);
        let joined = outline(&[0, 1, 2], &[2, 1, 3]);
        assert_eq!(joined, Some((vec![2, 0, 1, 3], [1, 2])));
    }
}
