//! Mirror planes in which parts of the boundary lie.

use crate::smooth_surface::IN_PLANE;
use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A plane in which parts of the boundary lie: the lattice is to be symmetric about it, so that the
/// surface with its image has one without a seam. Its rows run along the plane or at right angles
/// to it, and panels are cut in two by it or have an edge in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MirrorPlane {
    /// A point of the plane, model units.
    pub point: [f64; 3],
    /// Its unit normal, towards the surface.
    pub normal: [f64; 3],
}

/// How many images of a vertex and it itself lie in its place: 2 in a mirror plane, `2 pi / a`
/// where two of them meet at the angle `a`, and 1 elsewhere.
pub(crate) fn multiplicity(surface: &TriangleSurface, mirrors: &[MirrorPlane]) -> PerVertex<u32> {
    let near = IN_PLANE * surface.diagonal();
    let topology = surface.topology();
    PerVertex::from_fn(topology.n_vertices(), |v: VertexId| {
        let p = surface.positions()[v];
        let holds =
            |m: &&MirrorPlane| (p - Vec3::from(m.point)).dot(&Vec3::from(m.normal)).abs() < near;
        let on: Vec<&MirrorPlane> = match topology.is_boundary_vertex(v) {
            true => mirrors.iter().filter(holds).collect(),
            false => Vec::new(),
        };
        match on[..] {
            [] => 1,
            [_] => 2,
            [a, b, ..] => {
                let angle = PI - Vec3::from(a.normal).angle(&Vec3::from(b.normal));
                (2.0 * PI / angle).round() as u32
            }
        }
    })
}

/// Twelfths of a turn by which a field that is symmetric about two mirror planes turns between them
/// where they meet: the angle between them rounded, never 0. `count` is the [`multiplicity`] there.
pub(crate) fn twelfths_between(count: u32) -> f64 {
    (12.0 / f64::from(count) - 1e-6).round().max(1.0)
}
