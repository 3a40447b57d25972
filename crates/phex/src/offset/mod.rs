//! Parallel meshes: offsets at constant distance of faces, edges or vertices, Gauss images, layers
//! and solid panels.
//!
//! `M_d = M + d M'`, vertex by vertex, where the *Gauss image* `M'` is a mesh parallel to `M` whose
//! faces, edges or vertices touch the unit sphere. Source: Wang and Liu, "A note on planar
//! hexagonal meshes" (2010), section 4.
//!
//! | symbol | here | meaning |
//! |---|---|---|
//! | `d` | `distance` | signed; positive on the side of the face normals (winding), model units |
//! | `N_i`, `t_i` | `normals`, `angles` | unit normals and interior angles of the faces at a vertex |
//! | `N_v` | [`vertex_normal()`] | `N_v . N_i = 1`; the vertices of `M'` for the face-distance offset |
//! | `M'` | [`GaussImage`] | parallel mesh that touches the unit sphere |
//!
//! | file | what it computes |
//! |---|---|
//! | `vertex_normal` | where three moved planes meet, by four ways with error estimates |
//! | `face_offset` | face-distance offsets, one distance for all faces or one for each |
//! | `angle_condition` | the condition (4.1) for vertex-distance offsets |
//! | `vertex_offset` | spherical meshes by reflections along edges, and their holonomy |
//! | `gauss_image` | `M'` and `M + d M'` |
//! | `contact` | when a face first meets itself on its way |
//! | `edge_gauss_image` | the Koebe mesh that a given mesh is parallel to, if there is one |
//! | `inner_edges` | the same for a mesh that has been cut: by its inner edges alone |
//! | [`edge_offset`] | offsets at constant edge distance, of meshes parallel to a Koebe mesh |
//! | `signs` | which edges of a parallel mesh run against those of its Gauss image, where `K < 0` |
//! | `space`, `basis`, `fit` | the linear space of parallel meshes, a sparse basis, and those in it close to a surface |
//! | `inheritance` | what an offset takes over from its mesh, and what is new and therefore wrong |
//! | `layers` | offsets that have been checked, and how far one may go |
//! | `accuracy` | how far the distances of a finished offset are from what was asked for |
//! | `solids` | closed panels between two layers, mitred, with joint gaps |
//! | `beams` | beams and node axes between two layers |
//! | `options` | limits |
//! | `error` | why an offset can't be made |
//!
//! *Guaranteed*: a [`layer`] has no violation that its mesh has not, and no edge that points
//! backwards; a distance up to the safe one gives such a layer at every place that was looked at
//! ([`safe_distances`]). Error estimates of vertex normals cover rounding.
//!
//! *Not guaranteed*: at the boundary fewer than three faces say where a vertex of a face offset
//! goes, and it takes the shortest way. Edges at the boundary may turn by that, in the planes of
//! their faces, and `M'` is not parallel there ([`GaussImage::turned_edges`] lists them); inner
//! edges never do.
//!
//! *Fails*: for face offsets only where a vertex has not three faces, or faces that lie in one
//! plane are asked to part. Vertex offsets need the angle condition and, round odd faces inside and
//! round loops, a start that closes (`optimise::satisfy_angle_condition` makes both hold near a
//! mesh).
//!
//! *Differences from the paper*: the vertex normal is the best of four formulas, since the paper's
//! loses its digits at folded edges and where two faces lie in one plane; the angle condition is
//! taken modulo pi; on an annulus it is sufficient, too.

pub(crate) mod accuracy;
pub(crate) mod angle_condition;
mod basis;
pub(crate) mod beams;
mod contact;
pub(crate) mod edge_gauss_image;
pub(crate) mod edge_offset;
pub(crate) mod error;
pub(crate) mod face_offset;
pub(crate) mod fit;
pub(crate) mod gauss_image;
pub(crate) mod inheritance;

pub(crate) mod layers;
mod null_space;
pub(crate) mod options;
pub(crate) mod signs;
pub(crate) mod solids;
pub(crate) mod space;
pub(crate) mod vertex_normal;
pub(crate) mod vertex_offset;

#[cfg(test)]
mod tests;

pub use accuracy::{distance_error, face_distance_error};
pub use angle_condition::{AngleCondition, angle_conditions};
pub use basis::LengthChange;
pub use beams::{BeamAxis, NodeAxis, beam_axes, node_axes};
pub use edge_gauss_image::{EdgeGaussImage, edge_gauss_image};
pub use edge_offset::{edge_distances, edge_offset, face_curvatures};
pub use error::OffsetError;
pub use face_offset::{FaceOffset, face_gauss_image, face_normals, face_offset};
pub use fit::{FitError, FitOptions, FitStart, Fitted, fit_parallel};
pub use gauss_image::{GaussImage, OffsetKind, TurnedEdge};
pub use inheritance::Inheritance;
pub use layers::{
    SafeDistance, SafeDistances, layer, rounded_down, safe_distances, safe_distances_up_to,
    successive,
};
pub use null_space::Rank;
pub use options::OffsetOptions;
pub use signs::{EdgeSigns, SIGNED_FAIRNESS, SignError};
pub use solids::{PanelSolid, joined, panel_solids};
pub use space::ParallelSpace;
pub use vertex_normal::{Displacement, NormalMethod, TrivalentVertex, vertex_normal};
pub use vertex_offset::{Holonomy, SphericalMesh, spherical_mesh, vertex_gauss_image};
