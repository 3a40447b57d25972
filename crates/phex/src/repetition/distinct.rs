//! How many different parts a mesh has.

use super::shared::distinct_lengths;
use phex_mesh::cluster::{Congruence, Rings, by_value, congruent};
use phex_mesh::polygon::interior_angles;
use phex_mesh::{FlatFace, HexMesh};
use serde::{Deserialize, Serialize};

/// Numbers of different parts of a mesh, within a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DistinctParts {
    /// The least number of intervals, as wide as the tolerance, that hold all edge lengths.
    pub edge_lengths: usize,
    /// The same for the angles of panels at their corners and the tolerance's angle.
    pub node_angles: usize,
    /// Panels whose corners do not coincide up to the tolerance, however they are turned in their
    /// planes.
    pub panels: usize,
    /// The same where panels may be turned over, too.
    pub panels_mirrored: usize,
}

impl DistinctParts {
    /// Counts the parts of a mesh; `tolerance` has its unit, `angle` is in radians.
    pub fn of(mesh: &HexMesh, tolerance: f64, angle: f64) -> Self {
        let flat = FlatFace::all(mesh);
        let angles = flat.iter().flat_map(|f| interior_angles(&f.polygon));
        let panels: Vec<Rings> = flat.iter().map(|f| vec![f.polygon.clone()]).collect();
        let distinct = |how| congruent(&panels, tolerance, how).len();
        Self {
            edge_lengths: distinct_lengths(mesh, tolerance),
            node_angles: by_value(&angles.collect::<Vec<_>>(), angle).len(),
            panels: distinct(Congruence::Turned),
            panels_mirrored: distinct(Congruence::Mirrored),
        }
    }
}

/// What is alike in a mesh, before its edges were made equal and after.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corners = [(0.0, 0.0), (1.0, 0.0), (1.004, 1.0), (0.0, 1.0)];
/// # let places = corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
/// # let quad = HexMesh::new(places, &[[0, 1, 2, 3]])?;
/// use phex::repetition::Repetition;
///
/// // A square of 1 m with a corner that is 4 mm off has one length within 5 mm.
/// let told = Repetition::new(&quad, &quad, 0.005);
/// assert_eq!((told.after.edge_lengths, told.after.panels), (1, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repetition {
    /// Width of the intervals within which lengths are equal, model units.
    pub tolerance: f64,
    /// The same for angles, degrees: the angle under which the tolerance is seen from the other end
    /// of an edge of mean length.
    pub angle_tolerance: f64,
    /// Parts before.
    pub before: DistinctParts,
    /// Parts now.
    pub after: DistinctParts,
}

impl Repetition {
    /// Compares two meshes of the same panels; `tolerance` has their unit.
    pub fn new(before: &HexMesh, after: &HexMesh, tolerance: f64) -> Self {
        let angle = tolerance / before.mean_edge();
        Self {
            tolerance,
            angle_tolerance: angle.to_degrees(),
            before: DistinctParts::of(before, tolerance, angle),
            after: DistinctParts::of(after, tolerance, angle),
        }
    }
}
