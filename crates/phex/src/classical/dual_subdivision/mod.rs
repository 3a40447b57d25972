//! Dual subdivision: the rules of triangle meshes, applied to a P-Hex mesh through its dual.
//!
//! The poles of the faces form a triangle mesh, since three faces meet at every vertex. It is
//! subdivided, and each triangle of the finer mesh is a vertex of a finer P-Hex mesh: where the
//! polar planes of its corners meet. Faces stay planar to rounding at every level. Old faces are
//! kept (by Loop's rule moved), every edge becomes a new face.
//!
//! | rule | old vertices | new vertices |
//! |---|---|---|
//! | [`SubdivisionRule::Loop`] | smoothed (Loop 1987) | `(3, 3, 1, 1) / 8` |
//! | [`SubdivisionRule::Butterfly`] | kept | Dyn, Levin, Gregory 1990, at irregular vertices Zorin, Schroeder, Sweldens 1996 |
//!
//! [`chamfer()`] makes the same connectivity in space, without the dual, for the robust way:
//! subdivide, then optimise back to the surface (`pipeline::subdivide`).
//!
//! Source: H. Kawaharada, K. Sugihara, as reviewed by W. Wang and Y. Liu, "A note on planar
//! hexagonal meshes" (2010), section 2; a subdivision scheme as a design tool is asked for in their
//! section 5.
//!
//! Guaranteed: planar faces, degree 3 inside, the topology of the inside. Fails, with an error:
//! where a face's plane passes through the centre. Where the Gauss curvature changes its sign the
//! dual folds over, and planes meet badly: [`one_sign`] tells beforehand. Nothing keeps faces
//! simple where the dual is badly distorted. At the rim of an open mesh, rules do to quadratic
//! functions what they do inside, and boundary vertices stay as near to the given boundary as their
//! planes let them.

mod butterfly;
mod chamfer;
mod domain;
mod loop_rule;
mod refined;
mod rim;

pub(crate) use chamfer::chamfer;
pub use domain::one_sign;

use super::duality::{
    DualTriangles, DualityError, OrientedPlane, Quadric, SubdivisionRule, clear_centre, envelope,
};
use phex_mesh::{EdgeId, FaceId, FacePlane, HexMesh, PerFace, PerVertex, Topology, Vec3};
use refined::{Refined, refined};
use std::collections::BTreeMap;

/// A centre away from the planes of a mesh's faces, and how clear it is of them: see
/// `clear_centre`.
pub fn clear_centre_of(mesh: &HexMesh) -> (Vec3, f64) {
    let fitted = mesh.topology().faces().map(|f| FacePlane::of(mesh, f));
    let planes = fitted.map(|p| (OrientedPlane::through(p.centre, p.normal), p.centre));
    let (planes, points): (Vec<OrientedPlane>, Vec<Vec3>) = planes.unzip();
    clear_centre(&planes, &points)
}

/// The quadric for the dual of a mesh: the unit sphere about such a centre.
///
/// # Errors
/// If the centre is not finite, that is if the mesh is not.
pub fn clear_quadric(mesh: &HexMesh) -> Result<Quadric, DualityError> {
    Quadric::sphere(clear_centre_of(mesh).0, 1.0)
}

/// The mesh at every level after the given one.
///
/// # Errors
/// If the dual does not exist, has a vertex of other degree than 3 inside, or planes do not meet.
pub fn dual_subdivision(
    mesh: &HexMesh,
    quadric: &Quadric,
    rule: SubdivisionRule,
    levels: usize,
) -> Result<Vec<HexMesh>, DualityError> {
    let topology = mesh.topology();
    let wrong = topology
        .inner_vertices()
        .find(|v| topology.face_degree(*v) != 3);
    if let Some(vertex) = wrong {
        let degree = topology.face_degree(vertex);
        return Err(DualityError::Degree { vertex, degree });
    }
    let pole = |face: FaceId| quadric.pole_of(face, &OrientedPlane::of(mesh, face));
    let poles: Result<Vec<Vec3>, _> = topology.faces().map(pole).collect();
    let mut coarse = (mesh.clone(), PerFace::from_vec(poles?));
    let mut made = Vec::with_capacity(levels);
    for _ in 0..levels {
        coarse = level(&coarse.0, &coarse.1, quadric, rule)?;
        made.push(coarse.0.clone());
    }
    Ok(made)
}

/// The next mesh and its poles.
fn level(
    mesh: &HexMesh,
    poles: &PerFace<Vec3>,
    quadric: &Quadric,
    rule: SubdivisionRule,
) -> Result<(HexMesh, PerFace<Vec3>), DualityError> {
    let finer = refined(mesh)?;
    let poles = finer_poles(mesh.topology(), &finer, poles, rule)?;
    let plane = |(face, pole): (FaceId, &Vec3)| {
        quadric
            .polar(*pole)
            .ok_or(DualityError::PoleAtInfinity { face })
    };
    let planes: Result<Vec<OrientedPlane>, _> = poles.enumerate().map(plane).collect();
    Ok((envelope(&finer.mesh, &PerFace::from_vec(planes?))?, poles))
}

/// Poles by a rule. Panels with no vertex inside have no triangle in the dual: they keep theirs,
/// and the panel between two such ones has the mean.
fn finer_poles(
    topology: &Topology,
    finer: &Refined,
    poles: &PerFace<Vec3>,
    rule: SubdivisionRule,
) -> Result<PerFace<Vec3>, DualityError> {
    let dual = DualTriangles::of(topology)?;
    let triangles = Topology::from_faces(dual.face_of_vertex.len(), &dual.triangles)?;
    let (step, _) = match rule {
        SubdivisionRule::Loop => loop_rule::refinement(&triangles),
        SubdivisionRule::Butterfly => butterfly::refinement(&triangles),
    };
    let values: PerVertex<Vec3> = step.apply(&poles.picked(&dual.face_of_vertex));
    let (old, new) = values.as_slice().split_at(triangles.n_vertices());
    let mut made = poles.as_slice().to_vec();
    for (f, pole) in dual.face_of_vertex.iter().zip(old) {
        made[f.index()] = *pole;
    }
    let sides = |e: EdgeId| {
        triangles
            .edge_vertices(e)
            .map(|v| dual.face_of_vertex[v.index()])
    };
    let pair = |[f, g]: [FaceId; 2]| [f.min(g), f.max(g)];
    let of_pair: BTreeMap<[FaceId; 2], Vec3> = triangles
        .edges()
        .map(|e| pair(sides(e)))
        .zip(new.iter().copied())
        .collect();
    made.extend(finer.edges.iter().filter_map(|e| {
        let faces = topology.faces_beside(*e)?;
        let mean = (poles[faces[0]] + poles[faces[1]]) * 0.5;
        Some(of_pair.get(&pair(faces)).copied().unwrap_or(mean))
    }));
    Ok(PerFace::from_vec(made))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classical::power_diagram::goldberg;
    use phex_mesh::{VertexId, measure};

    #[test]
    fn goldberg_polyhedra_double_their_frequency_and_stay_planar() {
        let coarse = goldberg(2, 1).unwrap().mesh;
        let quadric = clear_quadric(&coarse).unwrap();
        for rule in [SubdivisionRule::Loop, SubdivisionRule::Butterfly] {
            let levels = dual_subdivision(&coarse, &quadric, rule, 3).unwrap();
            for (k, mesh) in levels.iter().enumerate() {
                let measures = measure(mesh);
                let frequency = 7 << (2 * (k + 1));
                assert_eq!(measures.faces, 10 * frequency + 2, "{rule:?}");
                assert_eq!(measures.face_sizes[&5], 12);
                assert!(
                    measures.planarity.max < 1e-12,
                    "{rule:?}: {}",
                    measures.planarity.max
                );
                assert_eq!(
                    (measures.faces_not_simple, measures.faces_concave),
                    (0, 0),
                    "{rule:?}"
                );
            }
        }
    }

    #[test]
    fn butterfly_keeps_the_planes_of_old_faces() {
        let coarse = goldberg(2, 0).unwrap().mesh;
        let quadric = clear_quadric(&coarse).unwrap();
        let fine = &dual_subdivision(&coarse, &quadric, SubdivisionRule::Butterfly, 1).unwrap()[0];
        for f in coarse.topology().faces() {
            let plane = |m: &HexMesh| FacePlane::of(m, f);
            let (old, new) = (plane(&coarse), plane(fine));
            assert!(
                (old.normal - new.normal).norm() < 1e-9 && old.height(new.centre).abs() < 1e-12
            );
        }
    }

    #[test]
    fn a_vertex_of_degree_four_is_named() {
        let octahedron_dual = [
            [0u32, 1, 2],
            [0, 2, 3],
            [0, 3, 4],
            [0, 4, 1],
            [5, 2, 1],
            [5, 3, 2],
            [5, 4, 3],
            [5, 1, 4],
        ];
        let positions = [
            Vec3::z(),
            Vec3::x(),
            Vec3::y(),
            -Vec3::x(),
            -Vec3::y(),
            -Vec3::z(),
        ];
        let mesh = HexMesh::new(positions.to_vec(), &octahedron_dual).unwrap();
        let quadric = clear_quadric(&mesh).unwrap();
        let error = dual_subdivision(&mesh, &quadric, SubdivisionRule::Loop, 1).unwrap_err();
        let vertex = VertexId::new(0);
        assert_eq!(error, DualityError::Degree { vertex, degree: 4 });
    }
}
