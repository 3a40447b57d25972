//! Flips that make panels of given planes valid: those of the convex hull where `K > 0`, those that
//! obey the sign rule where `K < 0`.

use super::panels::{Flipped, PanelOutlines, Star};
use super::{DualityError, OrientedPlane, Quadric, clear_centre, meet};
use phex_mesh::polygon::is_simple;
use phex_mesh::{FaceId, FlatFace, HexMesh, PerFace, Vec3, VertexId, volume};
use std::collections::BTreeSet;

/// Steps per edge at the most: far more than are needed where the poles lie on a convex surface,
/// and an end where they do not.
const STEPS_PER_EDGE: usize = 20;
/// Corners that flips leave to a panel where `K < 0`: triangles are never simple there.
const LEAST_SADDLE: usize = 4;

/// Panels joined as the hull of their planes' poles is, by [`convex_flips`]; nothing changes where
/// no centre avoids the planes. The hull does not depend on the centre: it is the dual of the
/// convex body that the planes bound.
///
/// # Errors
/// If a plane passes through the centre that avoids them best.
pub(crate) fn convex_panels(
    mesh: &HexMesh,
    planes: &PerFace<OrientedPlane>,
    points: &PerFace<Vec3>,
) -> Result<Flipped, DualityError> {
    let (centre, clearness) = clear_centre(planes.as_slice(), points.as_slice());
    if clearness <= 0.0 {
        return Ok(Flipped::unchanged(mesh));
    }
    hull_about(mesh, planes, &Quadric::sphere(centre, 1.0)?)
}

/// The same with the poles in a given quadric, whose centre must lie on one side of all planes.
///
/// # Errors
/// If a plane passes through the centre, or the quadric has none.
pub(crate) fn hull_about(
    mesh: &HexMesh,
    planes: &PerFace<OrientedPlane>,
    quadric: &Quadric,
) -> Result<Flipped, DualityError> {
    let poles = planes
        .enumerate()
        .map(|(f, plane)| quadric.pole_of(f, plane));
    let poles: Result<Vec<Vec3>, _> = poles.collect();
    let centre = quadric.centre().ok_or(DualityError::SingularQuadric)?;
    Ok(convex_flips(mesh, &PerFace::from_vec(poles?), centre))
}

/// Panels whose touching points are joined as the poles are in their convex hull, inside the given
/// rim, for poles that lie round `centre`.
///
/// An edge between two panels whose dual edge is reflex is replaced by one between the panels at
/// its ends (Lawson's flips, seen from the dual); a triangle at such an edge is taken out, because
/// its pole lies inside the hull and its plane cuts nothing off (Edelsbrunner and Shah 1996). On a
/// convex dual surface this ends with the part of the hull that lies over the panels; every panel
/// is then convex.
pub(crate) fn convex_flips(mesh: &HexMesh, poles: &PerFace<Vec3>, centre: Vec3) -> Flipped {
    let pole = |f: u32| poles[FaceId::new(f)];
    // Round the first end of an edge the panels run: left, before, right.
    let first = |s: &Star| [s.left, s.before, s.right].map(pole);
    let side = |[a, b, c]: [Vec3; 3], d: Vec3| volume(a, b, c, d);
    let panels = PanelOutlines::new(mesh);
    let edges = panels.inner_edges(mesh);
    let stars = edges.iter().filter_map(|e| panels.star(*e));
    let votes: f64 = stars.map(|s| side(first(&s), centre).signum()).sum();
    // 1 where the poles of panels round a vertex are seen counter-clockwise from outside.
    let sense = if votes < 0.0 { -1.0 } else { 1.0 };
    flipped(mesh, |panels, star| {
        if sense * side(first(star), pole(star.behind)) >= 0.0 {
            return FlipStep::Stay;
        }
        let mut sides = [star.left, star.right].into_iter();
        if let Some(hidden) = sides.find(|&f| panels.valence(f) == 3) {
            return FlipStep::TakeOut(hidden);
        }
        let outward = |t: [u32; 3]| sense * side(t.map(pole), centre) > 0.0;
        FlipStep::flip_if(star.turned().into_iter().all(outward), 3)
    })
}

/// Panels whose touching points are joined so that the edges of their triangles lie on both sides
/// of the asymptotic cone, as far as flips can do it: the panels in a lattice are then simple where
/// `K < 0`.
pub(crate) fn saddle_flips(
    mesh: &HexMesh,
    planes: &PerFace<OrientedPlane>,
    points: &PerFace<Vec3>,
) -> Flipped {
    let form = |f: u32, g: u32| {
        let (f, g) = (FaceId::new(f), FaceId::new(g));
        (points[g] - points[f]).dot(&(planes[g].normal - planes[f].normal))
    };
    let wrong = |[f, g, h]: [u32; 3]| {
        let signs = [form(f, g), form(g, h), form(h, f)].map(|q| q > 0.0);
        usize::from(signs[0] == signs[1] && signs[1] == signs[2])
    };
    let turn = |[f, g, h]: [u32; 3]| -> f64 {
        let [p, q, r] = [f, g, h].map(|i| points[FaceId::new(i)]);
        let normals = [f, g, h].map(|i| planes[FaceId::new(i)].normal);
        (q - p).cross(&(r - p)).dot(&normals.iter().sum())
    };
    flipped(mesh, |_, star| {
        let now = [
            [star.left, star.before, star.right],
            [star.right, star.behind, star.left],
        ];
        let count = |triangles: [[u32; 3]; 2]| triangles.map(wrong).iter().sum::<usize>();
        let better = count(star.turned()) < count(now);
        let sense = turn(now[0]) + turn(now[1]);
        let convex = star.turned().into_iter().all(|t| turn(t) * sense > 0.0);
        FlipStep::flip_if(better && convex, LEAST_SADDLE)
    })
}

/// Panels of which fewer cross themselves: an edge of one that does is flipped where that leaves
/// fewer such panels round it. Vertices inside lie where the planes of their panels meet, those at
/// the boundary where they are.
pub(crate) fn uncrossing_flips(mesh: &HexMesh, planes: &PerFace<OrientedPlane>) -> Flipped {
    let place = |panels: &PanelOutlines, v: u32| {
        let near = mesh.positions[VertexId::new(v)];
        let around = panels.faces_at(v);
        let planes = around.map(|faces| faces.map(|f| planes[FaceId::new(f)]));
        planes.map_or(Some(near), |planes| meet(&planes, near))
    };
    let crosses = |panels: &PanelOutlines, f: u32| {
        let corners = panels.corners(f).iter().map(|&v| place(panels, v));
        let corners: Option<Vec<Vec3>> = corners.collect();
        corners.is_none_or(|c| !is_simple(&FlatFace::new(&c).polygon))
    };
    let count = |panels: &PanelOutlines, star: &Star| {
        let four = [star.left, star.right, star.before, star.behind];
        four.into_iter().filter(|&f| crosses(panels, f)).count()
    };
    flipped(mesh, |panels, star| {
        let now = count(panels, star);
        if now == 0 || !panels.can_flip(star, LEAST_SADDLE) {
            return FlipStep::Stay;
        }
        let mut turned = panels.clone();
        turned.flip(star);
        FlipStep::flip_if(count(&turned, star) < now, LEAST_SADDLE)
    })
}

/// What becomes of an edge.
enum FlipStep {
    /// Nothing.
    Stay,
    /// It is flipped, if the panels at it keep so many corners.
    Flip { least: usize },
    /// A triangle at it is taken out.
    TakeOut(u32),
}

impl FlipStep {
    fn flip_if(wanted: bool, least: usize) -> Self {
        if wanted {
            Self::Flip { least }
        } else {
            Self::Stay
        }
    }
}

/// Takes steps at the edges inside until none is left; edges near a step are looked at again.
fn flipped(mesh: &HexMesh, step: impl Fn(&PanelOutlines, &Star) -> FlipStep) -> Flipped {
    let mut panels = PanelOutlines::new(mesh);
    let mut waiting: BTreeSet<[u32; 2]> = panels.inner_edges(mesh).into_iter().collect();
    let limit = STEPS_PER_EDGE * waiting.len();
    let mut steps = 0;
    while let Some(edge) = waiting.pop_first() {
        let Some(star) = panels.star(edge).filter(|_| steps < limit) else {
            continue;
        };
        let touched = match step(&panels, &star) {
            FlipStep::Flip { least } if panels.can_flip(&star, least) => {
                panels.flip(&star);
                star.ends.to_vec()
            }
            FlipStep::TakeOut(f) => panels.take_out(f).into_iter().collect(),
            _ => Vec::new(),
        };
        steps += usize::from(!touched.is_empty());
        waiting.extend(panels.edges_round(&touched));
    }
    let made = panels.into_mesh(mesh, steps);
    made.unwrap_or_else(|_| Flipped::unchanged(mesh))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classical::duality::{dual_mesh, envelope};
    use phex_mesh::{PerFace, measure};

    /// A cube with a corner cut off at a distance from its middle, and the planes of its faces.
    fn cut_cube(height: f64) -> (HexMesh, PerFace<OrientedPlane>) {
        let at = |i: u32| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
        let mut positions: Vec<Vec3> = (0..7).map(at).collect();
        positions.extend([Vec3::x(), Vec3::y(), Vec3::z()].map(|e| at(7) - e * 0.5));
        // 7 cut off along x, 8 along y, 9 along z.
        let faces: [&[u32]; 7] = [
            &[0, 4, 6, 2],
            &[0, 1, 5, 4],
            &[0, 2, 3, 1],
            &[1, 3, 9, 8, 5],
            &[2, 6, 7, 9, 3],
            &[4, 5, 8, 7, 6],
            &[7, 8, 9],
        ];
        let lists: Vec<Vec<u32>> = faces.iter().map(|f| f.to_vec()).collect();
        let mesh = HexMesh::new(positions, &lists).unwrap();
        let plane = |normal: Vec3, offset| OrientedPlane { normal, offset };
        let sides = [Vec3::x(), Vec3::y(), Vec3::z()];
        let mut planes: Vec<OrientedPlane> = sides.iter().map(|n| plane(-n, 1.0)).collect();
        planes.extend(sides.map(|n| plane(n, 1.0)));
        planes.push(plane(Vec3::repeat(3f64.sqrt().recip()), height));
        (mesh, PerFace::from_vec(planes))
    }

    #[test]
    fn a_plane_that_cuts_nothing_off_loses_its_panel() {
        let sphere = Quadric::sphere(Vec3::new(0.1, 0.0, -0.1), 1.0).unwrap();
        let (mesh, planes) = cut_cube(1.6);
        let kept = hull_about(&mesh, &planes, &sphere).unwrap();
        assert_eq!((kept.steps, kept.faces.len()), (0, 7));
        let (mesh, planes) = cut_cube(1.8);
        let hull = hull_about(&mesh, &planes, &sphere).unwrap();
        assert_eq!((hull.steps, hull.faces.len()), (1, 6));
        assert!(hull.faces.iter().all(|f| f.index() < 6));
        let planes = planes.picked(&hull.faces);
        let cube = envelope(&hull.mesh, &planes).unwrap();
        let measures = measure(&cube);
        assert_eq!((measures.vertices, measures.face_sizes[&4]), (8, 6));
        assert!((measures.area - 24.0).abs() < 1e-12);
    }

    /// Panels on the saddle `2 z = x^2 - y^2` about a lattice, some of whose cells are cut by the
    /// diagonal that leaves all edges of a triangle on one side of the asymptotic cone; their
    /// planes and touching points.
    fn saddle(
        wrong: impl Fn(u32, u32) -> bool,
    ) -> (HexMesh, PerFace<OrientedPlane>, PerFace<Vec3>) {
        const SIDE: u32 = 9;
        let middle = 0.5 * f64::from(SIDE - 1);
        let on_saddle = |i: u32, j: u32| {
            let (u, v) = (f64::from(i) - middle, f64::from(j) - middle);
            let (x, y) = (0.10 * u + 0.08 * v, 0.02 * u - 0.03 * v);
            Vec3::new(x, y, 0.5 * (x * x - y * y))
        };
        let cells = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j)));
        let points: Vec<Vec3> = cells.map(|(i, j)| on_saddle(i, j)).collect();
        let cell = |(i, j): (u32, u32)| {
            let at = |a: u32, b: u32| (i + a) * SIDE + j + b;
            // Turned so that normals point up.
            if wrong(i, j) {
                [
                    [at(0, 0), at(1, 1), at(1, 0)],
                    [at(0, 0), at(0, 1), at(1, 1)],
                ]
            } else {
                [
                    [at(0, 0), at(0, 1), at(1, 0)],
                    [at(1, 0), at(0, 1), at(1, 1)],
                ]
            }
        };
        let inner = (0..SIDE - 1).flat_map(|i| (0..SIDE - 1).map(move |j| (i, j)));
        let triangles: Vec<[u32; 3]> = inner.flat_map(cell).collect();
        let triangles = HexMesh::new(points.clone(), &triangles).unwrap();
        let quadric = Quadric::sphere(Vec3::new(0.0, 0.0, -3.0), 1.0).unwrap();
        let dual = dual_mesh(&triangles, &quadric).unwrap();
        let touching = dual.vertex_of_face.iter().map(|v| points[v.index()]);
        let touching = PerFace::from_vec(touching.collect());
        let planes =
            touching.map(|p| OrientedPlane::through(*p, Vec3::new(-p.x, p.y, 1.0).normalize()));
        (dual.mesh, planes, touching)
    }

    #[test]
    fn edges_come_to_lie_on_both_sides_of_the_asymptotic_cone() {
        let crossing = |mesh: &HexMesh, planes: &PerFace<OrientedPlane>| {
            let made = envelope(mesh, planes).unwrap();
            let topology = made.topology();
            // At the rim vertices lie where they are put.
            let inner = topology.inner_faces();
            let wrong = inner.filter(|f| !is_simple(&FlatFace::of(&made, *f).polygon));
            wrong.count()
        };
        let (mesh, planes, points) = saddle(|_, _| true);
        assert!(crossing(&mesh, &planes) > 20);
        let ruled = saddle_flips(&mesh, &planes, &points);
        assert_eq!(crossing(&ruled.mesh, &planes), 0);
        assert!(ruled.steps > 20 && ruled.faces.len() == planes.len());
        // What is right already stays.
        assert_eq!(saddle_flips(&ruled.mesh, &planes, &points).steps, 0);
        // A few wrong edges are found by what they do.
        let (mesh, planes, _) = saddle(|i, j| (i, j) == (3, 4) || (i, j) == (6, 2));
        assert!(crossing(&mesh, &planes) > 2);
        let given = envelope(&mesh, &planes).unwrap();
        let flipped = uncrossing_flips(&given, &planes);
        assert_eq!(crossing(&flipped.mesh, &planes), 0);
    }
}
