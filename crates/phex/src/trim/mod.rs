//! Trim: panels of the extended surface brought back to the boundary of the surface itself.
//!
//! With [`Boundary::Whole`] and [`Boundary::Clip`] panels are laid out and made planar on a surface
//! that goes on beyond its boundary ([`crate::smooth_surface::extend`]): far, so that nothing at
//! the boundary disturbs them, or a little, so that the cut runs across a row of panels along the
//! boundary and leaves no slivers. Then
//!
//! * `whole` keeps the panels of which about half or more lies inside, so that their outline is
//!   short, and more where the coverage asks for it;
//! * `clip` cuts each panel in its own plane along the boundary curve projected to that plane. A
//!   cut through a shared edge is computed once, on the edge, so it lies in both planes; between
//!   two cuts a panel gets vertices of its own along the curve. Clipped panels are planar exactly,
//!   because they are parts of planar panels.
//!
//! A point is inside if its foot point on the extended surface lies on a triangle of the input's
//! part.
//!
//! Guaranteed: panels stay planar; interior vertices keep their degree of 3; the result is one
//! connected manifold. Fails, with an error, where nothing is left. Clipping can leave panels that
//! are too small: [`phex_mesh::small_rim_faces`] lists them, and the search joins them to others.

mod clip;
mod curve;
pub(crate) mod follow;
mod whole;

use crate::smooth_surface::extend::Extension;
use phex_mesh::{
    BoundaryCurve, FaceId, HexMesh, PerFace, TopologyError, TriangleSurface, Vec3, VertexId,
    numbered,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What happens at the boundary of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Boundary {
    /// Whole panels only; they end near the boundary, within about half a panel.
    Whole,
    /// Panels cut by the boundary curve.
    Clip,
    /// A row of panels along the boundary, their vertices on it.
    #[default]
    Snap,
}

/// Why nothing was trimmed.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum TrimError {
    /// Every panel lies outside.
    #[error("no panel lies within the boundary; ask for smaller panels")]
    NothingLeft,
    /// The panels that are left are not a manifold.
    #[error("the trimmed panels are not a manifold: {0}; ask for smaller panels")]
    Topology(#[from] TopologyError),
}

/// A mesh brought back to the boundary.
#[derive(Clone, Debug)]
pub struct Trimmed {
    /// The panels that are left.
    pub mesh: HexMesh,
    /// The panel of the untrimmed mesh that each is, or is part of.
    pub parent: PerFace<FaceId>,
}

impl Trimmed {
    /// A mesh of which nothing was cut off.
    pub(crate) fn whole(mesh: HexMesh) -> Self {
        let parent = PerFace::from_vec(mesh.topology().faces().collect());
        Self { mesh, parent }
    }
}

/// The part of an extended surface that panels are trimmed to.
pub struct Domain<'a> {
    /// The extended surface, refined.
    pub extended: &'a TriangleSurface,
    /// Which triangles of it are the input's.
    pub extension: &'a Extension,
    /// Subdivisions from the extension's triangles to those of `extended`.
    pub levels: usize,
    /// The surface that ends at the boundary.
    pub original: &'a TriangleSurface,
    /// Turning angle, radians, above which a vertex of the boundary is a corner.
    pub corner_angle: f64,
    /// Largest distance to the boundary that is allowed, over the diagonal, > 0.
    pub limit: f64,
}

impl Domain<'_> {
    /// Whether a point belongs to the input's part.
    pub fn contains(&self, p: Vec3) -> bool {
        let foot = self.extended.closest_point(p);
        self.extension.is_given(foot.triangle, self.levels)
    }
}

/// Trims a planar mesh; with [`Boundary::Snap`] it ends at the boundary as it is.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let plane = triangulate(&Shape::from_name("plane", &[])?, &TriangulationOptions::default())?;
/// use phex::smooth_surface::extend;
/// use phex::trim::{Boundary, Domain, trim};
/// use phex_mesh::{HexMesh, Vec3, measure};
///
/// // Four panels that stick out of a square of side 2.
/// let corner = |k: u32| Vec3::new((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0, 0.0) * 1.4;
/// let faces = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];
/// let panels = HexMesh::new((0..9).map(corner).collect(), &faces)?;
/// let extension = extend(&plane, 0.5, 0.5).ok_or("the plane has a boundary")?;
/// let domain = Domain {
///     extended: &extension.surface,
///     extension: &extension,
///     levels: 0,
///     original: &plane,
///     corner_angle: 0.5,
///     limit: 5e-3,
/// };
/// let clipped = trim(&panels, &domain, Boundary::Clip)?.mesh;
/// assert!((measure(&clipped).area - 4.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If nothing or no manifold is left.
pub fn trim(mesh: &HexMesh, domain: &Domain<'_>, boundary: Boundary) -> Result<Trimmed, TrimError> {
    let trimmed = match boundary {
        Boundary::Snap => Trimmed::whole(mesh.clone()),
        Boundary::Clip => clip::clipped(mesh, domain)?,
        Boundary::Whole => whole::whole_panels(mesh, domain)?,
    };
    without_middles(largest_part(trimmed)?)
}

/// The same without inner vertices at which two panels meet: where a part between them was left
/// out, their edges there are one.
fn without_middles(trimmed: Trimmed) -> Result<Trimmed, TrimError> {
    let topology = trimmed.mesh.topology();
    let is_middle = |v: VertexId| !topology.is_boundary_vertex(v) && topology.face_degree(v) == 2;
    if !topology.vertices().any(is_middle) {
        return Ok(trimmed);
    }
    let mut faces = topology.face_lists();
    for face in &mut faces {
        face.retain(|v| !is_middle(VertexId::new(*v)));
    }
    Ok(Trimmed {
        mesh: compact(trimmed.mesh.positions.as_slice(), &faces)?,
        parent: trimmed.parent,
    })
}

/// Faces and the positions they use, renumbered in the order of use.
pub(crate) fn compact(positions: &[Vec3], faces: &[Vec<u32>]) -> Result<HexMesh, TrimError> {
    if faces.is_empty() {
        return Err(TrimError::NothingLeft);
    }
    let (used, faces) = numbered(faces.iter().map(|f| f.iter().copied()));
    let places = used.iter().map(|v| positions[*v as usize]);
    Ok(HexMesh::new(places.collect(), &faces)?)
}

/// Some panels of a mesh.
pub(crate) fn part(mesh: &HexMesh, faces: &[FaceId]) -> Result<HexMesh, TrimError> {
    match faces.is_empty() {
        true => Err(TrimError::NothingLeft),
        false => Ok(mesh.part(faces)?),
    }
}

/// The connected part with the most panels.
fn largest_part(trimmed: Trimmed) -> Result<Trimmed, TrimError> {
    let (component, count) = trimmed.mesh.topology().components();
    if count == 1 {
        return Ok(trimmed);
    }
    let mut size = vec![0; count];
    component.iter().for_each(|&c| size[c as usize] += 1);
    let largest = (0..count).rev().max_by_key(|&c| size[c]).unwrap_or(0) as u32;
    let faces = trimmed.mesh.topology().faces();
    let kept: Vec<FaceId> = faces.filter(|&f| component[f] == largest).collect();
    Ok(Trimmed {
        mesh: part(&trimmed.mesh, &kept)?,
        parent: trimmed.parent.picked(&kept),
    })
}

/// Whether each panel comes near the boundary: nearer to its centre than twice its farthest corner.
fn near_boundary(mesh: &HexMesh, original: &TriangleSurface) -> Vec<bool> {
    let Some(curve) = BoundaryCurve::of(original) else {
        return vec![false; mesh.topology().n_faces()];
    };
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let near = |f: &FaceId| {
        let centre = mesh.centre(*f);
        let reach = mesh.corners(*f).map(|p| (p - centre).norm());
        let reach = 2.0 * reach.fold(0.0, f64::max);
        (curve.closest_point(centre).position - centre).norm() < reach
    };
    faces.par_iter().map(near).collect()
}

#[cfg(test)]
mod fixtures {
    use super::Domain;
    use crate::smooth_surface::extend::Extension;
    use phex_mesh::{TriangleSurface, Vec3};

    /// A flat square from 0 to 3.
    pub fn square() -> TriangleSurface {
        let n = 12;
        let at = |v: u32| Vec3::new(f64::from(v % (n + 1)), f64::from(v / (n + 1)), 0.0) * 0.25;
        let cells = (0..n * n).map(|c| c % n + (c / n) * (n + 1));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]])
            .collect();
        TriangleSurface::new((0..(n + 1) * (n + 1)).map(at).collect(), &triangles).unwrap()
    }

    /// An extended surface as it is, without refinement.
    pub fn domain<'a>(original: &'a TriangleSurface, extension: &'a Extension) -> Domain<'a> {
        Domain {
            extended: &extension.surface,
            extension,
            levels: 0,
            original,
            corner_angle: 0.7,
            limit: 5e-3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_of_two_panels_inside_goes() {
        let at = [(0, 0), (1, 0), (2, 0), (0, 2), (1, 2), (2, 2), (1, 1)];
        let at = at.map(|(x, y)| Vec3::new(f64::from(x), f64::from(y), 0.0));
        let mesh = HexMesh::new(at.to_vec(), &[[0u32, 1, 6, 4, 3], [1, 2, 5, 4, 6]]).unwrap();
        let left = without_middles(Trimmed::whole(mesh)).unwrap();
        assert_eq!(left.mesh.topology().n_vertices(), 6);
        assert_eq!(phex_mesh::measure(&left.mesh).area, 4.0);
    }
}
