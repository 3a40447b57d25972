//! The linear space of the meshes that are parallel to a planar mesh.
//!
//! A mesh parallel to `M` has the same edge directions `d_e`; its edge lengths `l_e`, which may be
//! negative, are the unknowns. The edges of every face must close,
//!
//! ```text
//! sum_(e in f) +- l_e d_e = 0         two equations in the plane of the face,
//! ```
//!
//! and so must one loop (three equations) per generator of the homology of an annulus or a surface
//! of higher genus. Source: Pottmann, Liu, Wallner, Bobenko, Wang, "Geometry of multi-layer
//! freeform structures for architecture" (2007), section 3.
//!
//! | symbol | here |
//! |---|---|
//! | `d_e` | [`ParallelSpace::direction`] |
//! | `l_e` | the lengths that [`ParallelSpace::project_lengths`] takes and gives |
//! | closure matrix | `closure`, two rows per face and three per generator |
//! | positions parallel to `M` | `parallelism`, two rows per edge |
//!
//! *Guaranteed*: the rank is decided by singular values accurate to rounding, and the gap between
//! those that count as zero and the others is told; projections are orthogonal, and closed
//! (parallel) to rounding. On a closed mesh with vertices of degree 3 the dimension is the number
//! of faces less 3, and [`ParallelSpace::plane_shift`] spans the space. [`ParallelSpace::basis`] is
//! a sparse basis for any mesh.
//!
//! *Fails* for a face that is not planar or an edge of length zero; both are named.

use super::null_space::{NullSpace, Rank, Rows};
use phex_mesh::{
    Cotree, EdgeId, FaceId, FacePlane, ForestStep, HalfEdgeId, HexMesh, PerEdge, PerFace,
    PerVertex, Topology, Vec3, VertexId, spanning_forest,
};
use phex_numeric::NumericError;
use thiserror::Error;

/// Largest height of a vertex over the plane of its face, over the length of the mean edge.
const PLANARITY: f64 = 1e-7;

/// Singular values of the closure matrix, whose entries are cosines, that count as zero.
const RANK_TOLERANCE: f64 = 1e-8;

/// Cosine between the normal of a face and an edge that leaves it, below which shifting the plane
/// moves the vertex too far.
const LEAST_COSINE: f64 = 1e-6;

/// Why there is no space of parallel meshes.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParallelError {
    /// A face is not planar.
    #[error(
        "face {face} is not planar: a vertex stands off its plane by {height:.1e} mean edges (at most {PLANARITY:.0e})"
    )]
    NotPlanar {
        /// The face.
        face: FaceId,
        /// Largest height over its plane, in mean edges.
        height: f64,
    },
    /// An edge has no direction.
    #[error("edge {edge} between vertices {} and {} has length zero", vertices[0], vertices[1])]
    NoDirection {
        /// The edge.
        edge: EdgeId,
        /// Its ends.
        vertices: [VertexId; 2],
    },
    /// The equations could not be solved.
    #[error("the equations of the parallel meshes could not be solved: {0}")]
    Numeric(#[from] NumericError),
}

/// Meshes parallel to a given one.
#[derive(Debug)]
pub struct ParallelSpace {
    mesh: HexMesh,
    directions: PerEdge<Vec3>,
    normals: PerFace<Vec3>,
    closure: NullSpace,
    parallelism: NullSpace,
    /// Every vertex but the roots with the half-edge (towards or away from it) that reaches it, in
    /// the order of a tour.
    tour: Vec<ForestStep>,
}

impl ParallelSpace {
    /// The meshes parallel to `mesh`.
    ///
    /// ```
    /// # use phex_mesh::{HexMesh, Vec3};
    /// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    /// # let faces = [
    /// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
    /// # ];
    /// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
    /// use phex::offset::ParallelSpace;
    ///
    /// // Boxes: length, width and height are free.
    /// assert_eq!(ParallelSpace::new(&cube)?.dimension(), 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a face is not planar or an edge has length zero.
    pub fn new(mesh: &HexMesh) -> Result<Self, ParallelError> {
        let t = mesh.topology();
        let directions = directions(mesh)?;
        let planes = planes(mesh)?;
        let tour = spanning_forest(t, t.vertices(), |_| true);
        let closure = NullSpace::new(closure_rows(t, &directions, &planes, &tour))?;
        let parallelism = NullSpace::new(parallelism_rows(t, &directions))?;
        Ok(Self {
            mesh: mesh.clone(),
            directions,
            normals: planes.map(|p| p.normal),
            closure,
            parallelism,
            tour,
        })
    }

    /// The mesh that all others are parallel to.
    pub fn mesh(&self) -> &HexMesh {
        &self.mesh
    }

    /// Unit direction of an edge, from the first of its vertices to the second.
    pub fn direction(&self, e: EdgeId) -> Vec3 {
        self.directions[e]
    }

    /// Unit normal of a face of the given mesh.
    pub fn normal(&self, f: FaceId) -> Vec3 {
        self.normals[f]
    }

    /// Two rows per face, and those of the generators, in the lengths of the edges.
    pub(super) fn closure_rows(&self) -> &Rows {
        &self.closure.rows
    }

    /// Two rows per edge: the components of `x_b - x_a` perpendicular to it, in the coordinates of
    /// the vertices.
    pub(super) fn parallelism_rows(&self) -> &Rows {
        &self.parallelism.rows
    }

    /// Rank of the closure equations.
    pub fn rank(&self) -> Rank {
        self.closure.rank(RANK_TOLERANCE)
    }

    /// Dimension of the space, translations not counted.
    pub fn dimension(&self) -> usize {
        self.directions.len() - self.rank().rank
    }

    /// Lengths of the edges of a parallel mesh; negative where an edge points the other way.
    pub fn lengths(&self, mesh: &HexMesh) -> PerEdge<f64> {
        PerEdge::from_fn(self.directions.len(), |e| {
            mesh.edge_vector(e).dot(&self.directions[e])
        })
    }

    /// The closest lengths that close.
    pub fn project_lengths(&self, wish: &PerEdge<f64>) -> PerEdge<f64> {
        let mut lengths = wish.clone();
        self.closure.project(lengths.as_mut_slice());
        lengths
    }

    /// How far lengths are from closing: the largest gap of a face or generator.
    pub fn closure_defect(&self, lengths: &PerEdge<f64>) -> f64 {
        let defects = self.closure.rows.mul(lengths.as_slice());
        defects.iter().fold(0.0, |m, d| d.abs().max(m))
    }

    /// The mesh with given lengths, each component where its first vertex was. Lengths that do not
    /// close are projected first.
    pub fn mesh_with_lengths(&self, lengths: &PerEdge<f64>) -> HexMesh {
        let lengths = self.project_lengths(lengths);
        let mut positions = self.mesh.positions.clone();
        for step in &self.tour {
            let along = self.directions[step.edge] * lengths[step.edge];
            let along = (self.mesh.topology()).away_from(step.from, step.edge, along);
            positions[step.to] = positions[step.from] + along;
        }
        self.closest(&positions)
    }

    /// The parallel mesh whose vertices are closest, in the sense of least squares, to given
    /// positions.
    pub fn closest(&self, wish: &PerVertex<Vec3>) -> HexMesh {
        let mut x: Vec<f64> = wish.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        self.parallelism.project(&mut x);
        let positions = x.chunks_exact(3).map(Vec3::from_column_slice);
        self.mesh
            .with_positions(PerVertex::from_vec(positions.collect()))
    }

    /// Change of the edge lengths when the plane of a face moves by 1 along its normal and all
    /// others stay. `None` unless every corner is inside the mesh, has degree 3, and its third edge
    /// leaves the plane.
    pub fn plane_shift(&self, f: FaceId) -> Option<Vec<(EdgeId, f64)>> {
        let t = self.mesh.topology();
        let corners: Vec<HalfEdgeId> = t.face_half_edges(f).collect();
        let moves: Option<Vec<(EdgeId, f64, Vec3)>> =
            corners.iter().map(|&h| self.corner_shift(h)).collect();
        let moves = moves?;
        let mut changes: Vec<(EdgeId, f64)> = moves.iter().map(|m| (m.0, m.1)).collect();
        for (i, &h) in corners.iter().enumerate() {
            let along = moves[(i + 1) % corners.len()].2 - moves[i].2;
            let change = along.dot(&self.directions[t.edge(h)]);
            changes.push((t.edge(h), t.along(h, change)));
        }
        Some(changes)
    }

    /// The third edge at the corner of a half-edge, its change of length, and the movement of the
    /// vertex when the plane moves.
    fn corner_shift(&self, h: HalfEdgeId) -> Option<(EdgeId, f64, Vec3)> {
        let t = self.mesh.topology();
        let v = t.origin(h);
        if t.is_boundary_vertex(v) || t.face_degree(v) != 3 {
            return None;
        }
        let in_face = [t.edge(h), t.edge(t.prev(h))];
        let spoke = t
            .outgoing(v)
            .map(|o| t.edge(o))
            .find(|e| !in_face.contains(e))?;
        let away = t.away_from(v, spoke, self.directions[spoke]);
        let cosine = away.dot(&self.normals[t.face(h)]);
        (cosine.abs() > LEAST_COSINE).then(|| (spoke, -1.0 / cosine, away / cosine))
    }
}

fn directions(mesh: &HexMesh) -> Result<PerEdge<Vec3>, ParallelError> {
    let t = mesh.topology();
    let direction = |e| {
        let vertices = t.edge_vertices(e);
        let along = mesh.edge_vector(e).try_normalize(0.0);
        along.ok_or(ParallelError::NoDirection { edge: e, vertices })
    };
    Ok(PerEdge::from_vec(
        t.edges().map(direction).collect::<Result<_, _>>()?,
    ))
}

fn planes(mesh: &HexMesh) -> Result<PerFace<FacePlane>, ParallelError> {
    let mean_edge = mesh.mean_edge();
    let plane = |f| {
        let corners: Vec<Vec3> = mesh.corners(f).collect();
        let plane = FacePlane::fit(&corners);
        let height = corners
            .iter()
            .map(|&p| plane.height(p).abs())
            .fold(0.0, f64::max)
            / mean_edge;
        if height > PLANARITY {
            return Err(ParallelError::NotPlanar { face: f, height });
        }
        Ok(plane)
    };
    Ok(PerFace::from_vec(
        mesh.topology()
            .faces()
            .map(plane)
            .collect::<Result<_, _>>()?,
    ))
}

fn closure_rows(
    t: &Topology,
    directions: &PerEdge<Vec3>,
    planes: &PerFace<FacePlane>,
    tour: &[ForestStep],
) -> Rows {
    let mut rows = Rows::new(t.n_edges());
    for f in t.faces() {
        for axis in planes[f].axes {
            let entry = |h| {
                let e = t.edge(h);
                (e.index(), t.along(h, axis.dot(&directions[e])))
            };
            rows.push(t.face_half_edges(f).map(entry));
        }
    }
    let reached_by = reached_by(t, tour);
    for e in generators(t, tour) {
        let path = loop_through(t, &reached_by, e);
        for k in 0..3 {
            rows.push(
                path.iter()
                    .map(|&(e, sign)| (e.index(), sign * directions[e][k])),
            );
        }
    }
    rows
}

fn reached_by(t: &Topology, tour: &[ForestStep]) -> PerVertex<Option<ForestStep>> {
    let mut reached_by = PerVertex::filled(t.n_vertices(), None);
    for step in tour {
        reached_by[step.to] = Some(*step);
    }
    reached_by
}

/// Edges that lie neither in the spanning forest nor are crossed by a spanning forest of the faces:
/// one per generator of the homology.
fn generators(t: &Topology, tour: &[ForestStep]) -> Vec<EdgeId> {
    let mut is_used = PerEdge::filled(t.n_edges(), false);
    tour.iter().for_each(|step| is_used[step.edge] = true);
    Cotree::new(t, is_used, []).generators
}

/// The loop of an edge and the paths from the root of the forest to its ends, with signs.
fn loop_through(
    t: &Topology,
    reached_by: &PerVertex<Option<ForestStep>>,
    e: EdgeId,
) -> Vec<(EdgeId, f64)> {
    let [start, end] = t.edge_vertices(e);
    let mut path = vec![(e, 1.0)];
    for (tip, direction) in [(start, 1.0), (end, -1.0)] {
        let mut v = tip;
        while let Some(step) = reached_by[v] {
            path.push((step.edge, t.away_from(step.from, step.edge, direction)));
            v = step.from;
        }
    }
    path
}

fn parallelism_rows(t: &Topology, directions: &PerEdge<Vec3>) -> Rows {
    let mut rows = Rows::new(3 * t.n_vertices());
    for (e, d) in directions.enumerate() {
        let [a, b] = t.edge_vertices(e).map(|v| 3 * v.index());
        for q in perpendicular(d) {
            rows.push((0..3).flat_map(|k| [(b + k, q[k]), (a + k, -q[k])]));
        }
    }
    rows
}

/// Two unit vectors perpendicular to a unit vector and to each other.
fn perpendicular(d: &Vec3) -> [Vec3; 2] {
    let first = d.cross(&Vec3::ith(d.iamin(), 1.0)).normalize();
    [first, d.cross(&first)]
}

#[cfg(test)]
mod tests;
