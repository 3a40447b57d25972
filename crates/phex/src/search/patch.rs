//! Patches: some panels with what is around them, as a mesh of its own, and how they go back.

use super::draft::Draft;
use phex_mesh::{FaceId, HexMesh, Vec3, VertexId, numbered};
use std::collections::{BTreeMap, BTreeSet};

/// Rings of panels around those that may be joined anew whose corners move with them; one more ring
/// is planar already and shows where they end.
const MOVING: usize = 1;

/// Some panels of a mesh and what is around them.
pub(super) struct Patch {
    /// Its panels in the mesh.
    pub faces: Vec<FaceId>,
    /// Its corners in the mesh.
    vertices: Vec<VertexId>,
    pub draft: Draft,
    /// Panels, in the patch, that the defect names, the worst first.
    pub core: Vec<usize>,
    /// Whether the corners of each panel may move.
    moves: Vec<bool>,
}

/// The faces with those that share a corner with one of them.
pub(super) fn with_ring(mesh: &HexMesh, faces: &BTreeSet<FaceId>) -> BTreeSet<FaceId> {
    let topology = mesh.topology();
    let corners = faces.iter().flat_map(|f| topology.face_vertices(*f));
    let around = corners.flat_map(|v| topology.faces_at(*v));
    around.chain(faces.iter().copied()).collect()
}

impl Patch {
    /// The panels within `rings` rings of some may be joined anew, except those that rest.
    pub fn around(
        mesh: &HexMesh,
        core: &[FaceId],
        rings: usize,
        resting: &BTreeSet<FaceId>,
    ) -> Self {
        let topology = mesh.topology();
        let first: BTreeSet<FaceId> = core.iter().copied().collect();
        let wider = |faces: &BTreeSet<FaceId>| -> BTreeSet<FaceId> {
            with_ring(mesh, faces)
                .difference(resting)
                .copied()
                .collect()
        };
        let open = (0..rings).fold(first, |faces, _| wider(&faces));
        let moving = (0..MOVING).fold(open.clone(), |faces, _| wider(&faces));
        let faces: Vec<FaceId> = with_ring(mesh, &moving).into_iter().collect();
        let corners = faces.iter().flat_map(|f| topology.face_vertices(*f));
        let vertices: BTreeSet<VertexId> = corners.copied().collect();
        let vertices: Vec<VertexId> = vertices.into_iter().collect();
        let number = |v: &VertexId| vertices.binary_search(v).expect("a corner of a panel") as u32;
        let ring = |f: &FaceId| topology.face_vertices(*f).iter().map(number).collect();
        let within = |set: &BTreeSet<FaceId>| faces.iter().map(|f| set.contains(f)).collect();
        let draft = Draft {
            faces: faces.iter().map(ring).collect(),
            places: vertices.iter().map(|v| mesh.position(*v)).collect(),
            open: within(&open),
            on_boundary: (vertices.iter().map(|v| topology.is_boundary_vertex(*v))).collect(),
            origin: (0..faces.len()).collect(),
        };
        let core = core
            .iter()
            .filter_map(|f| faces.binary_search(f).ok())
            .collect();
        Self {
            moves: within(&moving),
            faces,
            vertices,
            draft,
            core,
        }
    }

    /// A draft of the patch as a mesh; `None` if its panels are no manifold, or a place of theirs
    /// is not finite: strips along edges without length have such.
    pub fn built(&self, draft: &Draft) -> Option<Built> {
        let kept = draft.kept();
        let rings = kept.iter().map(|f| draft.faces[*f].iter().copied());
        let (vertices, faces) = numbered(rings);
        let places: Vec<Vec3> = vertices.iter().map(|v| draft.places[*v as usize]).collect();
        let is_finite = places.iter().flatten().all(|x| x.is_finite());
        let mesh = HexMesh::new(places, &faces).ok().filter(|_| is_finite)?;
        let moves = |f: usize| self.moves[draft.origin[f]];
        let mut free = vec![true; vertices.len()];
        for (k, f) in kept.iter().enumerate() {
            if !moves(*f) {
                faces[k].iter().for_each(|v| free[*v as usize] = false);
            }
        }
        Some(Built {
            counts: kept.iter().map(|f| moves(*f)).collect(),
            faces: kept,
            vertices,
            free,
            mesh,
        })
    }
}

/// A draft of a patch as a mesh.
pub(super) struct Built {
    pub mesh: HexMesh,
    /// The panel of the draft that each is.
    faces: Vec<usize>,
    /// The corner of the draft that each is.
    vertices: Vec<u32>,
    /// Whether each corner may move.
    pub free: Vec<bool>,
    /// Whether each panel is judged: those that are at rest are not.
    pub counts: Vec<bool>,
}

impl Built {
    /// The same with other places of its corners.
    pub fn with(self, mesh: HexMesh) -> Self {
        Self { mesh, ..self }
    }
}

/// A patch with its panels joined anew and planar.
pub(super) struct Change {
    /// The panels of the mesh that go.
    pub removed: Vec<FaceId>,
    faces: Vec<Vec<PatchCorner>>,
    /// The panel of the mesh in whose place each comes; `None` for one that is new.
    replaces: Vec<Option<FaceId>>,
    moved: Vec<(VertexId, Vec3)>,
    added: Vec<Vec3>,
}

enum PatchCorner {
    Old(VertexId),
    New(usize),
}

impl Change {
    pub fn new(patch: &Patch, draft: &Draft, built: &Built) -> Self {
        let old = |v: u32| patch.vertices.get(v as usize).copied();
        let (mut added, mut moved, mut of_new) = (Vec::new(), Vec::new(), BTreeMap::new());
        for (v, p) in built.vertices.iter().zip(&built.mesh.positions) {
            match old(*v) {
                Some(w) => moved.push((w, *p)),
                None => {
                    of_new.insert(*v, added.len());
                    added.push(*p);
                }
            }
        }
        let corner =
            |v: &u32| old(*v).map_or_else(|| PatchCorner::New(of_new[v]), PatchCorner::Old);
        let ring = |f: &usize| draft.faces[*f].iter().map(corner).collect();
        Self {
            removed: patch.faces.clone(),
            faces: built.faces.iter().map(ring).collect(),
            replaces: (built.faces.iter())
                .map(|f| patch.faces.get(*f).copied())
                .collect(),
            moved,
            added,
        }
    }
}

/// The mesh with changes of patches that share no panel; panels that stay keep their order, new
/// ones come last. `None` if that is no manifold.
pub(super) fn applied(mesh: &HexMesh, changes: &[Change]) -> Option<HexMesh> {
    let mut positions = mesh.positions.as_slice().to_vec();
    let mut faces: Vec<Vec<u32>> = mesh.topology().face_lists();
    for change in changes {
        let first = positions.len();
        positions.extend(&change.added);
        change
            .moved
            .iter()
            .for_each(|(v, p)| positions[v.index()] = *p);
        change.removed.iter().for_each(|f| faces[f.index()].clear());
        for (ring, place) in change.faces.iter().zip(&change.replaces) {
            let number = |c: &PatchCorner| match c {
                PatchCorner::Old(v) => v.index() as u32,
                PatchCorner::New(k) => (first + k) as u32,
            };
            let ring: Vec<u32> = ring.iter().map(number).collect();
            match place {
                Some(f) => faces[f.index()] = ring,
                None => faces.push(ring),
            }
        }
    }
    faces.retain(|f| !f.is_empty());
    crate::trim::compact(&positions, &faces).ok()
}
