//! Superelliptic domains: an (elongated) hexagonal piece of the equilateral lattice, its rim laid evenly along the boundary curve
//! and its interior spread so that every vertex is the mean of its six neighbours.
//!
//! By Tutte's theorem no triangle folds over, since the region is convex; and as the discrete harmonic map of an equilateral
//! lattice it is nearly conformal, so triangles stay near-equilateral.

use super::jitter::{Jitter, safe_edges};
use super::rows::{Row, stitch};
use super::{ParameterMesh, TriangulationOptions};
use crate::Vec2;
use crate::shapes::domain::{BoundaryArc, Domain};
use crate::shapes::parametric::ParametricSurface;
use std::f64::consts::PI;

/// Steps for measuring the length of the boundary curve.
const LENGTH_STEPS: usize = 4096;

pub(super) fn mesh<S: ParametricSurface + ?Sized>(
    surface: &S,
    options: &TriangulationOptions,
) -> ParameterMesh {
    let domain = surface.domain();
    // Rows run along the longer axis of the region.
    let upright = domain.v.length() > domain.u.length();
    let aspect =
        domain.v.length().max(domain.u.length()) / domain.v.length().min(domain.u.length());
    let hexagon = Hexagon::new(aspect, options.triangles);
    let (mut points, rows) = hexagon.vertices();
    let triangles = hexagon.triangles(&rows);
    let rim = hexagon.rim(&rows);
    place_rim(surface, &domain, upright, &rim, &mut points);
    let on_rim = marked(points.len(), &rim);
    spread(
        &mut points,
        &neighbours(on_rim.len(), &triangles),
        &on_rim,
        hexagon.across(),
    );
    move_interior(&mut points, &triangles, &on_rim, Jitter::new(options));
    ParameterMesh {
        parameters: points.iter().map(|p| [p.x, p.y]).collect(),
        triangles,
    }
}

/// Rows `-half..=half` of the lattice; the middle one has `core + 2 half` edges, each next one has one less.
struct Hexagon {
    half: usize,
    core: usize,
}

impl Hexagon {
    /// About as many times longer than high as `aspect`, and about as many triangles as asked for.
    fn new(aspect: f64, triangles: usize) -> Self {
        // Width (core + 2 half) over height sqrt(3) half, and 6 half^2 + 4 half core triangles.
        let core_rel = (3f64.sqrt() * aspect - 2.0).max(0.0);
        let half = (triangles as f64 / (6.0 + 4.0 * core_rel))
            .sqrt()
            .round()
            .max(2.0);
        Self {
            half: half as usize,
            core: (core_rel * half).round() as usize,
        }
    }

    /// Edges of the longest row.
    fn across(&self) -> usize {
        self.core + 2 * self.half
    }

    fn vertices(&self) -> (Vec<Vec2>, Vec<Row>) {
        let mut points = Vec::new();
        let mut rows = Vec::new();
        for r in 0..=2 * self.half {
            let edges = self.across() - self.half.abs_diff(r);
            let left = -0.5 * edges as f64;
            let first = points.len() as u32;
            let row: Row = (0..=edges).map(|i| left + i as f64).zip(first..).collect();
            points.extend(row.iter().map(|&(x, _)| Vec2::new(x, r as f64)));
            rows.push(row);
        }
        (points, rows)
    }

    fn triangles(&self, rows: &[Row]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for pair in rows.windows(2) {
            stitch(&pair[0], &pair[1], &mut triangles);
        }
        triangles
    }

    /// The rim counter-clockwise from the right end of the middle row.
    fn rim(&self, rows: &[Row]) -> Vec<u32> {
        let (below, above) = rows.split_at(self.half);
        let inner = &above[1..above.len() - 1];
        let (bottom, top) = (&rows[0], &rows[rows.len() - 1]);
        let right_end = |row: &Row| row[row.len() - 1].1;
        let mut rim = vec![right_end(&above[0])];
        rim.extend(inner.iter().map(right_end));
        rim.extend(top.iter().rev().map(|v| v.1));
        rim.extend(inner.iter().rev().map(|row| row[0].1));
        rim.push(above[0][0].1);
        rim.extend(below[1..].iter().rev().map(|row| row[0].1));
        rim.extend(bottom.iter().map(|v| v.1));
        rim.extend(below[1..].iter().map(right_end));
        rim
    }
}

/// Puts the rim on the boundary at equal lengths on the surface, and the other vertices in the middle.
fn place_rim<S: ParametricSurface + ?Sized>(
    surface: &S,
    domain: &Domain,
    upright: bool,
    rim: &[u32],
    points: &mut [Vec2],
) {
    points.fill(Vec2::new(domain.u.at(0.5), domain.v.at(0.5)));
    // The first rim vertex is at the end of the longer axis.
    let start = if upright { 0.25 } else { 0.0 };
    for arc in domain.boundary_arcs() {
        for (&vertex, t) in rim
            .iter()
            .zip(equal_lengths(surface, &arc, start, rim.len()))
        {
            points[vertex as usize] = Vec2::from(arc.at(t));
        }
    }
}

/// Values of the arc's `t`, from `start` on, that divide its length on the surface into `count` equal parts.
fn equal_lengths<S: ParametricSurface + ?Sized>(
    surface: &S,
    arc: &BoundaryArc,
    start: f64,
    count: usize,
) -> Vec<f64> {
    let step = 1.0 / LENGTH_STEPS as f64;
    let mut cumulative = vec![0.0];
    for k in 0..LENGTH_STEPS {
        let t = start + (k as f64 + 0.5) * step;
        let ([u, v], [du, dv]) = (arc.at(t), arc.derivative(t));
        let jet = surface.jet(u, v);
        cumulative.push(cumulative[k] + (jet.du * du + jet.dv * dv).norm() * step);
    }
    let total = cumulative[LENGTH_STEPS];
    let mut k = 0;
    (0..count)
        .map(|i| {
            let wanted = total * i as f64 / count as f64;
            while cumulative[k + 1] < wanted {
                k += 1;
            }
            let part = (wanted - cumulative[k]) / (cumulative[k + 1] - cumulative[k]);
            start + (k as f64 + part) * step
        })
        .collect()
}

fn marked(count: usize, vertices: &[u32]) -> Vec<bool> {
    let mut marks = vec![false; count];
    for &v in vertices {
        marks[v as usize] = true;
    }
    marks
}

/// Neighbours of every vertex across the triangles; inside, each neighbour appears once.
fn neighbours(count: usize, triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::with_capacity(6); count];
    for &[a, b, c] in triangles {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(c);
        neighbours[c as usize].push(a);
    }
    neighbours
}

/// Successive over-relaxation of "every inner vertex is the mean of its neighbours", to a millionth of an edge or so.
fn spread(points: &mut [Vec2], neighbours: &[Vec<u32>], fixed: &[bool], across: usize) {
    let over = 2.0 / (1.0 + (PI / across as f64).sin());
    for _ in 0..6 * across + 40 {
        for v in (0..points.len()).filter(|&v| !fixed[v]) {
            let sum: Vec2 = neighbours[v].iter().map(|&n| points[n as usize]).sum();
            let mean = sum / neighbours[v].len() as f64;
            points[v] = points[v] * (1.0 - over) + mean * over;
        }
    }
}

fn move_interior(points: &mut [Vec2], triangles: &[[u32; 3]], fixed: &[bool], mut jitter: Jitter) {
    if jitter.is_none() {
        return;
    }
    let edges = safe_edges(points, triangles, |a, b| (a - b).norm());
    for (v, point) in points.iter_mut().enumerate().filter(|(v, _)| !fixed[*v]) {
        *point += jitter.step(edges[v]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rim_runs_round_the_hexagon_once() {
        for (half, core) in [(2, 0), (3, 2), (5, 1)] {
            let hexagon = Hexagon { half, core };
            let (points, rows) = hexagon.vertices();
            let rim = hexagon.rim(&rows);
            assert_eq!(rim.len(), 6 * half + 2 * core);
            let mut doubled_area = 0.0;
            for (i, &v) in rim.iter().enumerate() {
                let [a, b] = [v, rim[(i + 1) % rim.len()]].map(|v| points[v as usize]);
                let step = b - a;
                assert!(
                    (step.x.abs() == 1.0 && step.y == 0.0)
                        || (step.x.abs() == 0.5 && step.y.abs() == 1.0)
                );
                doubled_area += a.perp(&b);
            }
            let triangles = hexagon.triangles(&rows).len();
            assert_eq!(triangles, 6 * half * half + 4 * half * core);
            // Each lattice triangle has base 1 and, with rows one apart, height 1.
            assert_eq!(doubled_area, triangles as f64);
        }
    }

    #[test]
    fn spread_vertices_are_means_of_their_neighbours() {
        let shape = crate::shapes::Shape::from_name::<&str>("roof", &[]).unwrap();
        let mesh = mesh(&shape, &TriangulationOptions::default());
        let around = neighbours(mesh.parameters.len(), &mesh.triangles);
        let point = |v: u32| Vec2::from(mesh.parameters[v as usize]);
        let inner = around.iter().enumerate().filter(|(_, n)| n.len() == 6);
        let worst = inner
            .map(|(v, n)| {
                (n.iter().map(|&n| point(n)).sum::<Vec2>() / 6.0 - point(v as u32)).norm()
            })
            .fold(0.0, f64::max);
        assert!(worst < 1e-6, "{worst}");
    }
}
