//! Nouns of phex: meshes and surfaces, and how to measure them. Nothing here changes a shape.
//!
//! | module | what it holds |
//! |---|---|
//! | [`ids`], [`per_element`] | typed `u32` ids and dense maps from them to values |
//! | [`id_map`] | hash maps and sets of ids |
//! | [`Topology`] | half-edge connectivity of an oriented manifold, frozen after building |
//! | [`spanning`] | spanning forests and cotrees of a mesh |
//! | [`plane`] | least-squares plane of a face |
//! | [`surface`] | the triangle surface: building from polygons, closest point with interpolated normal |
//! | [`boundary_curve`] | the boundary loops of a surface, with closest points |
//! | [`hex_mesh`] | the polygon mesh that phex makes |
//! | [`cluster`] | equal lengths and angles, congruent panels |
//! | [`polygon`], [`ear_clip`](mod@ear_clip), [`flat_face`] | planar polygons: exact predicates, triangulation, a face in its plane |
//! | [`LARGEST_COORDINATE`] | how large coordinates may be |
//! | [`surface_from_soup`] | triangle surfaces from faces as they stand in a file |
//! | [`io`] | OBJ, PLY, STL and OFF files; COMPAS JSON, glTF, DXF and 3MF for writing |
//! | [`measure`](mod@measure) | planarity, lengths, angles, clearance, deviation from a surface |
//! | [`PanelLimits`] | what a workshop can make: sheets, edges, corners, joints |
//! | [`validate`](mod@validate) | located violations, and the type that has none |
//! | [`shapes`] | analytic surfaces with closed-form curvature, and their triangulations |

pub mod boundary_curve;
mod clipped;
pub mod cluster;
mod disjoint_sets;
pub mod ear_clip;
mod extent;
mod face_lists;
pub mod flat_face;
pub mod hex_mesh;
pub mod id_map;
pub mod ids;
pub mod io;
pub mod measure;
mod mend;
mod other_elements;
mod panel_limits;
pub mod per_element;
pub mod plane;
pub mod polygon;
mod segment;
pub mod shapes;
pub mod spanning;
pub mod surface;
pub mod surface_from_soup;
mod topology;
pub mod validate;

pub use boundary_curve::{BoundaryCurve, BoundaryPoint};
pub use ear_clip::ear_clip;
pub use extent::{LARGEST_COORDINATE, bounds};
pub use face_lists::{insert_before, numbered, turn_edge};
pub use flat_face::FlatFace;
pub use hex_mesh::HexMesh;
pub use id_map::{IdMap, IdSet};
pub use ids::{EdgeId, ElementId, FaceId, HalfEdgeId, VertexId};
pub use measure::{
    BoundaryFit, Deviation, LEAST_RIM_AREA, MeshMeasures, Metric, boundary_fit, closest_faces,
    deviation, deviation_beyond, irregular_faces, measure, small_rim_faces,
};
pub use other_elements::OtherElements;
pub use panel_limits::{LimitedFigure, PanelLimit, PanelLimits, ROUNDING, rectangle_fit};
pub use per_element::{PerEdge, PerElement, PerFace, PerHalfEdge, PerVertex};
pub use plane::FacePlane;
pub use segment::volume;
pub use spanning::{Cotree, ForestStep, spanning_forest};
pub use surface::{SurfacePoint, TriangleSurface};
pub use surface_from_soup::{SurfaceComponent, SurfaceError, SurfaceNotes, SurfaceParts};
pub use topology::{Topology, TopologyError};
pub use validate::{
    Invalid, ValidHexMesh, ValidateOptions, Violation, add_flips, validate, violations,
};

/// Points and vectors of space; which of the two is meant follows from the name.
pub type Vec3 = nalgebra::Vector3<f64>;
/// Points and vectors of a plane.
pub type Vec2 = nalgebra::Vector2<f64>;

/// Vertices and faces as they stand in a file: nothing has been checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonSoup {
    /// Positions of the vertices.
    pub positions: Vec<Vec3>,
    /// Vertex numbers (from 0) of each face.
    pub faces: Vec<Vec<u32>>,
}
