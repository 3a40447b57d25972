//! What a panelling is kept close to: a surface, or the start itself.

use crate::optimise::panels::{FaceShapes, Panels, point};
use crate::optimise::{Target, TargetPoint};
use phex_mesh::{BoundaryPoint, Vec3};

/// What a panelling is kept close to.
pub(in crate::optimise) enum Reference<'a> {
    /// A surface; foot points are sought.
    Surface(&'a dyn Target),
    /// The start itself: a plane for each vertex and for each face centre.
    Start { planes: Vec<TargetPoint> },
}

impl<'a> Reference<'a> {
    /// Tangent planes of a mesh at its own vertices and face centres.
    pub fn start(panels: &Panels, x: &[f64]) -> Self {
        let shape = FaceShapes::at(panels, x);
        let vertex = |v: usize| {
            let normals = panels.corners_at(v).iter();
            let sum: Vec3 = normals.map(|&c| shape.normal(panels.face_of(c))).sum();
            TargetPoint {
                position: point(x, v),
                normal: sum.try_normalize(0.0).unwrap_or_else(Vec3::z),
            }
        };
        let centre = |f: usize| TargetPoint {
            position: shape.frames[f].plane.centre,
            normal: shape.normal(f),
        };
        let vertices = (0..panels.n_vertices()).map(vertex);
        let planes = vertices.chain((0..panels.n_faces()).map(centre)).collect();
        Self::Start { planes }
    }

    /// What some of the `n` vertices and some faces are kept close to.
    pub fn part(&self, n: usize, vertices: &[u32], faces: &[u32]) -> Reference<'a> {
        match self {
            Self::Surface(target) => Reference::Surface(*target),
            Self::Start { planes } => {
                let vertices = vertices.iter().map(|&v| planes[v as usize]);
                let centres = faces.iter().map(|&f| planes[n + f as usize]);
                let planes = vertices.chain(centres).collect();
                Reference::Start { planes }
            }
        }
    }

    /// Foot points of vertices and then of face centres. `last` are those that were found last,
    /// near which they are sought, and of which points: what has not moved since keeps its own.
    pub fn feet(&self, points: &[Vec3], last: (&[Vec3], &[TargetPoint])) -> Vec<TargetPoint> {
        match self {
            Self::Surface(target) => feet_of_moved(*target, points, last),
            Self::Start { planes } => {
                let foot = |(plane, p): (&TargetPoint, &Vec3)| TargetPoint {
                    position: p - plane.normal * plane.normal.dot(&(p - plane.position)),
                    normal: plane.normal,
                };
                planes.iter().zip(points).map(foot).collect()
            }
        }
    }

    pub fn on_boundary(&self, points: &[Vec3]) -> Option<Vec<BoundaryPoint>> {
        match self {
            Self::Surface(target) if !points.is_empty() => target.closest_on_boundary(points),
            _ => None,
        }
    }
}

/// Foot points on a surface, sought only for points that are not where they were.
fn feet_of_moved(
    target: &dyn Target,
    points: &[Vec3],
    (before, feet): (&[Vec3], &[TargetPoint]),
) -> Vec<TargetPoint> {
    if feet.len() != points.len() {
        return target.closest_points(points, &[]);
    }
    let moved = (0..points.len()).filter(|&k| before.get(k) != Some(&points[k]));
    let moved: Vec<usize> = moved.collect();
    let places: Vec<Vec3> = moved.iter().map(|&k| points[k]).collect();
    let near: Vec<TargetPoint> = moved.iter().map(|&k| feet[k]).collect();
    let mut all = feet.to_vec();
    for (k, foot) in moved.into_iter().zip(target.closest_points(&places, &near)) {
        all[k] = foot;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// The ground plane, and how many points were asked for.
    struct Ground(AtomicUsize);

    impl Target for Ground {
        fn closest_points(&self, points: &[Vec3], _: &[TargetPoint]) -> Vec<TargetPoint> {
            self.0.fetch_add(points.len(), Ordering::Relaxed);
            let foot = |p: &Vec3| TargetPoint {
                position: Vec3::new(p.x, p.y, 0.0),
                normal: Vec3::z(),
            };
            points.iter().map(foot).collect()
        }

        fn closest_on_boundary(&self, _: &[Vec3]) -> Option<Vec<BoundaryPoint>> {
            None
        }
    }

    #[test]
    fn what_has_not_moved_keeps_its_foot() {
        let ground = Ground(AtomicUsize::new(0));
        let reference = Reference::Surface(&ground);
        let mut points: Vec<Vec3> = (0..5).map(|k| Vec3::repeat(f64::from(k))).collect();
        let (before, feet) = (points.clone(), reference.feet(&points, (&[], &[])));
        points[3].x = 7.0;
        let now = reference.feet(&points, (&before, &feet));
        assert_eq!(ground.0.load(Ordering::Relaxed), 6);
        assert_eq!(now, ground.closest_points(&points, &[]));
    }
}
