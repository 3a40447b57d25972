//! Where the rules apply: on meshes whose Gauss curvature has one sign.
//!
//! Three planes in general position meet at every vertex inside, so its curvature is the signed
//! area of the spherical triangle of their normals. Where that changes its sign the poles fold
//! over: planes that rules put between them meet badly or far off, and levels lose planarity.

use crate::classical::domain::{CurvatureSign, DomainError, LocatedVertex};
use phex_mesh::{FacePlane, HexMesh, PerFace, Vec3, VertexId};

/// Name in messages.
const METHOD: &str = "dual subdivision";
/// Share of the absolute curvature that may have the other sign: single vertices where a panel is
/// tilted.
const OTHER_SIGN: f64 = 0.02;
/// Total curvature below which a mesh counts as flat.
const FLAT: f64 = 1e-9;

/// The sign of a mesh's Gauss curvature.
///
/// # Errors
/// Where both signs occur: the vertices where it is largest and least.
pub fn one_sign(mesh: &HexMesh) -> Result<CurvatureSign, DomainError> {
    let topology = mesh.topology();
    let normals = PerFace::from_fn(topology.n_faces(), |f| FacePlane::of(mesh, f).normal);
    let inside = topology.inner_vertices();
    let curved: Vec<(VertexId, f64)> = inside
        .map(|v| {
            let around = topology.faces_at(v).map(|f| normals[f]);
            (v, fan_area(&around.collect::<Vec<_>>()))
        })
        .collect();
    let total = |sign: f64| -> f64 { curved.iter().map(|c| (sign * c.1).max(0.0)).sum() };
    let (positive, negative) = (total(1.0), total(-1.0));
    if positive + negative > FLAT && positive.min(negative) > OTHER_SIGN * (positive + negative) {
        let place = |sign: f64| {
            let most = curved
                .iter()
                .max_by(|a, b| (sign * a.1).total_cmp(&(sign * b.1)));
            let vertex = most.map_or(VertexId::new(0), |c| c.0);
            let position = mesh.positions[vertex];
            LocatedVertex { vertex, position }
        };
        return Err(DomainError::MixedCurvature {
            method: METHOD,
            positive: place(1.0),
            negative: place(-1.0),
            consequence: "the dual mesh folds over",
        });
    }
    Ok(if negative > positive {
        CurvatureSign::Hyperbolic
    } else {
        CurvatureSign::Elliptic
    })
}

/// Signed area of a spherical polygon, counter-clockwise seen from outside, by the formula of A.
/// van Oosterom and J. Strackee (1983) for the triangles of a fan.
fn fan_area(normals: &[Vec3]) -> f64 {
    let [a, rest @ ..] = normals else { return 0.0 };
    let triangle = |b: &Vec3, c: &Vec3| {
        let height = a.dot(&b.cross(c));
        2.0 * height.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    };
    rest.windows(2)
        .map(|pair| triangle(&pair[0], &pair[1]))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classical::power_diagram::goldberg;

    #[test]
    fn curvature_of_a_polyhedron_adds_up_to_that_of_the_sphere() {
        let mesh = goldberg(2, 1).unwrap().mesh;
        let topology = mesh.topology();
        let normal = |f| FacePlane::of(&mesh, f).normal;
        let at = |v| {
            let around = topology.faces_at(v).map(&normal);
            fan_area(&around.collect::<Vec<_>>())
        };
        let total: f64 = topology.vertices().map(at).sum();
        assert!(
            (total - 4.0 * std::f64::consts::PI).abs() < 1e-12,
            "{total}"
        );
        assert_eq!(one_sign(&mesh).unwrap(), CurvatureSign::Elliptic);
    }

    /// Three planes that meet in the origin, over three directions; the heights tell cup from
    /// saddle.
    fn corner(heights: [f64; 3]) -> HexMesh {
        let spoke = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / 3.0).sin_cos();
            Vec3::new(cos, sin, heights[k])
        };
        let far = |k: usize| spoke(k) + spoke((k + 1) % 3);
        let mut positions = vec![Vec3::zeros()];
        positions.extend((0..3).flat_map(|k| [spoke(k), far(k)]));
        let faces = [[0u32, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]];
        HexMesh::new(positions, &faces).unwrap()
    }

    #[test]
    fn a_corner_of_three_planes_is_positive_from_both_sides() {
        for height in [-0.4, 0.4] {
            assert_eq!(
                one_sign(&corner([height; 3])).unwrap(),
                CurvatureSign::Elliptic
            );
        }
    }
}
