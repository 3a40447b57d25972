//! Local refinement: only the edges that are too long are split, where a surface bends faster than
//! its triangles are small.

use super::subdivide::{Refinement, Splits};
use super::{SmoothTarget, rebuilt};
use phex_mesh::{EdgeId, PerEdge, TriangleSurface, Vec3};

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
        let splits = Splits::longer(length.clone(), limit);
        if splits.edges().is_empty() {
            return None;
        }
        let half_way = |e| topology.edge_vertices(e).map(|v| (v, 0.5)).to_vec();
        let (step, _) = Refinement::with_stencils(topology, &splits, |v| vec![(v, 1.0)], half_way);
        let mut positions = surface.positions().as_slice().to_vec();
        positions.extend(splits.edges().iter().map(|e| curve_middle(surface, *e)));
        let mut levels = self.levels[..=level].to_vec();
        levels.push(rebuilt(positions, &step.faces));
        let mut refinements = self.refinements[..level].to_vec();
        refinements.push(step);
        Some(Self {
            levels,
            refinements,
            corners: self.corners.clone(),
            interpolation_error: self.interpolation_error,
        })
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
            let [a, _] = topology.edge_vertices(e);
            surface.edge_length(e) * (1.0 + 0.5 * surface.positions()[a].x)
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
