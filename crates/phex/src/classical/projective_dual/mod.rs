//! Projective dual: a regular triangulation of the dual surface, mapped back.
//!
//! The dual `S'` of a surface `S` consists of the poles of its tangent planes, for the unit sphere
//! about a centre `c` `p' = n / h` with `h = n . (p - c)`. A regular triangulation of `S'` is the
//! dual of a P-Hex mesh whose panels touch `S` where the triangulation has its vertices. It is made
//! as the lattice of `S` that is regular in the metric that `S'` induces:
//!
//! `G = J^T J`, `J = (h II - n (II p)^T) / h^2` (affine, where no tangent plane passes through
//! `c`), or `J` of `(n, h) / |(n, h)|` (projective, bounded everywhere)
//!
//! with `II` as a tangential tensor; for any other quadric `Q` the same of the poles `Q (n, -n .
//! p)`. Working on `S` with the metric of `S'` keeps the way back one to one where `S'` covers
//! itself.
//!
//! Source: W. Wang and Y. Liu, "A note on planar hexagonal meshes" (2010), section 2, with its
//! three problems: distortion, points of `S'` that belong to several points of `S`, and
//! triangulations whose dual panels cross themselves. [`inspect`] finds the first two: *singular
//! points*, the images of parabolic curves, where `S'` has cusps (`det J ~ K`), and *duplicates*,
//! far points of `S` with one tangent plane. The third is what validation counts.
//!
//! Guaranteed: planar panels. Valid where the triangles of touching points are as `super::duality`
//! says: on elliptic and hyperbolic surfaces whose dual is not too anisotropic (ratio of the
//! curvatures of `S` in the metric of `S'` below 3). Refused where tangent planes pass through
//! every centre, and where `K` changes its sign, unless asked to go on.

use super::domain::{DomainError, LocatedVertex, SignedPlaces, no_flat_point, not_flat};
use super::duality::{OrientedPlane, Quadric, clear_centre, clearness};
use crate::curvature::Curvature;
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector4};
use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};
use serde::Serialize;
use std::collections::HashMap;

/// Name in messages.
pub(crate) const METHOD: &str = "projective-dual";
/// Least distance of the centre to the tangent planes, over the largest, with which the affine dual
/// is used.
pub(crate) const CLEAR: f64 = 0.02;
/// Poles nearer than this share of the dual's mean edge, of points farther apart than [`FAR`] mean
/// edges, are duplicates.
const SAME: f64 = 0.25;
/// See [`SAME`].
const FAR: f64 = 4.0;

/// The dual of a surface.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceDual {
    /// The quadric whose polarity it is.
    pub quadric: Quadric,
    /// Least distance of the centre `c` to a tangent plane over the largest; 0 or less where
    /// tangent planes pass on both sides of it.
    pub clearness: f64,
    /// The pole of the tangent plane at each vertex, homogeneous, about the centre: `(n, h)` for
    /// the unit sphere.
    pub pole: PerVertex<Vector4<f64>>,
}

/// What is wrong with a dual surface.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct DualDefects {
    /// Edges of the surface's triangles between vertices with Gauss curvature of opposite sign: the
    /// dual has a cusp there.
    pub singular_edges: usize,
    /// Pairs of far vertices with the same tangent plane, about.
    pub duplicate_pairs: usize,
    /// Edges across which the dual runs through infinity.
    pub edges_through_infinity: usize,
}

impl SurfaceDual {
    /// The dual in the unit sphere about a centre that is chosen away from the tangent planes.
    pub fn of(surface: &TriangleSurface, normals: &PerVertex<Vec3>) -> Self {
        let (centre, _) = clear_centre(&tangents(surface, normals), surface.positions().as_slice());
        let sphere = Quadric::sphere(centre, 1.0).expect("a surface's coordinates are finite");
        Self::about(surface, normals, sphere)
    }

    /// The dual in any quadric.
    pub fn about(surface: &TriangleSurface, normals: &PerVertex<Vec3>, quadric: Quadric) -> Self {
        let planes = tangents(surface, normals);
        let map = centred(&quadric);
        let pole = planes.iter().map(|p| map * p.normal.push(-p.offset));
        let pole: Vec<Vector4<f64>> = pole.collect();
        Self {
            clearness: clearness(pole.iter().map(|x| x.w)),
            pole: PerVertex::from_vec(pole),
            quadric,
        }
    }

    /// Whether all of the dual is finite and on one side.
    pub(crate) fn is_affine(&self) -> bool {
        self.clearness >= CLEAR
    }

    /// The vertex whose tangent plane passes nearest to the centre.
    fn nearest(&self, surface: &TriangleSurface) -> LocatedVertex {
        let distance = |v: &VertexId| self.pole[*v].w.abs();
        let all = surface.topology().vertices();
        let vertex = all.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        LocatedVertex::of(surface, vertex.unwrap_or(VertexId::new(0)))
    }

    /// The metric of the dual, pulled back to the surface; a floor keeps it positive where the dual
    /// has cusps.
    pub fn metric(
        &self,
        surface: &TriangleSurface,
        curvature: &Curvature,
    ) -> PerVertex<Matrix3<f64>> {
        let map = centred(&self.quadric);
        let raw = PerVertex::from_fn(self.pole.len(), |v| {
            let (p, s) = (surface.positions()[v], curvature.tensor[v]);
            // The plane (n, -n . p) changes by (II e, -p . II e) along e.
            let mut change = SMatrix::<f64, 4, 3>::zeros();
            change.fixed_view_mut::<3, 3>(0, 0).copy_from(&s);
            change.set_row(3, &-(s * p).transpose());
            let j = map * change;
            if self.is_affine() {
                affine_metric(&self.pole[v], &j)
            } else {
                projective_metric(&self.pole[v], &j)
            }
        });
        with_floor(raw, &curvature.normal)
    }
}

/// The tangent planes of a surface.
fn tangents(surface: &TriangleSurface, normals: &PerVertex<Vec3>) -> Vec<OrientedPlane> {
    let pairs = surface.positions().iter().zip(normals);
    pairs.map(|(p, n)| OrientedPlane::through(*p, *n)).collect()
}

/// The matrix of a quadric with its centre, if it has one, moved to the origin of the poles.
fn centred(quadric: &Quadric) -> Matrix4<f64> {
    let mut shift = Matrix4::identity();
    let centre = quadric.centre().unwrap_or_default();
    shift.fixed_view_mut::<3, 1>(0, 3).copy_from(&-centre);
    shift * quadric.matrix()
}

/// `J^T J` of `x / w`, by the pole `(x, w)` and its change.
fn affine_metric(pole: &Vector4<f64>, change: &SMatrix<f64, 4, 3>) -> Matrix3<f64> {
    let x = pole.xyz() / pole.w;
    let j = (change.fixed_rows::<3>(0) - x * change.row(3)) / pole.w;
    j.transpose() * j
}

/// `J^T J` of the pole as a unit vector.
fn projective_metric(pole: &Vector4<f64>, change: &SMatrix<f64, 4, 3>) -> Matrix3<f64> {
    let length = pole.norm();
    let x = pole / length;
    let tangential = (change - x * (x.transpose() * change)) / length;
    tangential.transpose() * tangential
}

/// Share of the mean trace that is added in every tangent direction.
const METRIC_FLOOR: f64 = 0.02;

/// The tensors with a small isotropic part, so that no direction has length 0.
pub(super) fn with_floor(
    raw: PerVertex<Matrix3<f64>>,
    normal: &PerVertex<Vec3>,
) -> PerVertex<Matrix3<f64>> {
    let mean = raw.iter().map(|m| m.trace()).sum::<f64>() / raw.len() as f64;
    let floor = METRIC_FLOOR * mean.max(f64::MIN_POSITIVE);
    PerVertex::from_fn(raw.len(), |v| {
        let n = normal[v];
        let tangential = Matrix3::identity() - n * n.transpose();
        raw[v] + tangential * floor
    })
}

/// Whether a method that works in the dual, `method` in messages, applies; `chosen` says that the
/// program has chosen the centre.
///
/// # Errors
/// Where tangent planes pass through every centre, `K` changes its sign or is zero, or `K < 0` but
/// for a flat point.
pub(crate) fn check(
    surface: &TriangleSurface,
    curvature: &Curvature,
    dual: &SurfaceDual,
    chosen: bool,
    method: &'static str,
) -> Result<(), DomainError> {
    let places = SignedPlaces::find(surface, curvature);
    let sign = places.one_sign(method, "the dual surface has a cusp")?;
    let consequence = "the dual surface winds round a branch point there";
    no_flat_point(sign, surface, curvature, method, consequence)?;
    let consequence = "tangent planes beside one another meet far away";
    not_flat(surface, curvature, method, consequence)?;
    if dual.is_affine() {
        return Ok(());
    }
    let place = dual.nearest(surface);
    Err(match chosen {
        true => DomainError::NoCentre { method, place },
        false => DomainError::ThroughCentre { method, place },
    })
}

/// Counts singular points and duplicates of the dual.
pub(crate) fn inspect(
    surface: &TriangleSurface,
    curvature: &Curvature,
    dual: &SurfaceDual,
) -> DualDefects {
    let topology = surface.topology();
    let gauss = curvature.principal().map(|p| p.small * p.large);
    let count = |test: &dyn Fn(VertexId, VertexId) -> bool| {
        let ends = topology.edges().map(|e| topology.edge_vertices(e));
        ends.filter(|[a, b]| test(*a, *b)).count()
    };
    DualDefects {
        singular_edges: count(&|a, b| gauss[a] * gauss[b] < 0.0),
        edges_through_infinity: count(&|a, b| dual.pole[a].w * dual.pole[b].w < 0.0),
        duplicate_pairs: duplicates(surface, dual).len(),
    }
}

/// Pairs of vertices that are far apart on the surface and have one tangent plane, as points of
/// projective space, about.
pub(crate) fn duplicates(surface: &TriangleSurface, dual: &SurfaceDual) -> Vec<[VertexId; 2]> {
    let topology = surface.topology();
    let pole = |v: VertexId| {
        let x = dual.pole[v].normalize();
        // A plane and its reverse are one point.
        if x.w < 0.0 { -x } else { x }
    };
    let edges = || topology.edges().map(|e| topology.edge_vertices(e));
    let mean = |length: &dyn Fn(VertexId, VertexId) -> f64| {
        edges().map(|[a, b]| length(a, b)).sum::<f64>() / topology.n_edges() as f64
    };
    let same = SAME * mean(&|a, b| (pole(a) - pole(b)).norm());
    if same == 0.0 {
        // All planes are one: the surface is flat, and is refused for that.
        return Vec::new();
    }
    let far = FAR * mean(&|a, b| (surface.positions()[a] - surface.positions()[b]).norm());
    let cell = |v: VertexId| pole(v).map(|x| (x / same).floor() as i64);
    let mut cells: HashMap<[i64; 4], Vec<VertexId>> = HashMap::new();
    let mut pairs = Vec::new();
    for v in topology.vertices() {
        let members = cells.entry(cell(v).into()).or_default();
        let twin = members.iter().find(|&&w| {
            (surface.positions()[v] - surface.positions()[w]).norm() > far
                && (pole(v) - pole(w)).norm() < same
        });
        pairs.extend(twin.map(|&w| [w, v]));
        members.push(v);
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::{CurvatureOptions, curvature};
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn dual_of(name: &str) -> (TriangleSurface, Curvature, SurfaceDual) {
        let options = TriangulationOptions {
            triangles: 3000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &options).unwrap();
        let curvature = curvature(
            &surface,
            0.05 * surface.diagonal(),
            &CurvatureOptions::default(),
        );
        let dual = SurfaceDual::of(&surface, &curvature.normal);
        (surface, curvature, dual)
    }

    #[test]
    fn metrics_are_those_of_the_poles() {
        let (surface, curvature, _) = dual_of("ellipsoid");
        let sphere = Quadric::sphere(Vec3::new(0.2, 0.1, -0.05), 1.0).unwrap();
        // An ellipsoid with its axes askew, off the origin.
        let upper = [1.0, 0.2, -0.1, 0.1, 2.0, 0.3, -0.05, 1.5, 0.02, -1.2];
        for quadric in [sphere, Quadric::from_upper(upper).unwrap()] {
            metric_is_that_of_the_poles(&surface, &curvature, quadric);
        }
    }

    fn metric_is_that_of_the_poles(
        surface: &TriangleSurface,
        curvature: &Curvature,
        quadric: Quadric,
    ) {
        let dual = SurfaceDual::about(surface, &curvature.normal, quadric);
        assert!(dual.is_affine());
        let positions = surface.positions();
        let metric = dual.metric(surface, curvature);
        let (mut error, mut count) = (0.0, 0.0);
        for e in surface.topology().edges() {
            let [a, b] = surface.topology().edge_vertices(e);
            let plane = |v: VertexId| OrientedPlane::through(positions[v], curvature.normal[v]);
            let pole = |v: VertexId| quadric.pole(&plane(v)).unwrap();
            let d = positions[b] - positions[a];
            let induced = (0.5 * d.dot(&((metric[a] + metric[b]) * d))).sqrt();
            error += (induced / (pole(a) - pole(b)).norm() - 1.0).abs();
            count += 1.0;
        }
        assert!(error / count < 0.1, "mean relative error {}", error / count);
    }

    #[test]
    fn domains() {
        let verdict = |name| {
            let (surface, curvature, dual) = dual_of(name);
            check(&surface, &curvature, &dual, true, METHOD)
        };
        assert_eq!(verdict("ellipsoid"), Ok(()));
        assert_eq!(verdict("hyperbolic-paraboloid"), Ok(()));
        let mixed = verdict("wave").unwrap_err().to_string();
        assert!(
            mixed.contains("positive at vertex") && mixed.contains("cusp"),
            "{mixed}"
        );
        let catenoid = verdict("catenoid").unwrap_err();
        assert!(
            matches!(catenoid, DomainError::NoCentre { .. }),
            "{catenoid}"
        );
    }

    #[test]
    fn torus_has_cusps_and_two_planes_that_touch_it_along_circles() {
        let (surface, curvature, dual) = dual_of("torus");
        let defects = inspect(&surface, &curvature, &dual);
        assert!(defects.singular_edges > 50, "{defects:?}");
        assert!(defects.duplicate_pairs > 20, "{defects:?}");
        assert!(defects.edges_through_infinity > 20, "{defects:?}");
        let (surface, curvature, dual) = dual_of("sphere");
        let none = DualDefects::default();
        assert_eq!(inspect(&surface, &curvature, &dual), none);
    }
}
