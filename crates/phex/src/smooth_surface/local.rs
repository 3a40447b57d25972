//! Local refinement: only the edges that are too long are split, where a surface bends faster than
//! its triangles are small.

use super::subdivide::Refinement;
use super::{SmoothTarget, rebuilt};
use phex_mesh::{EdgeId, FaceId, HalfEdgeId, PerEdge, Topology, TriangleSurface, Vec3};

impl SmoothTarget {
    /// The levels up to `level` and one more, on which the edges of that level longer than `limit`
    /// are split in two; `None` if there are none. `length` gives them in any metric; triangles
    /// with two long edges are cut along their shorter median.
    ///
    /// New vertices lie on the cubic curves that the normals at the ends ask for (A. Vlachos et
    /// al., "Curved PN triangles", 2001).
    pub(crate) fn split_longer(
        &self,
        level: usize,
        length: &PerEdge<f64>,
        limit: f64,
    ) -> Option<Self> {
        let surface = &self.levels[level];
        let topology = surface.topology();
        let mut middle = PerEdge::filled(topology.n_edges(), None);
        let long: Vec<EdgeId> = topology.edges().filter(|e| length[*e] > limit).collect();
        if long.is_empty() {
            return None;
        }
        for (i, e) in long.iter().enumerate() {
            middle[*e] = Some((topology.n_vertices() + i) as u32);
        }
        let mut faces = Vec::with_capacity(topology.n_faces() + 2 * long.len());
        for f in topology.faces() {
            split_face(topology, f, &middle, length, &mut faces);
        }
        let mut positions = surface.positions().as_slice().to_vec();
        positions.extend(long.iter().map(|e| curve_middle(surface, *e)));
        let ends = long.iter().map(|e| topology.edge_vertices(*e));
        let mut refinements = self.refinements[..level].to_vec();
        let mut levels = self.levels[..=level].to_vec();
        levels.push(rebuilt(positions, &faces));
        refinements.push(Refinement::with_middles(topology.n_vertices(), ends, faces));
        Some(Self {
            levels,
            refinements,
            corners: self.corners.clone(),
            interpolation_error: self.interpolation_error,
        })
    }
}

/// The pieces of a triangle.
fn split_face(
    topology: &Topology,
    f: FaceId,
    middle: &PerEdge<Option<u32>>,
    length: &PerEdge<f64>,
    faces: &mut Vec<[u32; 3]>,
) {
    let sides: Vec<HalfEdgeId> = topology.face_half_edges(f).collect();
    let edge = |k: usize| topology.edge(sides[k % 3]);
    let corner = |k: usize| topology.origin(sides[k % 3]).index() as u32;
    let middles = [0, 1, 2].map(|k| middle[edge(k)]);
    match middles {
        [None, None, None] => faces.push([0, 1, 2].map(corner)),
        [Some(a), Some(b), Some(c)] => faces.extend([
            [corner(0), a, c],
            [corner(1), b, a],
            [corner(2), c, b],
            [a, b, c],
        ]),
        _ => {
            // Turned so that the only long edge is the first, or the two long ones are the first
            // two.
            let first = |k: &usize| middles[*k].is_some() && middles[(k + 2) % 3].is_none();
            let k = (0..3)
                .find(first)
                .expect("one or two of three edges are long");
            let (p, q, r) = (corner(k), corner(k + 1), corner(k + 2));
            match (middles[k], middles[(k + 1) % 3]) {
                (Some(a), Some(b)) => {
                    faces.push([a, q, b]);
                    faces.extend(if length[edge(k)] >= length[edge(k + 1)] {
                        [[a, b, r], [a, r, p]]
                    } else {
                        [[a, b, p], [b, r, p]]
                    });
                }
                (Some(a), _) => faces.extend([[p, a, r], [a, q, r]]),
                _ => unreachable!("the first edge is long"),
            }
        }
    }
}

/// The middle of the cubic over an edge that the normals at its ends ask for.
fn curve_middle(surface: &TriangleSurface, e: EdgeId) -> Vec3 {
    let [a, b] = surface.topology().edge_vertices(e);
    let [p, q] = [a, b].map(|v| surface.positions()[v]);
    let [m, n] = [a, b].map(|v| surface.normals()[v]);
    let along = q - p;
    (p + q) * 0.5 + (n * along.dot(&n) - m * along.dot(&m)) * 0.125
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth_surface::{TargetOptions, smooth_target};
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn ball() -> SmoothTarget {
        let axes = [("a", 1.0), ("b", 1.0), ("c", 1.0)];
        let ball = Shape::from_name("ellipsoid", &axes).unwrap();
        let ball = triangulate(&ball, &TriangulationOptions::default()).unwrap();
        smooth_target(&ball, 1, &TargetOptions::default())
    }

    /// Any choice of edges leaves a closed surface, whose new vertices are much nearer to the
    /// sphere than the edges' middles.
    #[test]
    fn split_edges_follow_the_sphere() {
        let target = ball();
        let surface = target.finest();
        let topology = surface.topology();
        let length = PerEdge::from_fn(topology.n_edges(), |e| {
            let [a, b] = topology.edge_vertices(e);
            (surface.positions()[a] - surface.positions()[b]).norm()
                * (1.0 + 0.5 * surface.positions()[a].x)
        });
        let mean = length.iter().sum::<f64>() / length.len() as f64;
        let longest = length.iter().copied().fold(0.0, f64::max);
        let finer = target.split_longer(0, &length, mean).expect("long edges");
        let fine = finer.finest();
        assert_eq!(fine.topology().euler_characteristic(), 2);
        let off = |p: &Vec3| (p.norm() - 1.0).abs();
        let worst = fine.positions().iter().map(off).fold(0.0, f64::max);
        let sagitta = longest * longest / 8.0;
        assert!(worst < 0.1 * sagitta, "{worst} of {sagitta}");
        // Values at the vertices go half-way: they are off the cubics by no more than the sagitta,
        // and old vertices stay.
        let half_way = finer.refinements[0].apply(surface.positions());
        for (v, p) in half_way.enumerate() {
            let old = v.index() < topology.n_vertices();
            let most = if old { 0.0 } else { sagitta };
            assert!((p - fine.positions()[v]).norm() <= most);
        }
        assert!(
            finer
                .split_longer(1, &PerEdge::filled(fine.topology().n_edges(), 0.5), 1.0)
                .is_none()
        );
    }
}
