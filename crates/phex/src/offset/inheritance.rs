//! What an offset takes over from its mesh, and what is new and therefore wrong.
//!
//! Parallel meshes share the normals of their faces and the directions of their edges, as long as
//! no edge turns round. So folds, fans and faces against their neighbours are those of the mesh at
//! every distance. And a mesh with edges or necks shorter than panels should have is no worse for
//! being offset: what is asked of the offset is then half of what the mesh has.

use super::{OffsetError, OffsetOptions};
use phex_mesh::{FlatFace, HexMesh, ValidateOptions, Violation, violations};
use std::collections::BTreeSet;

/// Share of its own least clearance and edge that an offset of a mesh with too little of them
/// keeps.
const SHARE: f64 = 0.5;

/// What is wrong with a mesh before it is offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Inheritance {
    /// Violations of the mesh that its offsets keep; empty if it is valid.
    pub violations: Vec<Violation>,
    /// What is asked of the offsets.
    pub validity: ValidateOptions,
}

impl Inheritance {
    /// That of a mesh.
    ///
    /// # Errors
    /// If something is wrong with the mesh that no offset of it could be trusted with: faces that
    /// are not planar or not simple, crossings, wrong degrees.
    pub fn of(mesh: &HexMesh, options: &OffsetOptions) -> Result<Self, OffsetError> {
        let violations = violations(mesh, None, &options.validity);
        let mut fatal = violations.iter().filter(|v| !is_kept(v));
        if let Some(first) = fatal.next() {
            return Err(OffsetError::MeshNotValid {
                first: Box::new(first.clone()),
                count: 1 + fatal.count(),
            });
        }
        let validity = relaxed(mesh, &violations, options.validity);
        Ok(Self {
            violations,
            validity,
        })
    }

    /// The offset `moved` of `mesh` by (at most) `distance`, if nothing is wrong with it that was
    /// not before and no edge points backwards.
    ///
    /// # Errors
    /// If there is a new violation; the first one is named.
    pub fn checked(
        &self,
        mesh: &HexMesh,
        moved: HexMesh,
        distance: f64,
    ) -> Result<HexMesh, OffsetError> {
        let faults = self.faults(mesh, &moved);
        match faults.first() {
            None => Ok(moved),
            Some(first) => Err(OffsetError::NotValid {
                distance,
                first: Box::new(first.clone()),
                count: faults.len(),
            }),
        }
    }

    /// One of the things that are newly wrong with an offset.
    pub(super) fn first_fault(&self, mesh: &HexMesh, moved: &HexMesh) -> Option<Violation> {
        self.faults(mesh, moved).into_iter().next()
    }

    fn faults(&self, mesh: &HexMesh, moved: &HexMesh) -> Vec<Violation> {
        let backward = backward_edges(mesh, moved, self.validity.edge_length_rel);
        if !backward.is_empty() {
            return backward;
        }
        let before: BTreeSet<_> = self.violations.iter().filter_map(place).collect();
        let mut found = violations(moved, None, &self.validity);
        found.retain(|v| place(v).is_none_or(|p| !before.contains(&p)));
        found
    }
}

/// Edges that have been flipped: they point against their direction in `mesh`.
fn backward_edges(mesh: &HexMesh, moved: &HexMesh, limit: f64) -> Vec<Violation> {
    let topology = mesh.topology();
    let unit = moved.mean_edge();
    let flipped = topology.edges().filter_map(|edge| {
        let vertices = topology.edge_vertices(edge);
        let length = moved
            .edge_vector(edge)
            .dot(&mesh.edge_vector(edge).normalize());
        let forward = length > 0.0;
        (!forward).then_some(Violation::CollapsedEdge {
            edge,
            vertices,
            length_rel: length / unit,
            limit,
        })
    });
    flipped.collect()
}

/// Whether offsets keep such a violation.
fn is_kept(violation: &Violation) -> bool {
    let short = matches!(
        violation,
        Violation::SmallClearance { .. } | Violation::CollapsedEdge { .. }
    );
    short || place(violation).is_some()
}

/// Kind and element of a violation that depends on normals and directions alone.
fn place(violation: &Violation) -> Option<(&'static str, usize)> {
    let element = match violation {
        Violation::Fold { edge, .. } => edge.index(),
        Violation::FlippedFace { face, .. } => face.index(),
        Violation::WrongFan { vertex, .. } => vertex.index(),
        _ => return None,
    };
    Some((violation.kind(), element))
}

/// Limits that the mesh itself meets.
fn relaxed(mesh: &HexMesh, violations: &[Violation], limits: ValidateOptions) -> ValidateOptions {
    let short = violations.iter().any(|v| place(v).is_none());
    if !short {
        return limits;
    }
    let unit = mesh.mean_edge();
    let least =
        |sizes: &mut dyn Iterator<Item = f64>| SHARE * sizes.fold(f64::INFINITY, f64::min) / unit;
    let faces = FlatFace::all(mesh);
    let clearance = least(&mut faces.iter().map(|f| f.clearance().distance));
    let edge = least(&mut mesh.topology().edges().map(|e| mesh.edge_length(e)));
    ValidateOptions {
        clearance: limits.clearance.min(clearance),
        edge_length_rel: limits.edge_length_rel.min(edge),
        ..limits
    }
}
