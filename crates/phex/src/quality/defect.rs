//! Defects: places where a mesh is outside its limits, or a panel is tight, misshapen or small.

use super::judge::Judgement;
use phex_mesh::{FaceId, HexMesh, Vec3};
use std::collections::BTreeSet;

/// Faces that hang together and are not as they should be.
#[derive(Clone, Debug, PartialEq)]
pub struct Defect {
    /// The faces, the worst first.
    pub faces: Vec<FaceId>,
    /// The middle of the worst.
    pub place: Vec3,
    /// Whether panels are too large there: the surface stands off, or sheets cross.
    pub needs_more: bool,
    /// Whether it is allowed: a panel is tight, misshapen or small, and nothing is invalid or
    /// outside limits.
    pub is_allowed: bool,
    /// Whether more room is all that is lacking, and not much of it.
    pub is_slight: bool,
    /// Whether a panel is no panel, not planar, folded against another, or too narrow.
    pub is_broken: bool,
    /// How bad it is, to compare defects.
    pub amount: f64,
}

/// The defects of a mesh, the worst first: each a face with those of its neighbours that are no
/// better.
pub fn defects(mesh: &HexMesh, judgement: &Judgement) -> Vec<Defect> {
    let findings = &judgement.of_face;
    let found = findings.enumerate().filter(|(_, found)| found.is_defect());
    let mut faces: Vec<FaceId> = found.map(|(f, _)| f).collect();
    let amount = |f: &FaceId| findings[*f].amount();
    faces.sort_by(|a, b| amount(b).total_cmp(&amount(a)).then(a.cmp(b)));
    let mut left: BTreeSet<FaceId> = faces.iter().copied().collect();
    let mut defects = Vec::new();
    for f in faces {
        if left.remove(&f) {
            let beside = (mesh.topology().adjacent_faces(f)).filter(|g| left.remove(g));
            let worst = &findings[f];
            let mut faces: Vec<FaceId> = std::iter::once(f).chain(beside).collect();
            // The other sheet is a place of this defect, too.
            let across = worst.crossed.filter(|g| !faces.contains(g));
            if let Some(other) = across {
                left.remove(&other);
                faces.push(other);
            }
            defects.push(Defect {
                place: mesh.centre(f),
                needs_more: worst.needs_more(),
                is_allowed: faces.iter().all(|f| findings[*f].is_within()),
                is_slight: faces.iter().all(|f| findings[*f].is_slight()),
                is_broken: faces.iter().any(|f| findings[*f].is_broken()),
                amount: faces.iter().map(amount).sum(),
                faces,
            });
        }
    }
    defects
}
