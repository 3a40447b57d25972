//! Power diagram: hexagonal sites in the plane, lifted to a sphere and mapped to an ellipsoid.
//!
//! The power diagram of sites `s_i` with weights `w_i` is the projection of the polyhedron whose
//! faces lie in the planes `z = 2 s_i . x - |s_i|^2 + w_i`, tangent to the paraboloid `z = |x|^2`
//! where the weight is 0. The projective map `(x, y, z) -> (2 x, 2 y, z - 1) / (z + 1)` takes the
//! paraboloid to the unit sphere, vertical lines to lines through the north pole, and so the
//! projection to the inverse stereographic one. The plane of a site becomes
//!
//! `2 s . (x, y) + (c - 1) z = c + 1`,  `c = |s|^2 - w`
//!
//! Cells without bounds meet the *cap*, the plane `z = height` of a site at infinity. An affine map
//! takes the sphere to an ellipsoid and keeps planes.
//!
//! | symbol | here |
//! |---|---|
//! | `s_i`, `w_i` | [`PowerSite`] |
//! | regular triangulation, dual to the diagram | hull of the planes' poles, by exact predicates |
//! | `(m, n)` | [`goldberg()`]: `10 (m^2 + m n + n^2) + 2` panels, 12 of them pentagons |
//!
//! Source: S. Diaz, J. Gonzalez et al., as reviewed by W. Wang and Y. Liu, "A note on planar
//! hexagonal meshes" (2010), section 2.
//!
//! Guaranteed: convex planar panels, three at every vertex; sites whose cells are empty are
//! reported. Works for spheres and ellipsoids only ([`fit_ellipsoid`] says whether a surface is
//! one): other quadrics have no such map.

mod ellipsoid;
mod goldberg;

pub(crate) use ellipsoid::fit_ellipsoid;
pub use goldberg::goldberg;
pub(crate) use goldberg::nearest_goldberg;

use super::duality::{DualityError, HullError, OrientedPlane, convex_hull, meet};
use phex_mesh::{HexMesh, TopologyError, Vec2, Vec3, VertexId};
use std::collections::HashMap;
use thiserror::Error;

/// A site of a power diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerSite {
    /// Its place in the plane.
    pub position: Vec2,
    /// Its weight: the squared radius of its circle (or minus it); a larger weight makes a larger
    /// cell. 0 is the Voronoi diagram.
    pub weight: f64,
}

/// Why there are no panels.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PowerError {
    /// Too few sites, or all on one line or circle.
    #[error("the sites, with the cap, have no power diagram with bounded cells")]
    Hull(#[from] HullError),
    /// A weight so large that the plane of the site does not face the sphere.
    #[error(
        "site {site} has weight {weight}, it must be below {limit:.6} (1 + its squared distance from the origin)"
    )]
    Weight {
        /// The site.
        site: usize,
        /// Its weight.
        weight: f64,
        /// What it must be below.
        limit: f64,
    },
    /// The sites leave a side of the sphere free.
    #[error("the sites do not surround the origin: their panels and the cap enclose no body")]
    Open,
    /// The class of a Goldberg polyhedron has no panels.
    #[error("the Goldberg polyhedron ({m}, {n}) does not exist: m + n must be from 1 to {largest}")]
    Class {
        /// `m`.
        m: u32,
        /// `n`.
        n: u32,
        /// The largest sum allowed.
        largest: u32,
    },
    /// The diagram is no manifold.
    #[error("the diagram is no mesh")]
    Topology(#[from] TopologyError),
    /// Planes that do not meet.
    #[error(transparent)]
    Duality(#[from] DualityError),
}

/// The polyhedron of a power diagram on the unit sphere.
#[derive(Clone, Debug)]
pub struct PowerDiagram {
    /// The panels: one for each site with a cell, in their order, and the cap.
    pub mesh: HexMesh,
    /// The site of each panel; the cap has none.
    pub site_of_panel: Vec<Option<usize>>,
    /// Sites without a cell: their circles are covered by those of others.
    pub hidden: Vec<usize>,
}

/// The power diagram of `sites`, lifted to the unit sphere and closed by the cap `z = cap` (1
/// touches the north pole).
///
/// # Errors
/// If a weight is too large, or the sites have no diagram with a bounded cell.
pub fn power_diagram(sites: &[PowerSite], cap: f64) -> Result<PowerDiagram, PowerError> {
    let planes: Result<Vec<OrientedPlane>, _> = sites.iter().enumerate().map(plane_of).collect();
    let mut planes = planes?;
    planes.push(OrientedPlane {
        normal: Vec3::z(),
        offset: cap,
    });
    let poles: Vec<Vec3> = planes.iter().map(|p| p.normal / p.offset).collect();
    let triangles = convex_hull(&poles)?;
    let open = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| poles[i as usize]);
        a.dot(&b.cross(&c)) <= 0.0
    };
    if triangles.iter().any(open) {
        return Err(PowerError::Open);
    }
    let mut used = vec![false; planes.len()];
    triangles
        .iter()
        .flatten()
        .for_each(|&i| used[i as usize] = true);
    let panels: Vec<usize> = (0..planes.len()).filter(|&i| used[i]).collect();
    let outlines: Vec<Vec<u32>> = outlines(&triangles, &panels);
    let positions: Result<Vec<Vec3>, _> = triangles
        .iter()
        .enumerate()
        .map(|(i, t)| meet_of(i, t.map(|p| planes[p as usize])))
        .collect();
    Ok(PowerDiagram {
        mesh: HexMesh::new(positions?, &outlines)?,
        site_of_panel: panels
            .iter()
            .map(|&p| (p < sites.len()).then_some(p))
            .collect(),
        hidden: (0..sites.len()).filter(|&i| !used[i]).collect(),
    })
}

fn plane_of((site, s): (usize, &PowerSite)) -> Result<OrientedPlane, PowerError> {
    let squared = s.position.norm_squared();
    let c = squared - s.weight;
    if !(c + 1.0 > 0.0 && c.is_finite()) {
        return Err(PowerError::Weight {
            site,
            weight: s.weight,
            limit: 1.0 + squared,
        });
    }
    let normal = Vec3::new(2.0 * s.position.x, 2.0 * s.position.y, c - 1.0);
    let length = normal.norm();
    Ok(OrientedPlane {
        normal: normal / length,
        offset: (c + 1.0) / length,
    })
}

fn meet_of(triangle: usize, planes: [OrientedPlane; 3]) -> Result<Vec3, DualityError> {
    let near: Vec3 = planes.iter().map(|p| p.normal * p.offset).sum::<Vec3>() / 3.0;
    let vertex = VertexId::new(triangle as u32);
    meet(&planes, near).ok_or(DualityError::NoMeet { vertex, near })
}

/// Triangles round each site, counter-clockwise.
fn outlines(triangles: &[[u32; 3]], panels: &[usize]) -> Vec<Vec<u32>> {
    // From a site and the second corner of one of its triangles to the triangle and its third
    // corner.
    let mut next: HashMap<(u32, u32), (u32, u32)> = HashMap::new();
    let mut first: HashMap<u32, u32> = HashMap::new();
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            next.insert((a, b), (i as u32, c));
            first.entry(a).or_insert(b);
        }
    }
    let outline = |&p: &usize| {
        let site = p as u32;
        let (start, mut at, mut list) = (first[&site], first[&site], Vec::new());
        while let Some(&(triangle, to)) = next.get(&(site, at)) {
            list.push(triangle);
            at = to;
            if at == start {
                break;
            }
        }
        list
    };
    panels.iter().map(outline).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::measure;
    use proptest::prelude::*;

    fn hexagonal(rings: i32, spacing: f64, weight: impl Fn(Vec2) -> f64) -> Vec<PowerSite> {
        let lattice = (-rings..=rings).flat_map(|i| (-rings..=rings).map(move |j| (i, j)));
        let inside = lattice.filter(|(i, j)| (i + j).abs() <= rings);
        inside
            .map(|(i, j)| (f64::from(i), f64::from(j)))
            .map(|(i, j)| Vec2::new(i + 0.5 * j, 0.75f64.sqrt() * j) * spacing)
            .map(|position| PowerSite {
                position,
                weight: weight(position),
            })
            .collect()
    }

    fn assert_convex(diagram: &PowerDiagram) {
        let measures = measure(&diagram.mesh);
        assert!(measures.planarity.max < 1e-12, "{}", measures.planarity.max);
        assert_eq!((measures.faces_not_simple, measures.faces_concave), (0, 0));
        assert_eq!((measures.degree3, measures.euler_characteristic), (1.0, 2));
    }

    #[test]
    fn panels_of_sites_without_weight_touch_the_sphere_under_their_images() {
        let sites = hexagonal(4, 0.25, |_| 0.0);
        // Outermost sites lie on lines: a cap that touches the pole would pass through the meets of
        // three of their planes.
        let diagram = power_diagram(&sites, 0.9).unwrap();
        assert_convex(&diagram);
        assert!(diagram.hidden.is_empty());
        for (f, site) in diagram.mesh.topology().faces().zip(&diagram.site_of_panel) {
            let plane = phex_mesh::FacePlane::of(&diagram.mesh, f);
            assert!(
                plane.normal.dot(&plane.centre) > 0.0,
                "panels face outwards"
            );
            let touch = plane.normal * plane.normal.dot(&plane.centre);
            if let Some(site) = site {
                assert!((touch.norm() - 1.0).abs() < 1e-12);
                // Stereographic projection from the north pole.
                let image = touch.xy() / (1.0 - touch.z);
                assert!((image - sites[*site].position).norm() < 1e-10);
            }
        }
    }

    #[test]
    fn projected_cells_are_those_of_the_power_distance() {
        let sites = hexagonal(3, 0.3, |p| {
            0.02 * (9.0 * p.x).sin() + 0.01 * (7.0 * p.y).cos()
        });
        let diagram = power_diagram(&sites, 0.9).unwrap();
        assert_convex(&diagram);
        let power = |s: &PowerSite, x: Vec2| (x - s.position).norm_squared() - s.weight;
        for v in diagram.mesh.topology().vertices() {
            let p = diagram.mesh.positions[v];
            if p.z > 0.89 {
                continue;
            }
            let x = p.xy() / (1.0 - p.z);
            let around = diagram.mesh.topology().faces_at(v);
            let own: Vec<f64> = around
                .filter_map(|f| diagram.site_of_panel[f.index()])
                .map(|i| power(&sites[i], x))
                .collect();
            let least = sites.iter().map(|s| power(s, x)).fold(f64::MAX, f64::min);
            assert!(
                own.iter().all(|d| (d - least).abs() < 1e-9),
                "{own:?} {least}"
            );
        }
    }

    #[test]
    fn covered_sites_are_reported_and_excessive_weights_refused() {
        let mut sites = hexagonal(3, 0.3, |_| 0.0);
        let covered = sites.len();
        sites.push(PowerSite {
            position: Vec2::new(0.05, 0.02),
            weight: -0.5,
        });
        assert_eq!(power_diagram(&sites, 1.0).unwrap().hidden, [covered]);
        sites[covered].weight = 2.0;
        assert!(
            matches!(power_diagram(&sites, 1.0), Err(PowerError::Weight { site, .. }) if site == covered)
        );
        assert!(matches!(
            power_diagram(&sites[..2], 1.0),
            Err(PowerError::Hull(_))
        ));
    }

    proptest! {
        #[test]
        fn any_sites_make_a_closed_convex_polyhedron(
            places in prop::collection::vec(prop::array::uniform2(-1.0..1.0f64), 8..40)
        ) {
            let sites: Vec<PowerSite> = places
                .into_iter()
                .map(|p| PowerSite { position: Vec2::from(p), weight: 0.0 })
                .collect();
            if let Ok(diagram) = power_diagram(&sites, 1.0) {
                let topology = diagram.mesh.topology();
                prop_assert_eq!(topology.euler_characteristic(), 2);
                prop_assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
            }
        }
    }
}
