//! Beams along the edges between two layers, with torsion-free nodes.
//!
//! Where an edge and its offset are parallel, they span a plane that holds the node axes at both
//! ends: the beam's plane of symmetry. All beams at a node share the node's axis, so that the node
//! is free of torsion.

use super::OffsetError;
use phex_mesh::{EdgeId, HexMesh, Vec3, VertexId};

/// The axis of a node: from a vertex of the lower layer to the same vertex of the upper one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeAxis {
    /// The vertex.
    pub vertex: VertexId,
    /// Where it is in the lower layer.
    pub base: Vec3,
    /// Unit vector towards the upper layer; zero if the layers meet there.
    pub direction: Vec3,
    /// Distance of the layers there, in model units.
    pub length: f64,
}

/// The axis of a beam: an edge of the lower layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamAxis {
    /// The edge.
    pub edge: EdgeId,
    /// Its vertices.
    pub vertices: [VertexId; 2],
    /// Its ends in the lower layer.
    pub ends: [Vec3; 2],
    /// Unit normal of the plane that the edge and its offset span.
    pub plane_normal: Vec3,
    /// Angle between the node axes out of that plane, in radians: 0 for a beam without torsion.
    pub torsion: f64,
}

/// The node axes between two layers, by vertex.
///
/// # Errors
/// If the connectivity differs.
pub fn node_axes(lower: &HexMesh, upper: &HexMesh) -> Result<Vec<NodeAxis>, OffsetError> {
    if lower.topology() != upper.topology() {
        return Err(OffsetError::Connectivity);
    }
    let axis = |vertex| {
        let base = lower.position(vertex);
        let d = upper.position(vertex) - base;
        NodeAxis {
            vertex,
            base,
            direction: d.try_normalize(0.0).unwrap_or_else(Vec3::zeros),
            length: d.norm(),
        }
    };
    Ok(lower.topology().vertices().map(axis).collect())
}

/// The beams between two layers, by edge.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::offset::{OffsetOptions, beam_axes, face_gauss_image, layer};
///
/// let options = OffsetOptions::default();
/// let image = face_gauss_image(&cube, &options)?;
/// let outer = layer(&cube, &image, 0.1, &options)?;
/// assert_eq!(beam_axes(&cube, &outer)?.len(), 12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the connectivity differs.
pub fn beam_axes(lower: &HexMesh, upper: &HexMesh) -> Result<Vec<BeamAxis>, OffsetError> {
    let nodes = node_axes(lower, upper)?;
    let topology = lower.topology();
    let beam = |edge| {
        let vertices = topology.edge_vertices(edge);
        let axes = vertices.map(|v| nodes[v.index()].direction);
        let ends = vertices.map(|v| lower.position(v));
        let along = (ends[1] - ends[0]).normalize();
        let across = axes.map(|axis| along.cross(&axis));
        let mean = across[0] + across[1];
        BeamAxis {
            edge,
            vertices,
            ends,
            plane_normal: mean.try_normalize(0.0).unwrap_or_else(Vec3::zeros),
            torsion: across[0]
                .cross(&across[1])
                .norm()
                .atan2(across[0].dot(&across[1])),
        }
    };
    Ok(topology.edges().map(beam).collect())
}
