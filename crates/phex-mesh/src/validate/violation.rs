//! What can be wrong with a mesh, and where.

use crate::{EdgeId, FaceId, HexMesh, Topology, Vec3, VertexId};
use serde::Serialize;
use std::fmt;

/// What the normal of a flipped face points against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FlipReference {
    /// The mean normal of the faces it shares an edge with.
    Neighbours,
    /// The surface's normal below its centre.
    Surface,
}

/// One located violation. Ids count from 0; relative lengths refer to the mesh's mean edge; angles
/// are in radians.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Violation {
    /// A coordinate is infinite or not a number; nothing else is checked then.
    NotFinite {
        /// The vertex.
        vertex: VertexId,
    },
    /// The face touches or crosses itself in its least-squares plane.
    NotSimple {
        /// The face.
        face: FaceId,
    },
    /// A vertex of the face is too far from the face's least-squares plane.
    NotPlanar {
        /// The face.
        face: FaceId,
        /// Largest distance of its vertices to the plane, relative.
        planarity: f64,
        /// Largest allowed.
        limit: f64,
    },
    /// The edge is too short.
    CollapsedEdge {
        /// The edge.
        edge: EdgeId,
        /// Its ends.
        vertices: [VertexId; 2],
        /// Its length, relative.
        length_rel: f64,
        /// Smallest allowed.
        limit: f64,
    },
    /// A vertex comes too close to an edge of the face that does not hold it.
    SmallClearance {
        /// The face.
        face: FaceId,
        /// The vertex.
        vertex: VertexId,
        /// The edge.
        edge: EdgeId,
        /// Their distance in the face's plane, relative.
        clearance: f64,
        /// Smallest allowed.
        limit: f64,
    },
    /// The face folds back on itself at a corner: its interior angle is almost 0 or 2 pi.
    FoldedCorner {
        /// The face.
        face: FaceId,
        /// The corner.
        vertex: VertexId,
        /// Its interior angle.
        angle: f64,
        /// Smallest allowed distance to 0 and to 2 pi.
        limit: f64,
    },
    /// Seen along the mean normal, the edges at a vertex of degree 3 do not go round exactly once:
    /// its faces overlap.
    WrongFan {
        /// The vertex.
        vertex: VertexId,
        /// The faces there: three, or two at the boundary.
        faces: Vec<FaceId>,
        /// How often the edges go round; 2 is a double cover.
        turns: f64,
    },
    /// The face's normal points the wrong way.
    FlippedFace {
        /// The face.
        face: FaceId,
        /// What it points against.
        against: FlipReference,
    },
    /// The normals on the two sides of an edge differ by more than 90 degrees.
    Fold {
        /// The edge.
        edge: EdgeId,
        /// The faces on its two sides.
        faces: [FaceId; 2],
        /// Angle between their normals.
        angle: f64,
    },
    /// The number of faces at an interior vertex is not three.
    WrongDegree {
        /// The vertex.
        vertex: VertexId,
        /// Its number of faces.
        degree: usize,
    },
    /// The edge passes through the inside of a face that does not hold it, or lies over it: in its
    /// plane, or at the boundary. A face that is there twice names its first edge.
    Crossing {
        /// The edge.
        edge: EdgeId,
        /// Its ends.
        vertices: [VertexId; 2],
        /// The face.
        face: FaceId,
    },
}

impl Violation {
    /// Name of the kind of violation, as serialised.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::NotFinite { .. } => "not_finite",
            Self::NotSimple { .. } => "not_simple",
            Self::NotPlanar { .. } => "not_planar",
            Self::CollapsedEdge { .. } => "collapsed_edge",
            Self::SmallClearance { .. } => "small_clearance",
            Self::FoldedCorner { .. } => "folded_corner",
            Self::WrongFan { .. } => "wrong_fan",
            Self::FlippedFace { .. } => "flipped_face",
            Self::Fold { .. } => "fold",
            Self::WrongDegree { .. } => "wrong_degree",
            Self::Crossing { .. } => "crossing",
        }
    }

    /// Whether the mesh is no panelling at all with it; else it is outside a tolerance: not planar,
    /// too short, too narrow or too sharply folded for what is asked for, and can be made.
    pub fn is_decisive(&self) -> bool {
        !matches!(
            self,
            Self::NotPlanar { .. }
                | Self::CollapsedEdge { .. }
                | Self::SmallClearance { .. }
                | Self::Fold { .. }
        )
    }

    /// The faces that take part: the named ones, and those that hold the named edge or vertex.
    pub fn faces(&self, topology: &Topology) -> Vec<FaceId> {
        match *self {
            Self::NotFinite { vertex }
            | Self::WrongDegree { vertex, .. }
            | Self::WrongFan { vertex, .. } => topology.faces_at(vertex).collect(),
            Self::NotSimple { face }
            | Self::NotPlanar { face, .. }
            | Self::SmallClearance { face, .. }
            | Self::FoldedCorner { face, .. }
            | Self::FlippedFace { face, .. } => vec![face],
            Self::CollapsedEdge { edge, .. } => topology.edge_faces(edge).collect(),
            Self::Fold { faces, .. } => faces.to_vec(),
            Self::Crossing { edge, face, .. } => topology.edge_faces(edge).chain([face]).collect(),
        }
    }

    /// Where to look for it, in model coordinates: at the named vertex, the middle of the named
    /// edge, or the centre of the named face; for a vertex without finite coordinates the mean of
    /// the finite ones round it. `None` if there are none.
    pub fn place(&self, mesh: &HexMesh) -> Option<Vec3> {
        let place = match *self {
            Self::NotFinite { .. } => None,
            Self::NotSimple { face }
            | Self::NotPlanar { face, .. }
            | Self::FlippedFace { face, .. } => Some(mesh.centre(face)),
            Self::SmallClearance { vertex, .. }
            | Self::FoldedCorner { vertex, .. }
            | Self::WrongFan { vertex, .. }
            | Self::WrongDegree { vertex, .. } => Some(mesh.position(vertex)),
            Self::CollapsedEdge { edge, .. }
            | Self::Fold { edge, .. }
            | Self::Crossing { edge, .. } => {
                let [a, b] = (mesh.topology().edge_vertices(edge)).map(|v| mesh.position(v));
                Some((a + b) * 0.5)
            }
        };
        let is_finite = |p: &Vec3| p.iter().all(|x| x.is_finite());
        place.filter(is_finite).or_else(|| {
            let faces = self.faces(mesh.topology());
            let corners = faces.iter().flat_map(|f| mesh.corners(*f));
            let finite: Vec<Vec3> = corners.filter(is_finite).collect();
            (!finite.is_empty()).then(|| finite.iter().sum::<Vec3>() / finite.len() as f64)
        })
    }

    /// How bad it is, to compare violations of one kind; larger is worse.
    pub fn severity(&self) -> f64 {
        match *self {
            Self::NotPlanar { planarity, .. } => planarity,
            Self::CollapsedEdge { length_rel, .. } => -length_rel,
            Self::SmallClearance { clearance, .. } => -clearance,
            Self::FoldedCorner { angle, .. } => -angle.min(std::f64::consts::TAU - angle),
            Self::WrongFan { turns, .. } => (turns - 1.0).abs(),
            Self::Fold { angle, .. } => angle,
            Self::WrongDegree { degree, .. } => degree as f64,
            Self::NotFinite { .. }
            | Self::NotSimple { .. }
            | Self::FlippedFace { .. }
            | Self::Crossing { .. } => 0.0,
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { vertex } => {
                write!(
                    f,
                    "vertex {vertex} has a coordinate that is not a finite number"
                )
            }
            Self::NotSimple { face } => {
                write!(f, "face {face} touches or crosses itself in its plane")
            }
            Self::NotPlanar {
                face,
                planarity,
                limit,
            } => write!(
                f,
                "face {face} is not planar: a vertex is {planarity:.3e} mean edges off its plane (limit {limit:.3e})"
            ),
            // Over a mean of zero.
            Self::CollapsedEdge {
                edge,
                vertices: [a, b],
                length_rel,
                ..
            } if length_rel.is_nan() => write!(
                f,
                "edge {edge} between vertices {a} and {b} has no length, nor has any other one: all lie in one point"
            ),
            Self::CollapsedEdge {
                edge,
                vertices: [a, b],
                length_rel,
                limit,
            } => write!(
                f,
                "edge {edge} between vertices {a} and {b} is {length_rel:.3e} mean edges long (limit {limit})"
            ),
            Self::SmallClearance {
                face,
                vertex,
                edge,
                clearance,
                limit,
            } => write!(
                f,
                "in face {face}, vertex {vertex} is {clearance:.3e} mean edges from edge {edge} (limit {limit})"
            ),
            Self::FoldedCorner {
                face,
                vertex,
                angle,
                limit,
            } => write!(
                f,
                "face {face} folds back at vertex {vertex}: interior angle {:.3e} degrees (limit {:.3e} from 0 and 360)",
                angle.to_degrees(),
                limit.to_degrees()
            ),
            Self::WrongFan {
                vertex,
                faces,
                turns,
            } => {
                let names: Vec<String> = faces.iter().map(ToString::to_string).collect();
                let (last, others) = names.split_last().expect("a fan has faces");
                let others = others.join(", ");
                write!(
                    f,
                    "faces {others} and {last} go round vertex {vertex} {turns:.2} times instead of once"
                )
            }
            Self::FlippedFace {
                face,
                against: FlipReference::Neighbours,
            } => {
                write!(
                    f,
                    "face {face} is flipped: its normal points against those of its neighbours"
                )
            }
            Self::FlippedFace {
                face,
                against: FlipReference::Surface,
            } => {
                write!(
                    f,
                    "face {face} is flipped: its normal points against the surface's"
                )
            }
            Self::Fold {
                edge,
                faces: [a, b],
                angle,
            } => write!(
                f,
                "the mesh folds at edge {edge}: the normals of faces {a} and {b} differ by {:.1} degrees (limit 90)",
                angle.to_degrees()
            ),
            Self::WrongDegree { vertex, degree } => {
                write!(
                    f,
                    "interior vertex {vertex} has {degree} faces instead of 3"
                )
            }
            Self::Crossing {
                edge,
                vertices: [a, b],
                face,
            } => {
                write!(
                    f,
                    "edge {edge} between vertices {a} and {b} passes through face {face}, or lies over it"
                )
            }
        }
    }
}
