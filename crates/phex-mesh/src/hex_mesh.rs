//! The polygon mesh that phex makes: positions and half-edge topology, faces of any valence.

use crate::extent::bounds;
use crate::face_lists::numbered;
use crate::ids::{EdgeId, FaceId, VertexId};
use crate::per_element::{PerFace, PerVertex};
use crate::topology::{Topology, TopologyError};
use crate::{PolygonSoup, Vec3};

/// An oriented manifold polygon mesh. That its faces are planar or simple is *not* implied:
/// see `validate` for the type that implies it.
#[derive(Clone, Debug, PartialEq)]
pub struct HexMesh {
    /// Position of each vertex.
    pub positions: PerVertex<Vec3>,
    topology: Topology,
}

impl HexMesh {
    /// Builds a mesh from positions and faces (vertex numbers from 0, counter-clockwise).
    ///
    /// ```
    /// use phex_mesh::{HexMesh, Vec3};
    ///
    /// // A unit cube, its faces counter-clockwise from outside.
    /// let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    /// let faces = [
    ///     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
    /// ];
    /// let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
    /// assert_eq!(cube.topology().euler_characteristic(), 2);
    /// assert_eq!(cube.mean_edge(), 1.0);
    /// # Ok::<(), phex_mesh::TopologyError>(())
    /// ```
    ///
    /// # Errors
    /// If the faces are not an oriented manifold that uses every vertex.
    pub fn new<F: AsRef<[u32]>>(positions: Vec<Vec3>, faces: &[F]) -> Result<Self, TopologyError> {
        let topology = Topology::from_faces(positions.len(), faces)?;
        Ok(Self {
            positions: PerVertex::from_vec(positions),
            topology,
        })
    }

    /// The connectivity.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The same connectivity with other positions.
    ///
    /// # Panics
    /// If the number of positions differs.
    pub fn with_positions(&self, positions: PerVertex<Vec3>) -> Self {
        assert_eq!(
            positions.len(),
            self.positions.len(),
            "one position per vertex"
        );
        Self {
            positions,
            topology: self.topology.clone(),
        }
    }

    /// The same connectivity with every vertex moved by a map.
    pub fn mapped(&self, place: impl Fn(&Vec3) -> Vec3) -> Self {
        self.with_positions(self.positions.map(place))
    }

    /// The mesh with all faces turned over: the same vertices and faces, each the other way round.
    ///
    /// ```
    /// use phex_mesh::{FaceId, HexMesh, Vec3};
    ///
    /// let corners = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
    /// let triangle = HexMesh::new(corners, &[[0, 1, 2]])?;
    /// let numbers = triangle.turned_over().topology().face_lists();
    /// assert_eq!(numbers, [[2, 1, 0]]);
    /// # Ok::<(), phex_mesh::TopologyError>(())
    /// ```
    ///
    /// # Panics
    /// Never: the other side of an oriented manifold is one, too.
    pub fn turned_over(&self) -> Self {
        let mut faces = self.topology.face_lists();
        faces.iter_mut().for_each(|f| f.reverse());
        let turned = Self::new(self.positions.as_slice().to_vec(), &faces);
        turned.expect("the other side of a manifold is one, too")
    }

    /// Some of the faces alone, with their vertices numbered in the order of use.
    ///
    /// # Errors
    /// If they are joined in single vertices.
    pub fn part(&self, faces: &[FaceId]) -> Result<Self, TopologyError> {
        let outlines = faces.iter().map(|f| self.topology.face_vertices(*f));
        let (vertices, outlines) = numbered(outlines.map(|o| o.iter().copied()));
        let places = vertices.iter().map(|v| self.positions[*v]);
        Self::new(places.collect(), &outlines)
    }

    /// Corner positions of a face, counter-clockwise.
    pub fn corners(&self, f: FaceId) -> impl ExactSizeIterator<Item = Vec3> + '_ {
        self.topology
            .face_vertices(f)
            .iter()
            .map(|&v| self.positions[v])
    }

    /// Mean of a face's corners.
    pub fn centre(&self, f: FaceId) -> Vec3 {
        self.corners(f).sum::<Vec3>() / self.topology.valence(f) as f64
    }

    /// Means of the corners of all faces.
    pub fn centres(&self) -> PerFace<Vec3> {
        PerFace::from_fn(self.topology.n_faces(), |f| self.centre(f))
    }

    /// From the first end of an edge to the second.
    pub fn edge_vector(&self, e: EdgeId) -> Vec3 {
        let [a, b] = self.topology.edge_vertices(e);
        self.positions[b] - self.positions[a]
    }

    /// Length of an edge.
    pub fn edge_length(&self, e: EdgeId) -> f64 {
        self.edge_vector(e).norm()
    }

    /// Mean length of all edges, the unit of every relative length.
    pub fn mean_edge(&self) -> f64 {
        let t = &self.topology;
        t.edges().map(|e| self.edge_length(e)).sum::<f64>() / t.n_edges() as f64
    }

    /// Mean length of the edges between two faces, of all edges where there are none: those at the
    /// boundary are as long as it cuts them.
    pub fn mean_inner_edge(&self) -> f64 {
        let inner = self.topology.inner_edges();
        let (sum, count) = inner.fold((0.0, 0), |(sum, count), e| {
            (sum + self.edge_length(e), count + 1)
        });
        match count {
            0 => self.mean_edge(),
            count => sum / f64::from(count),
        }
    }

    /// Diagonal of the bounding box of the vertices.
    pub fn diagonal(&self) -> f64 {
        let [low, high] = bounds(&self.positions);
        (high - low).norm()
    }

    /// Mean of the unit normals of the faces at a vertex, normalised; 0 where they cancel out.
    pub fn mean_normal(&self, v: VertexId) -> Vec3 {
        let normal = |f| self.area_vector(f).try_normalize(0.0).unwrap_or_default();
        let faces = self.topology.faces_at(v);
        let sum: Vec3 = faces.map(normal).sum();
        sum.try_normalize(1e-12).unwrap_or_default()
    }

    /// Twice the area vector of a face.
    pub fn area_vector(&self, f: FaceId) -> Vec3 {
        let corners: Vec<Vec3> = self.corners(f).collect();
        let shifted = |i: usize| corners[i % corners.len()] - corners[0];
        let sides = 1..corners.len();
        sides.map(|i| shifted(i).cross(&shifted(i + 1))).sum()
    }

    /// Position of a vertex.
    pub fn position(&self, v: VertexId) -> Vec3 {
        self.positions[v]
    }

    /// Positions and face lists, for writing.
    pub fn to_soup(&self) -> PolygonSoup {
        PolygonSoup {
            positions: self.positions.as_slice().to_vec(),
            faces: self.topology.face_lists(),
        }
    }
}
