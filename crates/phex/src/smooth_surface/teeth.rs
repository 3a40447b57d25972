//! Teeth of a boundary: where sharp turns to either side alternate.
//!
//! They come from a line along which triangles have been cut away whole, and nobody wants panels
//! cut like that. A sharp turn with none near that turns the other way is a corner, and stays; so
//! does one with a single opposite turn beside it, as where a support ends near its corner, on a
//! loop that has no row of teeth.

use super::Coarsened;
use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};

/// Half of the turning angle, radians, above which a vertex of the boundary is a corner or a tooth.
pub(super) const SHARP: f64 = 0.3;
/// Edges of a loop below which its turns are its shape, and no teeth: a star of six points has 12,
/// a hole from which whole triangles of a grid were cut has 14 and more.
const FEWEST: usize = 14;
/// Edges of the boundary within which sharp turns to either side are teeth.
const NEAR: usize = 2;
/// Share of a turn that an opposite one has at least: smaller ones are waves beside a corner.
const ALIKE: f64 = 0.5;
/// Share of the largest distance between panels and surface by which teeth of its boundary are
/// moved to make that calm.
pub(crate) const LARGEST_TOOTH: f64 = 0.8;
/// Passes of averaging along the boundary.
const SMOOTHING: usize = 6;

/// A surface without the teeth of its boundary.
pub(crate) struct Calmed {
    /// What is left of it.
    pub part: Coarsened,
    /// Farthest that a vertex was moved, or a tip stands out.
    pub moved: f64,
}

/// The surface with each tooth of its boundary moved towards a calm line, as far as `most` (a
/// length), and without the tips that are a triangle of their own and would lie flat on the line;
/// `None` where there are no teeth.
pub(crate) fn without_teeth(surface: &TriangleSurface, most: f64) -> Option<Calmed> {
    let mut positions = surface.positions().clone();
    let mut is_tip = PerVertex::filled(positions.len(), false);
    let (mut any, mut moved) = (false, 0.0_f64);
    for boundary in surface.boundary_loops() {
        let (line, is_tooth) = line_through_teeth(surface, &boundary);
        any |= is_tooth.contains(&true);
        for (i, v) in boundary.iter().enumerate() {
            let way = line[i] - positions[*v];
            positions[*v] += way * (most / way.norm().max(most));
            moved = moved.max(way.norm().min(most));
            let before = boundary[(i + boundary.len() - 1) % boundary.len()];
            let is_free = !is_tip[before] && surface.topology().neighbours(*v).len() == 2;
            is_tip[*v] = is_tooth[i] && is_free && way.norm() <= most;
        }
    }
    any.then(|| Calmed {
        part: without(surface, &positions, &is_tip),
        moved,
    })
}

/// A surface with vertices elsewhere, and without some that have one triangle each.
fn without(
    surface: &TriangleSurface,
    positions: &PerVertex<Vec3>,
    is_tip: &PerVertex<bool>,
) -> Coarsened {
    let topology = surface.topology();
    let source: Vec<VertexId> = topology.vertices().filter(|v| !is_tip[*v]).collect();
    let mut number = PerVertex::filled(positions.len(), 0);
    for (i, v) in source.iter().enumerate() {
        number[*v] = i as u32;
    }
    let corners = topology.faces().map(|f| topology.face_vertices(f));
    let kept = corners.filter(|corners| corners.iter().all(|v| !is_tip[*v]));
    let triangles: Vec<[u32; 3]> = kept.map(|c| [0, 1, 2].map(|k| number[c[k]])).collect();
    let places = source.iter().map(|v| positions[*v]).collect();
    Coarsened {
        surface: TriangleSurface::new(places, &triangles)
            .expect("tips on edges of other triangles leave a manifold"),
        source: PerVertex::from_vec(source),
    }
}

/// Places along a loop of the boundary with teeth averaged, and which vertices are teeth.
pub(super) fn line_through_teeth(
    surface: &TriangleSurface,
    boundary: &[VertexId],
) -> (Vec<Vec3>, Vec<bool>) {
    let n = boundary.len();
    let mut line: Vec<Vec3> = boundary.iter().map(|v| surface.positions()[*v]).collect();
    let turn = |i: usize| {
        let (a, b) = (line[i] - line[(i + n - 1) % n], line[(i + 1) % n] - line[i]);
        let way = a.cross(&b).dot(&surface.normals()[boundary[i]]).signum();
        let half = 0.5 * a.angle(&b);
        if half > SHARP { half * way } else { 0.0 }
    };
    let turns: Vec<f64> = (0..n).map(turn).collect();
    let is_opposite = |a: f64, b: f64| a * b < 0.0 && b.abs() >= ALIKE * a.abs();
    let has_opposite =
        |i: usize| (n - NEAR..=n + NEAR).any(|k| is_opposite(turns[i], turns[(i + k) % n]));
    let alternates = |i: usize, j: usize| {
        has_opposite(i) && has_opposite(j % n) && turns[i] * turns[j % n] < 0.0
    };
    let next = |i: usize| {
        (i + 1..=i + NEAR)
            .find(|&j| alternates(i, j))
            .map(|j| j % n)
    };
    let has_row = n >= FEWEST && (0..n).any(|i| next(i).and_then(next).is_some());
    let is_tooth: Vec<bool> = (0..n).map(|i| has_row && has_opposite(i)).collect();
    for _ in 0..SMOOTHING {
        let average = |i: usize| match is_tooth[i] {
            true => (line[(i + n - 1) % n] + line[i] * 2.0 + line[(i + 1) % n]) / 4.0,
            false => line[i],
        };
        line = (0..n).map(average).collect();
    }
    (line, is_tooth)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A flat rhomb of rows of triangles; of its lowest row those with a side on the edge may be
    /// missing, so that tips are left.
    pub fn rhomb(is_toothed: bool) -> TriangleSurface {
        let (n, row) = (8, 9);
        let place = |v: u32| {
            let (i, j) = (f64::from(v % row), f64::from(v / row));
            Vec3::new(i + 0.5 * j, j, 0.0)
        };
        let first = u32::from(is_toothed);
        let cells = (0..n * n).map(|c| c % n + (c / n) * row);
        let triangles = cells.flat_map(|a| [[a, a + 1, a + row], [a + 1, a + row + 1, a + row]]);
        let has_tip = |t: &[u32; 3]| t.iter().filter(|v| **v < row).count() < 2;
        let kept = triangles.filter(|t| !is_toothed || has_tip(t));
        let kept: Vec<[u32; 3]> = kept.map(|t| t.map(|v| v - first)).collect();
        let places = (first..row * row).map(place).collect();
        TriangleSurface::new(places, &kept).unwrap()
    }

    #[test]
    fn corners_stay_and_teeth_go_as_far_as_they_may() {
        assert!(without_teeth(&rhomb(false), 1.0).is_none());
        let toothed = rhomb(true);
        let last = toothed.positions().len() - 1;
        for (most, tips_stay) in [(0.1, true), (1.0, false)] {
            let Calmed { part: calm, moved } = without_teeth(&toothed, most).unwrap();
            assert!(moved > 0.35_f64.min(0.99 * most) && moved <= most);
            let way = |v: usize| {
                let v = VertexId::new(v as u32);
                let (left, _) = calm.source.enumerate().find(|(_, s)| **s == v)?;
                Some(calm.surface.positions()[left] - toothed.positions()[v])
            };
            // A tip in the middle of the edge, the notch beside it, and the corner at the far end.
            let [tip, notch, corner] = [4, 12, last].map(way);
            assert_eq!(tip.is_some(), tips_stay);
            for way in tip.into_iter().chain(notch) {
                assert!(way.y.abs() > 0.35_f64.min(0.99 * most), "{way}");
                assert!(way.norm() <= most * (1.0 + 1e-12));
            }
            assert_eq!(corner, Some(Vec3::zeros()));
        }
    }

    /// A square grid of triangles without those whose centre lies in a circle.
    fn pierced(radius: f64) -> TriangleSurface {
        let n = 24;
        let place = |v: u32| Vec3::new(f64::from(v % n), f64::from(v / n), 0.0);
        let cells = (0..(n - 1) * (n - 1)).map(|c| c % (n - 1) + c / (n - 1) * n);
        let triangles = cells.flat_map(|a| [[a, a + 1, a + n], [a + 1, a + n + 1, a + n]]);
        let middle = Vec3::new(11.6, 11.3, 0.0);
        let centre = |t: &[u32; 3]| t.map(place).iter().sum::<Vec3>() / 3.0;
        let kept = triangles.filter(|t| (centre(t) - middle).norm() > radius);
        let kept: Vec<[u32; 3]> = kept.collect();
        let used: std::collections::BTreeSet<u32> = kept.iter().flatten().copied().collect();
        let number = |v: u32| used.iter().position(|u| *u == v).unwrap() as u32;
        let triangles: Vec<[u32; 3]> = kept.iter().map(|t| t.map(number)).collect();
        TriangleSurface::new(used.iter().map(|v| place(*v)).collect(), &triangles).unwrap()
    }

    /// A strip whose lower edge turns by `turns` (radians, to the left) at its inner vertices.
    fn strip(turns: &[f64]) -> TriangleSurface {
        let mut lower = vec![Vec3::zeros()];
        let mut way = 0.0_f64;
        for turn in turns.iter().chain(&[0.0]) {
            lower.push(lower[lower.len() - 1] + Vec3::new(way.cos(), way.sin(), 0.0));
            way += turn;
        }
        let n = lower.len() as u32;
        let upper = (0..n).map(|i| Vec3::new(f64::from(i), 9.0, 0.0));
        let places = lower.iter().copied().chain(upper).collect();
        let cells = (0..n - 1).flat_map(|i| [[i, i + 1, n + i], [i + 1, n + i + 1, n + i]]);
        TriangleSurface::new(places, &cells.collect::<Vec<_>>()).unwrap()
    }

    /// A support ends two edges from its corner, where the free edge leaves it.
    #[test]
    fn a_corner_beside_the_end_of_its_support_is_no_tooth() {
        let straight = [0.0; 4];
        let with =
            |turns: &[f64]| without_teeth(&strip(&[&straight, turns, &straight].concat()), 1.0);
        assert!(with(&[-0.8, 0.0, 0.9]).is_none());
        assert!(with(&[-0.8, 0.9, -0.8]).is_some());
    }

    #[test]
    fn small_holes_in_a_grid_are_calmed() {
        let surface = pierced(2.4);
        let holes: Vec<usize> = surface.boundary_loops().iter().map(Vec::len).collect();
        assert!(holes.iter().any(|n| (14..20).contains(n)), "{holes:?}");
        let sharpest = |surface: &TriangleSurface| {
            let loops = surface.boundary_loops();
            let hole = loops.iter().min_by_key(|b| b.len()).unwrap();
            let at = |i: usize| surface.positions()[hole[i % hole.len()]];
            let turn = |i: usize| (at(i + 1) - at(i)).angle(&(at(i + 2) - at(i + 1)));
            (0..hole.len()).map(turn).fold(0.0, f64::max)
        };
        let calm = without_teeth(&surface, 1.0).unwrap().part.surface;
        let (before, after) = (sharpest(&surface), sharpest(&calm));
        assert!(after < 0.7 * before, "{before} {after}");
    }
}
