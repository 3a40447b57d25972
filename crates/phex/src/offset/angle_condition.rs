//! The angle condition (4.1): when a planar face is parallel to a polygon that is inscribed in a
//! circle.
//!
//! With `2m` corners the condition is `t_0 + t_2 + ... = 0 mod pi`. On the branch `(m - 1) pi` this
//! is the paper's `t_0 + t_2 + t_4 = t_1 + t_3 + t_5`, for convex and for centrally symmetric
//! concave faces; the other branches belong to faces whose parallel inscribed polygon crosses
//! itself. A face with an odd number of corners meets no condition, but only two (antipodal)
//! inscribed polygons are parallel to it.

use phex_mesh::polygon::interior_angles;
use phex_mesh::{FaceId, FlatFace, HexMesh};
use std::f64::consts::PI;

/// The angle condition of one face with an even number of corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleCondition {
    /// The face.
    pub face: FaceId,
    /// Sum of every other angle minus the nearest multiple of pi, in radians, in [-pi/2, pi/2].
    pub defect: f64,
    /// That multiple.
    pub branch: i32,
    /// The multiple of the paper's condition: half the number of corners, minus 1.
    pub paper_branch: i32,
}

impl AngleCondition {
    /// The condition of a planar face; `None` if the number of its corners is odd.
    pub fn of(mesh: &HexMesh, face: FaceId) -> Option<Self> {
        let n = mesh.topology().valence(face);
        if !n.is_multiple_of(2) {
            return None;
        }
        let flat = FlatFace::of(mesh, face);
        let sum: f64 = interior_angles(&flat.polygon).step_by(2).sum();
        let branch = (sum / PI).round();
        Some(Self {
            face,
            defect: sum - branch * PI,
            branch: branch as i32,
            paper_branch: n as i32 / 2 - 1,
        })
    }
}

/// The conditions of all faces with an even number of corners, in the order of the faces.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// let conditions = phex::offset::angle_conditions(&cube);
/// assert!(conditions.iter().all(|condition| condition.defect.abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn angle_conditions(mesh: &HexMesh) -> Vec<AngleCondition> {
    let faces = mesh.topology().faces();
    faces.filter_map(|f| AngleCondition::of(mesh, f)).collect()
}
