//! Convex hulls by exact predicates.
//!
//! Quickhull (Barber, Dobkin, Huhdanpaa 1996) with Shewchuk's `orient3d` as the only decision:
//! every point outside is kept with one face that sees it; a point is added by replacing the faces
//! that see it with the cone over their rim. Points that lie in the plane of a face do not see it.

use phex_mesh::{Vec3, volume};
use std::collections::HashMap;
use thiserror::Error;

/// Why there is no hull.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum HullError {
    /// The points lie in one plane.
    #[error(
        "all {points} points lie in one plane (or there are fewer than four): they have no hull"
    )]
    Flat {
        /// How many points there are.
        points: usize,
    },
    /// A coordinate is no number.
    #[error("point {point} is not finite")]
    NotFinite {
        /// The first such point.
        point: usize,
    },
}

/// Triangles of the convex hull, counter-clockwise seen from outside. Points inside the hull or in
/// the plane of one of its faces are in no triangle.
///
/// # Errors
/// If the points lie in one plane or are not finite.
pub(crate) fn convex_hull(points: &[Vec3]) -> Result<Vec<[u32; 3]>, HullError> {
    if let Some(point) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(HullError::NotFinite { point });
    }
    let simplex = simplex(points).ok_or(HullError::Flat {
        points: points.len(),
    })?;
    let mut hull = Hull::new(points, simplex);
    while let Some(face) = hull.waiting.pop() {
        hull.add_outermost(face);
    }
    let alive = hull.faces.into_iter().filter(|f| f.alive);
    Ok(alive.map(|f| f.corners).collect())
}

/// Four points that lie in no plane, the first three counter-clockwise seen from the side where the
/// last is not.
fn simplex(points: &[Vec3]) -> Option<[u32; 4]> {
    let largest = |value: &dyn Fn(usize) -> f64| {
        let best =
            (0..points.len()).max_by(|&a, &b| value(a).total_cmp(&value(b)).then(b.cmp(&a)))?;
        (value(best) > 0.0).then_some(best)
    };
    let a = 0;
    points.first()?;
    let b = largest(&|i| (points[i] - points[a]).norm())?;
    let along = points[b] - points[a];
    let c = largest(&|i| along.cross(&(points[i] - points[a])).norm())?;
    let d = largest(&|i| volume(points[a], points[b], points[c], points[i]).abs())?;
    let front = volume(points[a], points[b], points[c], points[d]) > 0.0;
    let order = if front { [a, b, c, d] } else { [a, c, b, d] };
    Some(order.map(|i| i as u32))
}

struct Face {
    corners: [u32; 3],
    /// Points that see this face and are kept nowhere else.
    outside: Vec<u32>,
    alive: bool,
}

struct Hull<'a> {
    points: &'a [Vec3],
    faces: Vec<Face>,
    /// Face to the left of each directed edge.
    left_of: HashMap<(u32, u32), usize>,
    /// Faces that may have points outside.
    waiting: Vec<usize>,
}

impl<'a> Hull<'a> {
    fn new(points: &'a [Vec3], [a, b, c, d]: [u32; 4]) -> Self {
        let mut hull = Self {
            points,
            faces: Vec::new(),
            left_of: HashMap::new(),
            waiting: Vec::new(),
        };
        let all = (0..points.len() as u32).filter(|p| ![a, b, c, d].contains(p));
        hull.cover(&[[a, b, c], [a, d, b], [b, d, c], [c, d, a]], all.collect());
        hull
    }

    fn sees(&self, point: u32, corners: [u32; 3]) -> bool {
        let [a, b, c] = corners.map(|i| self.points[i as usize]);
        volume(a, b, c, self.points[point as usize]) < 0.0
    }

    /// Adds faces, and gives each of the points outside to the first of them that it sees.
    fn cover(&mut self, triangles: &[[u32; 3]], points: Vec<u32>) {
        let first = self.faces.len();
        for &corners in triangles {
            for k in 0..3 {
                let edge = (corners[k], corners[(k + 1) % 3]);
                self.left_of.insert(edge, self.faces.len());
            }
            self.faces.push(Face {
                corners,
                outside: Vec::new(),
                alive: true,
            });
        }
        for p in points {
            let seen = (first..self.faces.len()).find(|&f| self.sees(p, self.faces[f].corners));
            if let Some(f) = seen {
                self.faces[f].outside.push(p);
            }
        }
        self.waiting.extend(first..self.faces.len());
    }

    /// Adds the point outside a face that is farthest from its plane, about.
    fn add_outermost(&mut self, face: usize) {
        if !self.faces[face].alive || self.faces[face].outside.is_empty() {
            return;
        }
        let [a, b, c] = self.faces[face].corners.map(|i| self.points[i as usize]);
        let normal = (b - a).cross(&(c - a));
        let height = |p: u32| normal.dot(&(self.points[p as usize] - a));
        let outside = self.faces[face].outside.iter().copied();
        let apex = outside.max_by(|&p, &q| height(p).total_cmp(&height(q)).then(q.cmp(&p)));
        let apex = apex.expect("the list is not empty");
        let seen = self.taken_out(apex, face);
        let mut orphans = Vec::new();
        for &f in &seen {
            orphans.append(&mut self.faces[f].outside);
        }
        orphans.retain(|&p| p != apex);
        let rim: Vec<[u32; 3]> = seen
            .iter()
            .flat_map(|&f| {
                let t = self.faces[f].corners;
                (0..3).map(move |k| (t[k], t[(k + 1) % 3]))
            })
            .filter(|&(p, q)| self.faces[self.left_of[&(q, p)]].alive)
            .map(|(p, q)| [p, q, apex])
            .collect();
        self.cover(&rim, orphans);
    }

    /// Takes out all faces that a point sees, beginning with one of them.
    fn taken_out(&mut self, point: u32, start: usize) -> Vec<usize> {
        self.faces[start].alive = false;
        let mut seen = vec![start];
        let mut next = 0;
        while next < seen.len() {
            let t = self.faces[seen[next]].corners;
            for k in 0..3 {
                let neighbour = self.left_of[&(t[(k + 1) % 3], t[k])];
                let Face { alive, corners, .. } = self.faces[neighbour];
                if alive && self.sees(point, corners) {
                    self.faces[neighbour].alive = false;
                    seen.push(neighbour);
                }
            }
            next += 1;
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Topology;
    use proptest::prelude::*;

    fn assert_hull(points: &[Vec3], hull: &[[u32; 3]]) {
        let mut used: Vec<u32> = hull.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap() as u32;
        let faces: Vec<[u32; 3]> = hull.iter().map(|t| t.map(number)).collect();
        let topology = Topology::from_faces(used.len(), &faces).unwrap();
        assert_eq!(topology.euler_characteristic(), 2);
        assert!(topology.boundary_loops().is_empty());
        for t in hull {
            let [a, b, c] = t.map(|i| points[i as usize]);
            assert!(
                points.iter().all(|&p| volume(a, b, c, p) >= 0.0),
                "a point outside {t:?}"
            );
        }
    }

    #[test]
    fn degenerate_grids_and_spheres() {
        let grid: Vec<Vec3> = (0..125)
            .map(|i| Vec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)))
            .collect();
        assert_hull(&grid, &convex_hull(&grid).unwrap());
        // Four by four on parallels of a sphere: every face of the true hull has four corners.
        let ring = |i: u32| [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][i as usize];
        let sphere: Vec<Vec3> = (0..16)
            .map(|i| (ring(i % 4), f64::from(i / 4) - 1.5))
            .map(|((x, y), z)| Vec3::new(x, y, 0.5 * z))
            .collect();
        assert_hull(&sphere, &convex_hull(&sphere).unwrap());
    }

    #[test]
    fn points_without_a_hull_are_refused() {
        let flat: Vec<Vec3> = (0..9)
            .map(|i| Vec3::new(f64::from(i % 3), f64::from(i / 3), 1.0))
            .collect();
        assert_eq!(convex_hull(&flat), Err(HullError::Flat { points: 9 }));
        assert_eq!(convex_hull(&[]), Err(HullError::Flat { points: 0 }));
        let bad = [Vec3::zeros(), Vec3::x(), Vec3::repeat(f64::NAN), Vec3::z()];
        assert_eq!(convex_hull(&bad), Err(HullError::NotFinite { point: 2 }));
    }

    proptest! {
        #[test]
        fn no_point_lies_outside(points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 5..60)) {
            let points: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
            if let Ok(hull) = convex_hull(&points) {
                assert_hull(&points, &hull);
            }
        }
    }
}
