//! What keeps the boundary of a part while its panels move.

use crate::optimise::panels::FaceShapes;
use crate::optimise::steering::on_boundary::already_there;
use crate::optimise::{BoundaryHold, Hold, Holds};
use phex_mesh::{BoundaryCurve, HexMesh, Vec3, VertexId};

/// What keeps the boundary: on its curve where it lies there, along the curve where it does not, at
/// rest where no curve is known.
pub(super) fn rim_holds(mesh: &HexMesh, shape: &FaceShapes, hold: Option<&BoundaryHold>) -> Holds {
    let topology = mesh.topology();
    let rim = topology.boundary_vertices();
    let place = |v: VertexId| match hold {
        Some(hold) => along(mesh, shape, v, &hold.curves),
        None => Hold::At(mesh.position(v)),
    };
    let mut holds = Holds {
        held: rim.map(|v| (v.index() as u32, place(v))).collect(),
        ..Holds::default()
    };
    if let Some(hold) = hold {
        holds.held.extend(already_there(mesh, hold));
        holds.rim = Some(hold.curves.clone());
    }
    holds
}

/// The plane through a vertex of the boundary, along the curve and across the panels there.
fn along(mesh: &HexMesh, shape: &FaceShapes, v: VertexId, curves: &BoundaryCurve) -> Hold {
    let topology = mesh.topology();
    let point = mesh.position(v);
    let faces = topology.faces_at(v).map(|f| f.index());
    let up: Vec3 = faces.map(|f| shape.normal(f)).sum();
    let across = curves.closest_point(point).tangent.cross(&up);
    match across.try_normalize(f64::MIN_POSITIVE) {
        Some(normal) => Hold::InPlane { point, normal },
        None => Hold::At(point),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::panels::{Panels, unknowns};
    use crate::optimise::tests::fixtures::{Shape as Surface, brick_wall, layout};
    use crate::optimise::{OptimiseOptions, Optimised, optimise};
    use crate::progress::Silent;

    /// Planar panels that were made with hardly a barrier.
    fn tight() -> Optimised {
        let shape = Surface::Wave;
        let options = OptimiseOptions {
            barrier: 2e-2,
            barrier_reach: 0.2,
            ..OptimiseOptions::default()
        };
        let layout = layout(brick_wall(shape, 25, 12), &shape);
        optimise(&layout, &shape, &options, &Silent).unwrap()
    }

    fn boundary(mesh: &HexMesh) -> BoundaryCurve {
        let place = |v: &VertexId| mesh.position(*v);
        let loops = mesh.topology().boundary_loops();
        let closed = |l: &Vec<VertexId>| l.iter().chain(l.first()).map(place).collect();
        BoundaryCurve::of_polylines(&loops.iter().map(closed).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn the_boundary_slides_on_its_curve_or_beside_it() {
        let mesh = tight().mesh;
        let panels = Panels::new(mesh.topology());
        let shape = FaceShapes::at(&panels, &unknowns(&mesh));
        let beside = mesh.mapped(|p| p * 1.001);
        for (mesh, on_it) in [(&mesh, true), (&beside, false)] {
            let curves = boundary(&tight().mesh);
            let hold = BoundaryHold {
                curves: curves.clone(),
                corners: Vec::new(),
            };
            let held = rim_holds(mesh, &shape, Some(&hold)).held;
            let rim = mesh
                .topology()
                .boundary_loops()
                .iter()
                .map(Vec::len)
                .sum::<usize>();
            assert_eq!(held.len(), rim);
            // Where the curve meets the origin's rays at a tangent a few are on both.
            let on_curve = held.values().filter(|h| **h == Hold::OnRim).count();
            assert_eq!(on_curve > rim / 2, on_it, "{on_curve} of {rim}");
            for hold in held.values() {
                if let Hold::InPlane { point, normal } = hold {
                    let tangent = curves.closest_point(*point).tangent;
                    assert!(tangent.dot(normal).abs() < 1e-12);
                }
            }
        }
    }
}
