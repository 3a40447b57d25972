//! Why an offset can't be made.

use phex_mesh::{EdgeId, FaceId, VertexId, Violation};
use thiserror::Error;

/// A figure with as many digits as one reads.
fn short(value: f64) -> String {
    match value.abs() {
        size if size >= 1e-2 || size == 0.0 => format!("{value:.2}"),
        _ => format!("{value:.1e}"),
    }
}

/// Why an offset can't be made; names the element and the cause.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OffsetError {
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
    },
    /// More or fewer than three faces meet.
    #[error(
        "{degree} faces meet at vertex {vertex}; offsets need exactly 3 inside and at most 3 on the boundary"
    )]
    WrongDegree {
        /// The vertex.
        vertex: VertexId,
        /// Its number of faces.
        degree: usize,
    },
    /// A face is not planar.
    #[error(
        "face {face} is not planar: {planarity:.3e} mean edges from its plane, at most {limit:.3e} is allowed"
    )]
    NotPlanar {
        /// The face.
        face: FaceId,
        /// Largest distance of its vertices to its plane, in mean edges.
        planarity: f64,
        /// Largest allowed.
        limit: f64,
    },
    /// A face has no area, so that it has no normal.
    #[error("face {face} has no area")]
    NoArea {
        /// The face.
        face: FaceId,
    },
    /// A distance is infinite or not a number.
    #[error("the distance {distance} is not a finite number")]
    Distance {
        /// The distance.
        distance: f64,
    },
    /// The number of distances is not that of the faces.
    #[error("{found} distances were given for {expected} faces")]
    DistanceCount {
        /// Distances given.
        found: usize,
        /// Faces of the mesh.
        expected: usize,
    },
    /// Faces in one plane were given different distances.
    #[error(
        "the faces at vertex {vertex} (almost) lie in one plane but their distances differ: no point is closer than {residual:.3e} to all of their offsets"
    )]
    Incompatible {
        /// The vertex.
        vertex: VertexId,
        /// Distance that remains, in model units.
        residual: f64,
    },
    /// The offset is not a valid mesh.
    #[error("the offset by {distance} is not valid: {first}{}", more(.count))]
    NotValid {
        /// The distance.
        distance: f64,
        /// The first violation.
        first: Box<Violation>,
        /// Number of violations.
        count: usize,
    },
    /// The mesh itself is not valid.
    #[error("the mesh itself is not valid: {first}{}", more(.count))]
    MeshNotValid {
        /// The first violation.
        first: Box<Violation>,
        /// Number of violations.
        count: usize,
    },
    /// A face with an even number of corners does not satisfy the angle condition (4.1).
    #[error(
        "face {face} does not satisfy the angle condition: the sum of every other angle misses a multiple of 180 degrees by {} degrees ({count} faces in all)", short(.defect.to_degrees())
    )]
    AngleCondition {
        /// The face that is farthest from it.
        face: FaceId,
        /// How far, in radians.
        defect: f64,
        /// Faces that do not satisfy it.
        count: usize,
    },
    /// Reflections along the edges do not close up.
    #[error(
        "no spherical mesh is parallel to this one: at edge {edge} the reflections fail to close by {defect:.3e} (loops that are no faces: {loops}; odd faces inside: {odd_faces})"
    )]
    Holonomy {
        /// The edge where they fail most.
        edge: EdgeId,
        /// By how much, on the unit sphere.
        defect: f64,
        /// Independent loops that are not faces.
        loops: usize,
        /// Faces with an odd number of corners that lie inside; each allows only a circle of
        /// starts.
        odd_faces: usize,
    },
    /// No Koebe mesh is parallel to the mesh.
    #[error(
        "no mesh with all edges touching the unit sphere is parallel to this one: edge {edge} between vertices {} and {} would touch it in two points {defect:.3e} apart", vertices[0], vertices[1]
    )]
    NotParallelToKoebe {
        /// The edge where it fails most.
        edge: EdgeId,
        /// Its vertices.
        vertices: [VertexId; 2],
        /// Distance of the touching points that its two ends lead to, on the unit sphere.
        defect: f64,
    },
    /// The mesh has several components.
    #[error("the mesh has {components} components, one is needed")]
    Components {
        /// Their number.
        components: usize,
    },
    /// The gap leaves nothing of a panel, or makes it touch itself.
    #[error(
        "a joint gap of {gap} (model units) is too wide for face {face}; the largest that every panel has room for is {most} (model units)"
    )]
    Gap {
        /// The face.
        face: FaceId,
        /// The gap, in model units.
        gap: f64,
        /// The largest gap that every panel has room for, about; not more.
        most: f64,
    },
    /// The gap is negative, infinite or not a number.
    #[error("the joint gap must be finite and at least 0, not {gap}")]
    BadGap {
        /// The gap, in model units.
        gap: f64,
    },
    /// The panel between two layers has no volume or is turned inside out.
    #[error("the panel of face {face} has the volume {volume:.3e} between these layers")]
    Volume {
        /// The face.
        face: FaceId,
        /// Its volume, in cubed model units.
        volume: f64,
    },
    /// Two meshes should have the same connectivity.
    #[error("the two layers do not have the same connectivity")]
    Connectivity,
}

fn more(count: &usize) -> String {
    match count.saturating_sub(1) {
        0 => String::new(),
        n => format!(" (and {n} more)"),
    }
}
