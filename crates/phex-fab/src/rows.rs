//! Rows of panels, where the connectivity has them.
//!
//! In a lattice of hexagons with three at each vertex every half-edge has one of six directions: +1
//! to the next half-edge of a face, +3 to its twin. The directions are carried from face to face;
//! crossing direction 0 is a step `(1, 0)` in lattice coordinates, 1 is `(0, 1)`, 2 is `(-1, 1)`
//! and the others are their opposites. The faces have rows of family `k` (along direction `k`) if
//! this contradicts itself nowhere: every inner face is a hexagon, and the coordinate across the
//! rows closes round every hole, or misses by multiples of one number, as round the tube of a
//! torus: then that is the number of rows. Faces on the boundary may have any number of corners.
//!
//! Of the families that exist the one whose rows run most level and straight is taken (in a level
//! mesh the one nearest to the x axis). Rows are counted upwards (in y where the mesh is level;
//! from the lowest where they close to a ring), the panels of a row towards positive x; closed
//! rings start at the most negative x.

use phex_mesh::{FaceId, HalfEdgeId, HexMesh, PerFace, PerHalfEdge, Vec3};
use std::collections::VecDeque;

/// Steps in lattice coordinates of the six directions.
const STEPS: [[i64; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];
/// Coordinate across the rows of each family, and along them, as factors of the two lattice
/// coordinates.
const ACROSS: [[i64; 2]; 3] = [[0, 1], [1, 0], [1, 1]];
const ALONG: [[i64; 2]; 3] = [[2, 1], [1, 2], [-1, 1]];
/// Of rows that are all level, those along the x axis come first.
const LEVEL_TIE: f64 = 1e-3;
/// Scores closer than this are equal.
const SAME_SCORE: f64 = 1e-6;

/// Least number of rows one after the other in a ring: fewer would be spirals.
const LEAST_ROWS: i64 = 3;

/// Row and place in the row of each face, from 0; `None` where there are no rows.
pub fn rows(mesh: &HexMesh) -> Option<PerFace<[usize; 2]>> {
    let lattice = PanelLattice::of(mesh)?;
    let separate = |&k: &usize| {
        let period = lattice.period(mesh, ACROSS[k]);
        period == 0 || period >= LEAST_ROWS
    };
    let families = (0..3).filter(separate);
    let scored = families.map(|k| (k, lattice.score(mesh, k)));
    let better = |a: (usize, f64), b: (usize, f64)| if b.1 < a.1 - SAME_SCORE { b } else { a };
    let (family, _) = scored.reduce(better)?;
    Some(lattice.numbered(mesh, family))
}

/// Directions of half-edges and coordinates of faces.
struct PanelLattice {
    direction: PerHalfEdge<Option<u8>>,
    coordinates: PerFace<[i64; 2]>,
}

impl PanelLattice {
    /// `None` if directions contradict one another, or the mesh has several parts.
    fn of(mesh: &HexMesh) -> Option<Self> {
        let topology = mesh.topology();
        let inner = topology.faces().find(|&f| topology.valence(f) == 6)?;
        let defect = |f| topology.valence(f) != 6 && !topology.is_boundary_face(f);
        if topology.faces().any(defect) {
            return None;
        }
        let mut lattice = Self {
            direction: PerHalfEdge::filled(topology.n_half_edges(), None),
            coordinates: PerFace::filled(topology.n_faces(), [0, 0]),
        };
        let mut seen = PerFace::filled(topology.n_faces(), false);
        seen[inner] = true;
        let start = topology.face_half_edges(inner).next()?;
        lattice.enter(mesh, start, 0);
        let mut queue = VecDeque::from([inner]);
        while let Some(face) = queue.pop_front() {
            for h in topology.face_half_edges(face) {
                let (Some(twin), Some(direction)) = (topology.twin(h), lattice.direction[h]) else {
                    continue;
                };
                let next = topology.face(twin);
                if !seen[next] {
                    seen[next] = true;
                    lattice.coordinates[next] =
                        add(lattice.coordinates[face], STEPS[usize::from(direction)]);
                    lattice.enter(mesh, twin, (direction + 3) % 6);
                    queue.push_back(next);
                }
            }
        }
        let complete = seen.iter().all(|&s| s) && lattice.agrees(mesh);
        complete.then_some(lattice)
    }

    /// Gives directions to the half-edges of a face of which one is known. In a face that is no
    /// hexagon they are known only up to the boundary, on either side.
    fn enter(&mut self, mesh: &HexMesh, known: HalfEdgeId, direction: u8) {
        let topology = mesh.topology();
        let n = topology.valence(topology.face(known));
        let hexagon = n == 6;
        self.direction[known] = Some(direction);
        let ends = |v| !hexagon && topology.is_boundary_vertex(v);
        let (mut forward, mut backward) = (known, known);
        for k in 1..n {
            forward = topology.next(forward);
            if ends(topology.origin(forward)) {
                break;
            }
            self.direction[forward] = Some(((usize::from(direction) + k) % 6) as u8);
        }
        for k in 1..n {
            if hexagon || ends(topology.origin(backward)) {
                break;
            }
            backward = topology.prev(backward);
            self.direction[backward] = Some(((usize::from(direction) + 5 * k) % 6) as u8);
        }
    }

    /// Whether twins have opposite directions wherever both are known.
    fn agrees(&self, mesh: &HexMesh) -> bool {
        self.steps(mesh).all(
            |(h, twin)| match (self.direction[h], self.direction[twin]) {
                (Some(a), Some(b)) => (a + 3) % 6 == b,
                _ => true,
            },
        )
    }

    fn steps(&self, mesh: &HexMesh) -> impl Iterator<Item = (HalfEdgeId, HalfEdgeId)> {
        let topology = mesh.topology();
        topology
            .half_edges()
            .filter_map(|h| Some((h, topology.twin(h)?)))
    }

    /// The number up to whose multiples a linear function of the coordinates changes across every
    /// edge as its direction says; 0 if it does so exactly.
    fn period(&self, mesh: &HexMesh, factors: [i64; 2]) -> i64 {
        let topology = mesh.topology();
        let miss = |(h, twin): (HalfEdgeId, HalfEdgeId)| {
            let step = STEPS[usize::from(self.direction[h]?)];
            let [from, to] = [h, twin].map(|h| self.coordinates[topology.face(h)]);
            Some(dot(factors, to) - dot(factors, from) - dot(factors, step))
        };
        self.steps(mesh).filter_map(miss).fold(0, divisor)
    }

    /// Pairs of neighbours in rows of a family, in its direction.
    fn neighbours(&self, mesh: &HexMesh, family: usize) -> Vec<[FaceId; 2]> {
        let topology = mesh.topology();
        let along = self
            .steps(mesh)
            .filter(|(h, _)| self.direction[*h] == Some(family as u8));
        along
            .map(|(h, twin)| [topology.face(h), topology.face(twin)])
            .collect()
    }

    /// How steep and crooked the rows of a family are.
    fn score(&self, mesh: &HexMesh, family: usize) -> f64 {
        let pairs = self.neighbours(mesh, family);
        let mut step = PerFace::filled(mesh.topology().n_faces(), None);
        for [a, b] in &pairs {
            step[*a] = (mesh.centre(*b) - mesh.centre(*a)).try_normalize(0.0);
        }
        let steep = pairs
            .iter()
            .filter_map(|[a, _]| step[*a])
            .map(|d: Vec3| d.z * d.z + LEVEL_TIE * d.y * d.y);
        let bend = pairs
            .iter()
            .filter_map(|[a, b]| Some(step[*a]?.cross(&step[*b]?).norm_squared()));
        let mean = |sum: f64| sum / pairs.len().max(1) as f64;
        mean(steep.sum()) + mean(bend.sum())
    }

    fn numbered(&self, mesh: &HexMesh, family: usize) -> PerFace<[usize; 2]> {
        let topology = mesh.topology();
        let across = self.row_levels(mesh, family);
        let across = |f: FaceId| across[f];
        let up = ascending(mesh, topology.faces().map(|f| (f, across(f))), [2, 1, 0]);
        let mut levels: Vec<i64> = topology.faces().map(|f| up * across(f)).collect();
        levels.sort_unstable();
        levels.dedup();
        if self.period(mesh, ACROSS[family]) > 0 {
            let height = |level: i64| {
                let faces = topology.faces().filter(|&f| up * across(f) == level);
                let heights: Vec<f64> = faces.map(|f| mesh.centre(f).z).collect();
                heights.iter().sum::<f64>() / heights.len() as f64
            };
            let lowest =
                (0..levels.len()).min_by(|&a, &b| height(levels[a]).total_cmp(&height(levels[b])));
            levels.rotate_left(lowest.unwrap_or(0));
        }
        let mut numbers = PerFace::filled(topology.n_faces(), [0, 0]);
        for (row, &level) in levels.iter().enumerate() {
            let faces: Vec<FaceId> = topology
                .faces()
                .filter(|&f| up * across(f) == level)
                .collect();
            for (place, face) in self.ordered(mesh, family, faces).into_iter().enumerate() {
                numbers[face] = [row, place];
            }
        }
        numbers
    }

    /// The coordinate across the rows of each face.
    fn row_levels(&self, mesh: &HexMesh, family: usize) -> PerFace<i64> {
        let period = self.period(mesh, ACROSS[family]);
        self.coordinates.map(|&c| match dot(ACROSS[family], c) {
            level if period == 0 => level,
            level => level.rem_euclid(period),
        })
    }

    /// The faces of one row, along it.
    fn ordered(&self, mesh: &HexMesh, family: usize, mut faces: Vec<FaceId>) -> Vec<FaceId> {
        if self.period(mesh, ALONG[family]) == 0 {
            let along = |f: FaceId| dot(ALONG[family], self.coordinates[f]);
            let all = mesh.topology().faces().map(|f| (f, along(f)));
            let right = ascending(mesh, all, [0, 1, 2]);
            faces.sort_by_key(|&f| right * along(f));
            return faces;
        }
        ring(mesh, &self.neighbours(mesh, family), faces)
    }
}

/// The faces of closed rows, each from its most negative x on.
fn ring(mesh: &HexMesh, pairs: &[[FaceId; 2]], mut faces: Vec<FaceId>) -> Vec<FaceId> {
    let mut next = PerFace::filled(mesh.topology().n_faces(), None);
    for [a, b] in pairs {
        next[*a] = Some(*b);
    }
    faces.sort_by(|&a, &b| mesh.centre(a).x.total_cmp(&mesh.centre(b).x));
    let mut placed = PerFace::filled(mesh.topology().n_faces(), false);
    let mut order = Vec::with_capacity(faces.len());
    for start in faces {
        let mut at = Some(start);
        while let Some(face) = at.filter(|&f| !placed[f]) {
            placed[face] = true;
            order.push(face);
            at = next[face];
        }
    }
    order
}

/// 1 or -1, such that the numbers times it grow along the first of the axes that they have to do
/// with.
fn ascending(
    mesh: &HexMesh,
    numbers: impl Iterator<Item = (FaceId, i64)>,
    axes: [usize; 3],
) -> i64 {
    let pairs: Vec<(Vec3, f64)> = numbers.map(|(f, n)| (mesh.centre(f), n as f64)).collect();
    let count = pairs.len() as f64;
    let centre = pairs.iter().map(|(p, _)| p).sum::<Vec3>() / count;
    let mean = pairs.iter().map(|(_, n)| n).sum::<f64>() / count;
    let covariance: Vec3 = pairs.iter().map(|(p, n)| (p - centre) * (n - mean)).sum();
    let weak = 1e-3 * covariance.norm();
    let axis = axes.into_iter().find(|&k| covariance[k].abs() > weak);
    if axis.is_some_and(|k| covariance[k] < 0.0) {
        -1
    } else {
        1
    }
}

fn add(a: [i64; 2], b: [i64; 2]) -> [i64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Greatest common divisor, at least 0.
fn divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a.abs() } else { divisor(b, a % b) }
}

fn dot(a: [i64; 2], b: [i64; 2]) -> i64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{cuboid, honeycomb};

    #[test]
    fn a_honeycomb_has_its_rows_from_below() {
        let mesh = honeycomb(4, 5, |p| p);
        let rows = rows(&mesh).unwrap();
        for f in mesh.topology().faces() {
            assert_eq!(rows[f], [f.index() / 5, f.index() % 5]);
        }
    }

    #[test]
    fn rows_go_up_whatever_way_the_mesh_was_numbered_and_turned() {
        // Turned upright and upside down: the last row of the list is the lowest.
        let mesh = honeycomb(3, 4, |p| Vec3::new(p.x, 0.0, -p.y));
        let rows = rows(&mesh).unwrap();
        for f in mesh.topology().faces() {
            assert_eq!(rows[f], [2 - f.index() / 4, f.index() % 4]);
        }
    }

    /// Hexagons on a torus, `rows` of them round the tube; `shift` of them are skipped after one
    /// turn round the axis.
    fn torus(columns: usize, rows: usize, shift: usize) -> HexMesh {
        let wrapped = |i: isize, j: isize| {
            let (turn, i) = (
                i.div_euclid(columns as isize),
                i.rem_euclid(columns as isize),
            );
            let j = (j - turn * shift as isize).rem_euclid(rows as isize);
            (i as usize * rows + j as usize) as u32
        };
        let (up, down) = (|i, j| 2 * wrapped(i, j), |i, j| 2 * wrapped(i, j) + 1);
        let cells = (0..columns as isize).flat_map(|i| (0..rows as isize).map(move |j| (i, j)));
        let face = |(i, j): (isize, isize)| {
            [
                up(i, j),
                down(i - 1, j),
                up(i - 1, j),
                down(i - 1, j - 1),
                up(i, j - 1),
                down(i, j - 1),
            ]
        };
        let faces: Vec<[u32; 6]> = cells.map(face).collect();
        let at = |k: usize| {
            let (u, v) = (
                (k / 2 / rows) as f64,
                (k / 2 % rows) as f64 + 0.4 * (k % 2) as f64,
            );
            let (u, v) =
                ([u / columns as f64, v / rows as f64].map(|t| t * std::f64::consts::TAU)).into();
            let radius = 3.0 + f64::cos(v);
            Vec3::new(radius * f64::cos(u), radius * f64::sin(u), f64::sin(v))
        };
        let positions = (0..2 * rows * columns).map(at).collect();
        HexMesh::new(positions, &faces).unwrap()
    }

    #[test]
    fn rows_close_to_rings_on_a_torus() {
        let mesh = torus(12, 7, 0);
        let rows = rows(&mesh).unwrap();
        for f in mesh.topology().faces() {
            let (ring, face) = (f.index() % 7, |k: usize| FaceId::new(k as u32));
            assert_eq!(rows[f][0], rows[face(ring)][0], "one ring");
            let next = rows[face((ring + 1) % 7)][0];
            let apart = next.abs_diff(rows[f][0]);
            assert!(apart == 1 || apart == 6, "rings {ring} and the next");
        }
        let low = mesh.topology().faces().filter(|&f| rows[f][0] == 0);
        let low: Vec<FaceId> = low.collect();
        assert!(low.iter().all(|&f| mesh.centre(f).z < -0.8));
        let mut places: Vec<usize> = low.iter().map(|&f| rows[f][1]).collect();
        places.sort_unstable();
        assert_eq!(places, (0..12).collect::<Vec<_>>());
        // Of one family one row would wind round the axis seven times; the rows of another close.
        let rows = super::rows(&torus(13, 7, 1)).unwrap();
        let last = |k: usize| rows.iter().map(|r| r[k]).max();
        assert_eq!([last(0), last(1)], [Some(6), Some(12)]);
    }

    #[test]
    fn there_are_no_rows_round_a_face_that_is_no_hexagon() {
        assert!(rows(&cuboid(1.0, 2.0, 3.0)).is_none());
    }
}
