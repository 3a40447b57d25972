//! Superelliptic domains: ring number `k` is the boundary curve shrunk towards the centre and has
//! `6 k` vertices, as in the equilateral lattice. The rim's vertices are equally far apart on the
//! surface, and every ring takes its spacing from the rim.

use super::jitter::{Jitter, safe_edges};
use super::rows::{LatticeRow, stitch};
use super::{ParameterMesh, TriangulationOptions};
use crate::Vec2;
use crate::shapes::domain::BoundaryArc;
use crate::shapes::parametric::ParametricSurface;

/// Steps for measuring the length of the boundary curve.
const LENGTH_STEPS: usize = 4096;

pub(super) fn mesh<S: ParametricSurface + ?Sized>(
    surface: &S,
    options: &TriangulationOptions,
) -> ParameterMesh {
    // k rings have 6 k^2 triangles.
    let rings = (options.triangles as f64 / 6.0).sqrt().round().max(2.0) as u32;
    let (mut points, triangles) = concentric_rings(rings);
    let inner = points.len() - 6 * rings as usize;
    let domain = surface.domain();
    let centre = Vec2::new(domain.u.at(0.5), domain.v.at(0.5));
    for arc in domain.boundary_arcs() {
        let rim = RimScale::new(surface, arc);
        for polar in &mut points {
            *polar = centre + (rim.at(polar.y) - centre) * polar.x;
        }
    }
    move_inner(&mut points, inner, &triangles, Jitter::new(options));
    ParameterMesh {
        parameters: points.iter().map(|p| [p.x, p.y]).collect(),
        triangles,
    }
}

/// Vertices as (fraction of the radius, fraction of the turn), ring by ring from the centre, and
/// the triangles between them.
fn concentric_rings(rings: u32) -> (Vec<Vec2>, Vec<[u32; 3]>) {
    let mut points = vec![Vec2::zeros()];
    let mut triangles = Vec::new();
    let mut inside: LatticeRow = vec![(0.5, 0)];
    for k in 1..=rings {
        let first = points.len() as u32;
        let turns = (0..=6 * k).map(|j| f64::from(j) / f64::from(6 * k));
        let mut ring: LatticeRow = turns.zip(first..).collect();
        let radius = f64::from(k) / f64::from(rings);
        points.extend(
            ring[..6 * k as usize]
                .iter()
                .map(|v| Vec2::new(radius, v.0)),
        );
        ring[6 * k as usize].1 = first;
        stitch(&ring, &inside, &mut triangles);
        inside = ring;
    }
    (points, triangles)
}

/// Points of the boundary by the fraction of its length on the surface.
struct RimScale {
    arc: BoundaryArc,
    /// Length up to each of the equal steps of the arc.
    cumulative: Vec<f64>,
}

impl RimScale {
    fn new<S: ParametricSurface + ?Sized>(surface: &S, arc: BoundaryArc) -> Self {
        let mut cumulative = vec![0.0];
        for k in 0..LENGTH_STEPS {
            let t = (k as f64 + 0.5) / LENGTH_STEPS as f64;
            let ([u, v], [du, dv]) = (arc.at(t), arc.derivative(t));
            let [xu, xv] = surface.first_derivatives(u, v);
            cumulative.push(cumulative[k] + (xu * du + xv * dv).norm());
        }
        Self { arc, cumulative }
    }

    fn at(&self, fraction: f64) -> Vec2 {
        let wanted = fraction * self.cumulative[LENGTH_STEPS];
        let above = self.cumulative.partition_point(|&length| length <= wanted);
        let k = above.clamp(1, LENGTH_STEPS) - 1;
        let (low, high) = (self.cumulative[k], self.cumulative[k + 1]);
        let part = (wanted - low) / (high - low);
        Vec2::from(self.arc.at((k as f64 + part) / LENGTH_STEPS as f64))
    }
}

/// Jitters the first `inner` vertices, those inside the rim.
fn move_inner(points: &mut [Vec2], inner: usize, triangles: &[[u32; 3]], mut jitter: Jitter) {
    if jitter.is_none() {
        return;
    }
    let edges = safe_edges(points, triangles, |a, b| (a - b).norm());
    for (point, edge) in points[..inner].iter_mut().zip(edges) {
        *point += jitter.step(edge);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_make_a_disc_of_valence_six() {
        let (points, triangles) = concentric_rings(4);
        assert_eq!((points.len(), triangles.len()), (1 + 3 * 4 * 5, 6 * 16));
        let mut valence = vec![0; points.len()];
        for &i in triangles.iter().flatten() {
            valence[i as usize] += 1;
        }
        // On the outermost ring a vertex touches three triangles, two at the six corners.
        assert!(valence[..37].iter().all(|&n| n == 6));
        let rim = &valence[37..];
        assert!(
            rim.iter().filter(|&&n| n == 2).count() == 6 && rim.iter().all(|&n| n == 2 || n == 3)
        );
    }

    #[test]
    fn rim_is_divided_into_equal_lengths() {
        let shape = crate::shapes::Shape::from_name("roof", &[]).unwrap();
        let rim = RimScale::new(&shape, shape.domain().boundary_arcs()[0]);
        let point = |i: usize| {
            let p = rim.at(i as f64 / 600.0);
            shape.point(p.x, p.y)
        };
        let steps: Vec<f64> = (0..600).map(|i| (point(i + 1) - point(i)).norm()).collect();
        let mean = steps.iter().sum::<f64>() / 600.0;
        assert!(steps.iter().all(|s| (s / mean - 1.0).abs() < 2e-3));
    }
}
