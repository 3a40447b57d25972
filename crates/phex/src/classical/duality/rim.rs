//! Panels at the boundary that the planes of their neighbours leave no room.

use super::OrientedPlane;
use phex_mesh::polygon::{is_simple, signed_area};
use phex_mesh::{
    FaceId, FlatFace, HexMesh, PerFace, Topology, ValidateOptions, Vec2, Vec3, VertexId, Violation,
    violations,
};

/// The mesh without panels at the boundary that cross themselves or others or are turned over, and
/// the panels that are left. Where `K < 0` edges run to the boundary in zigzag, and two of them may
/// meet before they get there: then nothing is left of the panel between them.
///
/// Of two panels that cross each other the smaller one goes. A panel goes only if it is at the
/// boundary of what is left and, in the given mesh, at the boundary or next to a panel there: one
/// that comes to lie at the boundary may be broken itself. It stays if its loss would leave others
/// joined in single vertices, or not at all.
pub(crate) fn without_broken_rim(
    mesh: &HexMesh,
    planes: &PerFace<OrientedPlane>,
) -> (HexMesh, Vec<FaceId>) {
    let topology = mesh.topology();
    let pieces = topology.components().1;
    let mut may_go = near_boundary(topology);
    let mut kept: Vec<FaceId> = topology.faces().collect();
    let mut made = mesh.clone();
    while let Some(worst) = worst(
        &made,
        &|f| may_go[kept[f.index()]] && made.topology().is_boundary_face(f),
        &|f| planes[kept[f.index()]].normal,
    ) {
        let others = made.topology().faces().filter(|f| *f != worst);
        let rest = made.part(&others.collect::<Vec<_>>());
        may_go[kept[worst.index()]] = false;
        if let Some(rest) = rest.ok().filter(|m| m.topology().components().1 == pieces) {
            made = rest;
            kept.remove(worst.index());
        }
    }
    (made, kept)
}

/// Panels at the boundary, and those that have a vertex in common with one.
fn near_boundary(topology: &Topology) -> PerFace<bool> {
    let at_rim = |v: VertexId| {
        let mut around = topology.faces_at(v);
        around.any(|f| topology.is_boundary_face(f))
    };
    PerFace::from_fn(topology.n_faces(), |f| {
        topology.face_vertices(f).iter().any(|v| at_rim(*v))
    })
}

/// The panel to take out first: one that is broken itself, or else the smallest that is at odds
/// with others.
fn worst(
    mesh: &HexMesh,
    may_go: &dyn Fn(FaceId) -> bool,
    normal: &dyn Fn(FaceId) -> Vec3,
) -> Option<FaceId> {
    let mut rim = mesh.topology().faces().filter(|f| may_go(*f));
    rim.find(|f| is_broken(mesh, *f, normal(*f))).or_else(|| {
        let found = violations(mesh, None, &ValidateOptions::default());
        let between = found.iter().filter(|v| {
            use Violation::{Crossing, FlippedFace, Fold, WrongFan};
            matches!(
                v,
                Crossing { .. } | FlippedFace { .. } | Fold { .. } | WrongFan { .. }
            )
        });
        // A broken panel that has to stay would have others taken out until it is alone.
        let is_sound = |f: &FaceId| !is_broken(mesh, *f, normal(*f));
        let between = between.map(|v| v.faces(mesh.topology()));
        let involved = between.filter(|faces| faces.iter().all(is_sound)).flatten();
        let area = |f: &FaceId| FlatFace::of(mesh, *f).area();
        involved
            .filter(|f| may_go(*f))
            .min_by(|f, g| area(f).total_cmp(&area(g)).then(f.cmp(g)))
    })
}

fn is_broken(mesh: &HexMesh, f: FaceId, normal: Vec3) -> bool {
    let axes = crate::curvature::tangent_frame(normal);
    let centre = mesh.centre(f);
    let flat = |p: Vec3| -> Vec2 { axes.map(|a| (p - centre).dot(&a)).into() };
    let outline: Vec<Vec2> = mesh.corners(f).map(flat).collect();
    signed_area(&outline) <= 0.0 || !is_simple(&outline)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of three squares of side 1; the middle one's upper boundary vertices cross over if
    /// they are moved by more than a half.
    fn row(shift: f64) -> (HexMesh, PerFace<OrientedPlane>) {
        let at = |k: usize| {
            let (x, y) = ((k % 4) as f64, (k / 4) as f64);
            let moved = if y > 0.5 && (0.5..2.5).contains(&x) {
                shift * (1.5 - x).signum()
            } else {
                0.0
            };
            Vec3::new(x + moved, y, 0.0)
        };
        let faces = [[0u32, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]];
        let mesh = HexMesh::new((0..8).map(at).collect(), &faces).unwrap();
        let up = OrientedPlane::through(Vec3::zeros(), Vec3::z());
        (mesh, PerFace::filled(3, up))
    }

    #[test]
    fn panels_that_hold_the_others_together_stay() {
        let (mesh, planes) = row(0.7);
        let (left, kept) = without_broken_rim(&mesh, &planes);
        assert_eq!((kept.len(), left.topology().n_faces()), (3, 3));
    }

    #[test]
    fn a_crossed_panel_at_the_end_is_taken_out() {
        let (mut mesh, planes) = row(0.0);
        assert_eq!(without_broken_rim(&mesh, &planes).1.len(), 3);
        // The corners on the right change places.
        mesh.positions[VertexId::new(3)].y = 1.0;
        mesh.positions[VertexId::new(7)].y = 0.0;
        let (left, kept) = without_broken_rim(&mesh, &planes);
        let names: Vec<usize> = kept.iter().map(|f| f.index()).collect();
        assert_eq!(names, [0, 1]);
        assert_eq!(left.positions.len(), 6);
    }
}
