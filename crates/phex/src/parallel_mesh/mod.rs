//! Parallel meshes: offsets at constant distance of faces or vertices, Gauss images, layers and solid panels.
//!
//! `M_d = M + d M'`, vertex by vertex, where the *Gauss image* `M'` is a mesh parallel to `M` whose faces, edges or
//! vertices touch the unit sphere. Source: Wang and Liu, "A note on planar hexagonal meshes" (2010), section 4.
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
//! | [`vertex_normal`](mod@vertex_normal) | where three moved planes meet, by three ways with error estimates |
//! | [`face_offset`](mod@face_offset) | face-distance offsets, one distance for all faces or one for each |

pub mod error;
pub mod face_offset;
pub mod gauss_image;
pub mod vertex_normal;

#[cfg(test)]
mod tests;

pub use error::OffsetError;
pub use face_offset::{FaceOffset, face_gauss_image, face_offset};
pub use gauss_image::{GaussImage, OffsetKind};
pub use vertex_normal::{Displacement, NormalMethod, vertex_normal};
