//! Re-entrant corners that the surface gives no reason for: which panels have them, and what they
//! pay where they are to go.
//!
//! Three planar panels at a vertex have no re-entrant corner there, or one; with one their normals
//! go round the other way, as where `K < 0` (Wang and Liu 2010, Theorem 1: panels are inscribed in
//! Dupin's indicatrix, convex where it is an ellipse). What the surface asks for is said by its own
//! normals below the three panels' centres: `dN = S dx` from two differences, with the shape
//! operator `S` at the panels' scale.
//!
//! Penalty `w/2 l^2 max(0, m - s / l^2)^2` for a corner, `s = n . (q - p) x (r - q)` with its
//! neighbours `p` and `r` in the face's plane, which turns as in [`super::barrier`]. The Hessian is
//! the Gauss-Newton part in the fixed plane.

use super::barrier::add_turning;
use super::setting::Setting;
use crate::optimise::panels::{Corner, FaceFrame, FaceShapes, add_block};
use crate::optimise::targets::reference::Reference;
use nalgebra::{Matrix2, Vector3};
use phex_mesh::{Vec2, Vec3};

/// Ratio of the principal curvatures above which panels are to be convex: between it and 0 they are
/// nearly rectangles, which a little makes concave.
const ELLIPTIC: f64 = 0.1;
/// Depth `-s / l^2` of a corner that counts as re-entrant.
const DEPTH: f64 = 0.02;
/// The least `s / l^2` for which nothing is to pay.
const MARGIN: f64 = 0.02;

/// The penalty of all corners of the faces that are to be convex.
pub(in crate::optimise) struct ConcavityTerm {
    pub weight: f64,
    /// Which faces are to be convex.
    pub faces: Vec<bool>,
    /// Mean edge `l`.
    pub edge: f64,
}

impl ConcavityTerm {
    /// Energy of a face.
    pub fn energy(&self, f: usize, corners: &[Corner]) -> f64 {
        if !self.faces[f] {
            return 0.0;
        }
        let squares = turns(corners).map(|t| self.excess(&t).powi(2));
        0.5 * self.weight * self.edge * self.edge * squares.sum::<f64>()
    }

    fn excess(&self, turn: &CornerTurn) -> f64 {
        (MARGIN - turn.area / (self.edge * self.edge)).max(0.0)
    }

    /// Adds gradient and Hessian block of a face.
    pub fn add(
        &self,
        f: usize,
        frame: &FaceFrame,
        corners: &[Corner],
        gradient: &mut [Vec3],
        block: &mut [f64],
    ) {
        if !self.faces[f] {
            return;
        }
        let axes = frame.plane.axes;
        let curved = self.weight / (self.edge * self.edge);
        let mut turning = Vec2::zeros();
        for turn in turns(corners) {
            let excess = self.excess(&turn);
            if excess == 0.0 {
                continue;
            }
            let force = -self.weight * excess;
            let rows = turn.rows.map(|r| axes[0] * r.x + axes[1] * r.y);
            for (p, &i) in turn.corners.iter().enumerate() {
                gradient[i] += rows[p] * force;
                for (q, &j) in turn.corners.iter().enumerate() {
                    if i >= j {
                        let outer = rows[p] * rows[q].transpose() * curved;
                        add_block(block, i, j, &outer);
                    }
                }
            }
            turning += turn.tilt * force;
        }
        add_turning(frame, corners, turning, gradient);
    }
}

/// How the outline turns at a corner.
struct CornerTurn {
    /// Local corners: the one before, the corner, the one after.
    corners: [usize; 3],
    /// `s`, twice the signed area of their triangle.
    area: f64,
    /// Its derivatives by these, in the plane.
    rows: [Vec2; 3],
    /// Its derivatives by the normal, along the axes.
    tilt: Vec2,
}

fn turns(corners: &[Corner]) -> impl Iterator<Item = CornerTurn> + '_ {
    let k = corners.len();
    (0..k).map(move |i| {
        let around = [(i + k - 1) % k, i, (i + 1) % k];
        let [p, q, r] = around.map(|j| &corners[j]);
        let (a, b) = (q.flat - p.flat, r.flat - q.flat);
        let (rise_a, rise_b) = (q.height - p.height, r.height - q.height);
        let by_a = Vec2::new(b.y, -b.x);
        let by_b = Vec2::new(-a.y, a.x);
        CornerTurn {
            corners: around,
            area: a.perp(&b),
            rows: [-by_a, by_a - by_b, by_b],
            tilt: Vec2::new(a.y * rise_b - rise_a * b.y, rise_a * b.x - a.x * rise_b),
        }
    })
}

/// Depth of the deepest re-entrant corner of a face, over the square of a length; 0 if it is
/// convex.
pub(super) fn depth(corners: &[Corner], edge: f64) -> f64 {
    let deepest = turns(corners).map(|t| -t.area).fold(0.0, f64::max);
    deepest / (edge * edge)
}

/// Whether a face counts as concave.
pub(in crate::optimise) fn is_concave(corners: &[Corner], edge: f64) -> bool {
    depth(corners, edge) > DEPTH
}

/// Faces that the surface wants convex: all of their inner vertices, of which there are some, lie
/// where `K > 0`.
pub(in crate::optimise) fn to_be_convex(setting: &Setting<'_>, shape: &FaceShapes) -> Vec<bool> {
    let panels = setting.panels;
    let Reference::Surface(target) = setting.reference else {
        return vec![false; panels.n_faces()];
    };
    let centres: Vec<Vec3> = shape.frames.iter().map(|f| f.plane.centre).collect();
    let feet = target.closest_points(&centres, &[]);
    let elliptic = |v: usize| {
        let corners = panels.corners_at(v);
        let [f, g, h] = *corners else {
            return None;
        };
        let [f, g, h] = [f, g, h].map(|c| &feet[panels.face_of(c)]);
        let differences = |of: [Vec3; 3]| [of[1] - of[0], of[2] - of[0]];
        let steps = differences([f, g, h].map(|t| t.position));
        let turns = differences([f, g, h].map(|t| t.normal));
        let normal = f.normal + g.normal + h.normal;
        Some(curvature_ratio(steps, turns, normal) > ELLIPTIC)
    };
    let elliptic: Vec<Option<bool>> = (0..panels.n_vertices()).map(elliptic).collect();
    let of_face = |f: usize| {
        let inner = panels.vertices(f).iter();
        let mut inner = inner.filter_map(|&v| elliptic[v as usize]).peekable();
        inner.peek().is_some() && inner.all(|e| e)
    };
    (0..panels.n_faces()).map(of_face).collect()
}

/// Smaller over larger principal curvature of the shape operator that takes two steps to turns of
/// the normal; negative where `K < 0`.
fn curvature_ratio(steps: [Vec3; 2], turns: [Vec3; 2], normal: Vec3) -> f64 {
    let across = normal.cross(&steps[0]);
    let (Some(u), Some(v)) = (
        normal.cross(&across).try_normalize(0.0),
        across.try_normalize(0.0),
    ) else {
        return 0.0;
    };
    let flat = |d: [Vec3; 2]| {
        Matrix2::from_columns(&d.map(|d: Vector3<f64>| Vec2::new(u.dot(&d), v.dot(&d))))
    };
    let Some(inverse) = flat(steps).try_inverse() else {
        return 0.0;
    };
    let shape = flat(turns) * inverse;
    let curvatures = ((shape + shape.transpose()) * 0.5).symmetric_eigenvalues();
    let (a, b) = (curvatures[0], curvatures[1]);
    let larger = a.abs().max(b.abs());
    if larger > 0.0 {
        a * b / (larger * larger)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::holds::Holds;
    use crate::optimise::options::OptimiseOptions;
    use crate::optimise::panels::{Panels, unknowns};
    use crate::optimise::solver::emphasis::{EMPHASES, Lack};
    use crate::optimise::solver::path::Path;
    use crate::optimise::solver::solvers::Solvers;
    use crate::optimise::terms::guard::Guard;
    use crate::optimise::terms::setting::distances;
    use crate::optimise::tests::fixtures::{Shape as Surface, brick_wall, planar_saddle};
    use crate::progress::Silent;
    use phex_mesh::HexMesh;

    /// Calls `test` with a mesh whose panels are to be close to a surface.
    fn with_setting(mesh: &HexMesh, surface: Surface, test: impl FnOnce(&Setting<'_>, &[f64])) {
        let panels = Panels::new(mesh.topology());
        let x = unknowns(mesh);
        let corner = vec![false; panels.n_vertices()];
        let setting = Setting {
            panels: &panels,
            reference: &Reference::Surface(&surface),
            guard: &Guard::new(mesh.topology(), None, 0.1),
            rim: &[],
            corner: &corner,
            holds: &Holds::default(),
            areas: &super::super::areas::any(panels.n_faces()),
            limits: &crate::optimise::FaceLimits::none(panels.n_faces()),
            mean_edge: panels.mean_edge(&x),
        };
        test(&setting, &x);
    }

    /// `K` of the wave has the sign of `sin x sin y`.
    #[test]
    fn panels_are_to_be_convex_where_the_surface_is() {
        let mesh = brick_wall(Surface::Wave, 60, 40);
        with_setting(&mesh, Surface::Wave, |setting, x| {
            let shape = FaceShapes::at(setting.panels, x);
            let convex = to_be_convex(setting, &shape);
            let (mut yes, mut no) = (0, 0);
            for (f, convex) in convex.iter().enumerate() {
                let centre = shape.frames[f].plane.centre;
                let product = centre.x.sin() * centre.y.sin();
                assert!(!convex || product > 0.0, "{f}: {product}");
                assert!(*convex || product < 0.6, "{f}: {product}");
                *(if *convex { &mut yes } else { &mut no }) += 1;
            }
            assert!(yes > 50 && no > 50, "{yes} convex, {no} not");
        });
    }

    /// A saddle that bends hardly is near a sphere that bends hardly; its panels are concave, and
    /// need not be.
    #[test]
    fn concave_panels_become_convex_where_the_surface_is() {
        let (mesh, radius) = (planar_saddle(9, 5, 1e-3), 1e3);
        let lifted = mesh.mapped(|p| p + Vec3::z() * radius);
        let sphere = Surface::Ellipsoid(Vec3::repeat(radius));
        with_setting(&lifted, sphere, |setting, x| {
            let panels = setting.panels;
            let concave = |x: &[f64]| {
                let shape = FaceShapes::at(panels, x);
                let faces = 0..panels.n_faces();
                let concave = |&f: &usize| is_concave(shape.face(panels, f), setting.mean_edge);
                faces.filter(concave).count()
            };
            let farthest = |x: &[f64]| distances(setting, x).into_iter().fold(0.0, f64::max);
            assert!(concave(x) > 10, "{}", concave(x));
            let options = OptimiseOptions::default();
            let mut solvers = Solvers::new(panels).unwrap();
            let mut path = Path::new(setting, &mut solvers, x, &options, &Silent).unwrap();
            let mut after = x.to_vec();
            for round in 0..EMPHASES {
                let lack = Lack::at(setting, &after);
                after = path.emphasised(&after, (&lack, None), round).unwrap();
            }
            assert_eq!(concave(&after), 0);
            let height = FaceShapes::at(panels, &after).max_height();
            assert!(height < 1e-12 * setting.mean_edge, "{height:e}");
            assert!(farthest(&after) <= farthest(x));
        });
    }
}
