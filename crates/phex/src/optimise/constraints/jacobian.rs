//! The planarity constraints linearised, `J = Q^T (x) n^T`, in a metric `W` with a block for each
//! vertex.
//!
//! `S = J W J^T` couples a face with its neighbours alone: `3 F` unknowns for a mesh of hexagons,
//! half as many as the coordinates, and a fraction of their fill-in.

use super::planarity::ConstraintBases;
use crate::optimise::panels::{FaceShapes, Panels, point, put};
use nalgebra::Matrix3;
use phex_mesh::Vec3;
use phex_numeric::{Assembly, SymmetricMatrix};

/// `J` and `W` at the shape that was linearised last.
pub(in crate::optimise) struct Jacobian<'a> {
    panels: &'a Panels,
    /// The unknowns are the constraints, the elements the vertices.
    assembly: &'a Assembly,
    bases: ConstraintBases,
    normals: Vec<Vec3>,
    /// `W`, vertex by vertex.
    pub metric: Vec<Matrix3<f64>>,
    blocks: Vec<f64>,
}

impl<'a> Jacobian<'a> {
    pub fn new(panels: &'a Panels, assembly: &'a Assembly) -> Self {
        Self {
            bases: ConstraintBases::new(panels),
            normals: vec![Vec3::zeros(); panels.n_faces()],
            metric: vec![Matrix3::identity(); panels.n_vertices()],
            blocks: vec![0.0; assembly.n_block_entries()],
            panels,
            assembly,
        }
    }

    /// Takes `J` at a shape and writes the values of the constraints.
    pub fn linearise(&mut self, shape: &FaceShapes, values: &mut [f64]) {
        self.bases.update(self.panels, shape);
        for f in 0..self.panels.n_faces() {
            self.normals[f] = shape.normal(f);
            let corners = shape.face(self.panels, f);
            for (a, i) in self.bases.of_face(f).enumerate() {
                let row = self.bases.row(f, a, corners.len()).iter();
                values[i] = row.zip(corners).map(|(q, c)| q * c.height).sum();
            }
        }
    }

    /// Entries of `Q` of all constraints of a corner's face, at that corner.
    fn entries(&self, corner: u32) -> impl Iterator<Item = f64> + '_ {
        let f = self.panels.face_of(corner);
        let local = corner as usize - self.panels.corners(f).start;
        let k = self.panels.valence(f);
        let equations = self.bases.of_face(f).len();
        (0..equations).map(move |a| self.bases.row(f, a, k)[local])
    }

    /// `S = J W J^T`.
    pub(crate) fn normal_matrix(&mut self, matrix: &mut SymmetricMatrix) {
        let mut blocks = std::mem::take(&mut self.blocks);
        for v in 0..self.panels.n_vertices() {
            let corners = self.panels.corners_at(v);
            let mut at = self.assembly.block(v).start;
            for (m, &c) in corners.iter().enumerate() {
                let weighted = self.metric[v] * self.normals[self.panels.face_of(c)];
                for (a, entry) in self.entries(c).enumerate() {
                    for (l, &d) in corners[..=m].iter().enumerate() {
                        let factor = entry * weighted.dot(&self.normals[self.panels.face_of(d)]);
                        let most = if l == m { a + 1 } else { usize::MAX };
                        for other in self.entries(d).take(most) {
                            blocks[at] = factor * other;
                            at += 1;
                        }
                    }
                }
            }
        }
        self.assembly.assemble(&blocks, matrix);
        self.blocks = blocks;
        // Constraints that a face fulfils by being its own image have no row.
        let rows = (0..self.panels.n_faces()).filter(|f| self.panels.has_image(*f));
        for row in rows.flat_map(|f| self.bases.of_face(f)) {
            let at = matrix.pattern().position(row as u32, row as u32);
            let own = at.map(|at| &mut matrix.values_mut()[at]);
            own.filter(|v| **v == 0.0)
                .into_iter()
                .for_each(|v| *v = 1.0);
        }
    }

    /// `values = J d`.
    pub fn product(&self, d: &[f64], values: &mut [f64]) {
        for f in 0..self.panels.n_faces() {
            let k = self.panels.valence(f);
            let rows = self.bases.of_face(f);
            values[rows.clone()].fill(0.0);
            for (i, &v) in self.panels.vertices(f).iter().enumerate() {
                let height = self.normals[f].dot(&point(d, v as usize));
                for (a, row) in rows.clone().enumerate() {
                    values[row] += self.bases.row(f, a, k)[i] * height;
                }
            }
        }
    }

    /// Adds `Q y` at the corners.
    pub(crate) fn add_at_corners(&self, y: &[f64], corners: &mut [f64]) {
        for f in 0..self.panels.n_faces() {
            let k = self.panels.valence(f);
            let values = &mut corners[self.panels.corners(f)];
            for (a, row) in self.bases.of_face(f).enumerate() {
                let entries = self.bases.row(f, a, k).iter();
                values
                    .iter_mut()
                    .zip(entries)
                    .for_each(|(v, q)| *v += y[row] * q);
            }
        }
    }

    /// Brings values at the corners into the range of `Q`: `l = Q Q^T l`.
    pub(crate) fn keep_to_range(&self, corners: &mut [f64]) {
        let mut y = vec![0.0; self.bases.n_constraints()];
        for f in 0..self.panels.n_faces() {
            let k = self.panels.valence(f);
            let values = &corners[self.panels.corners(f)];
            for (a, row) in self.bases.of_face(f).enumerate() {
                let entries = self.bases.row(f, a, k).iter();
                y[row] = entries.zip(values).map(|(q, v)| q * v).sum();
            }
        }
        corners.fill(0.0);
        self.add_at_corners(&y, corners);
    }

    /// `d = W J^T y`.
    pub fn spread(&self, y: &[f64], d: &mut [f64]) {
        for v in 0..self.panels.n_vertices() {
            let along = |&c: &u32| {
                let f = self.panels.face_of(c);
                let pulls = self.entries(c).zip(&y[self.bases.of_face(f)]);
                self.normals[f] * pulls.map(|(q, y)| q * y).sum::<f64>()
            };
            let sum: Vec3 = self.panels.corners_at(v).iter().map(along).sum();
            let moved = self.metric[v] * sum;
            put(d, v, &moved);
        }
    }
}
