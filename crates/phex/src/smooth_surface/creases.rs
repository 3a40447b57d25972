//! Creases of a triangle mesh: edges at which triangles meet at a sharp angle.
//!
//! Where two pipes meet the angle changes along the line, and passes the one from which on it is
//! sharp. A line that ends there would leave normals that know of both pipes, which bend the long
//! triangles of each: it goes on as long as an edge leads straight on and turns by more than
//! facets of a curved surface do. (Two thresholds for one line are J. Canny's hysteresis, 1986.)

use phex_mesh::{EdgeId, PerEdge, PerVertex, TriangleSurface, VertexId};

/// Cosine of the angle between triangles from which on their common edge is a crease.
const SHARP: f64 = 0.75;
/// That from which on an edge leads on a line that ends: 32 degrees, more than facets of a round
/// with twelve of them turn.
const FADING: f64 = 0.85;
/// Cosine of the largest angle between edges of which one leads the other on.
const STRAIGHT: f64 = 0.7;

/// Which edges are creases; those of the boundary are none.
pub(super) fn creases(surface: &TriangleSurface) -> PerEdge<bool> {
    let topology = surface.topology();
    let area: Vec<_> = topology.faces().map(|f| surface.area_vector(f)).collect();
    let cosine = |e: EdgeId| {
        let beside = topology.faces_beside(e)?;
        let [m, n] = beside.map(|f| area[f.index()]);
        Some(m.dot(&n) / (m.norm() * n.norm()))
    };
    let turns_by = |e, least| cosine(e).is_some_and(|c| c < least);
    let mut found = PerEdge::from_fn(topology.n_edges(), |e| turns_by(e, SHARP));
    let mut lines = PerVertex::filled(topology.n_vertices(), 0_u32);
    for (e, _) in found.enumerate().filter(|(_, is_crease)| **is_crease) {
        topology
            .edge_vertices(e)
            .iter()
            .for_each(|v| lines[*v] += 1);
    }
    let is_end = |lines: &PerVertex<u32>, v| lines[v] == 1 && !topology.is_boundary_vertex(v);
    let mut ends: Vec<VertexId> = topology.vertices().filter(|v| is_end(&lines, *v)).collect();
    while let Some(v) = ends.pop() {
        let spokes = topology.spokes(v);
        let last = spokes.iter().find(|(e, _)| found[*e]);
        let Some((_, from)) = last.filter(|_| is_end(&lines, v)) else {
            continue;
        };
        let way = |a: VertexId, b: VertexId| surface.positions()[b] - surface.positions()[a];
        let along = way(*from, v);
        let is_straight = |w| {
            let next = way(v, w);
            along.dot(&next) > STRAIGHT * along.norm() * next.norm()
        };
        let leads_on = |(e, w): &&(EdgeId, VertexId)| turns_by(*e, FADING) && is_straight(*w);
        let sharpness = |(e, _): &&(EdgeId, VertexId)| cosine(*e).unwrap_or(1.0);
        let next = spokes.iter().filter(leads_on);
        if let Some((e, w)) = next.min_by(|a, b| sharpness(a).total_cmp(&sharpness(b))) {
            found[*e] = true;
            (lines[v], lines[*w]) = (lines[v] + 1, lines[*w] + 1);
            ends.push(*w);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    /// A ridge along x whose two sides turn by these angles, degrees, from one end to the other.
    fn ridge(degrees: &[f64]) -> TriangleSurface {
        let row = |(i, d): (usize, &f64)| {
            let (sin, cos) = (0.5 * d).to_radians().sin_cos();
            [-1.0, 0.0, 1.0].map(|y: f64| Vec3::new(i as f64, y * cos, -y.abs() * sin))
        };
        let places: Vec<Vec3> = degrees.iter().enumerate().flat_map(row).collect();
        let cells = (0..degrees.len() as u32 - 1).flat_map(|i| [3 * i, 3 * i + 1]);
        let triangles = cells.flat_map(|a| [[a, a + 3, a + 4], [a, a + 4, a + 1]]);
        TriangleSurface::new(places, &triangles.collect::<Vec<_>>()).unwrap()
    }

    fn found(degrees: &[f64]) -> usize {
        let surface = ridge(degrees);
        creases(&surface).iter().filter(|c| **c).count()
    }

    #[test]
    fn a_line_goes_on_where_its_angle_fades() {
        assert_eq!(found(&[80.0; 6]), 5);
        assert_eq!(found(&[38.0; 6]), 0);
        // The end that is sharp leads the others on, but not those that turn as facets do.
        assert_eq!(found(&[80.0, 80.0, 38.0, 38.0, 38.0, 38.0]), 5);
        assert_eq!(found(&[80.0, 80.0, 20.0, 20.0, 20.0, 20.0]), 2);
    }
}
