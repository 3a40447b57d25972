//! Planarity: the penalty that draws corners into the plane of their face, and the exact
//! constraints.
//!
//! Penalty `w_p / 2 sum_i h_i^2` with gradient `w_p h_i n` (exact, since the plane is the best one)
//! and Gauss-Newton block `w_p P (x) n n^T`, `P = I - A (A^T A)^-1 A^T`, `A = [1 xi eta]`.
//! Constraints `c = Q^T h`, `Q` an orthonormal basis of the complement of `A`: `k - 3` numbers for
//! a `k`-gon.

use crate::optimise::panels::{Corner, FaceFrame, FaceShapes, Panels, add_block};
use crate::optimise::terms::barrier::add_turning;
use nalgebra::Matrix3;
use phex_mesh::{Vec2, Vec3};

/// Entry `(i, j)` of the projector `P`. The axes are principal, so that `A^T A` is diagonal.
pub(super) fn projector(frame: &FaceFrame, corners: &[Corner], i: usize, j: usize) -> f64 {
    let [xx, yy, _] = frame.moments.map(|m| m.max(f64::MIN_POSITIVE));
    let (p, q) = (corners[i].flat, corners[j].flat);
    let identity = f64::from(u8::from(i == j));
    identity - 1.0 / corners.len() as f64 - p.x * q.x / xx - p.y * q.y / yy
}

/// Energy of a face.
pub(in crate::optimise) fn energy(frame: &FaceFrame, weight: f64) -> f64 {
    0.5 * weight * frame.moments[2]
}

/// Adds gradient and Hessian block of a face.
pub(in crate::optimise) fn add(
    frame: &FaceFrame,
    corners: &[Corner],
    weight: f64,
    gradient: &mut [Vec3],
    block: &mut [f64],
) {
    let normal = frame.plane.normal;
    let outer: Matrix3<f64> = normal * normal.transpose() * weight;
    for (i, corner) in corners.iter().enumerate() {
        gradient[i] += normal * (weight * corner.height);
        for j in 0..=i {
            let value = outer * projector(frame, corners, i, j);
            add_block(block, i, j, &value);
        }
    }
}

/// Adds gradient and Hessian block of `sum_i l_i h_i` for multipliers `l` in the range of `P`.
///
/// The gradient is exact; the Hessian `l_i dx_i . dn`, `dn = -sum_k t_k / m_k sum_j xi_jk n .
/// dx_j`, is exact where the face is planar (`m_k` the second moments along the axes `t_k`).
pub(in crate::optimise) fn add_multiplied(
    frame: &FaceFrame,
    corners: &[Corner],
    multipliers: &[f64],
    gradient: &mut [Vec3],
    block: &mut [f64],
) {
    let plane = &frame.plane;
    let mut turning = Vec2::zeros();
    for (i, corner) in corners.iter().enumerate() {
        gradient[i] += plane.normal * multipliers[i];
        turning += corner.flat * multipliers[i];
    }
    add_turning(frame, corners, turning, gradient);
    for k in 0..2 {
        let outer =
            plane.axes[k] * plane.normal.transpose() / -frame.moments[k].max(f64::MIN_POSITIVE);
        for (i, p) in corners.iter().enumerate() {
            for (j, q) in corners[..=i].iter().enumerate() {
                let value = outer * (multipliers[i] * q.flat[k])
                    + outer.transpose() * (multipliers[j] * p.flat[k]);
                add_block(block, i, j, &value);
            }
        }
    }
}

/// Bases `Q` of all faces and the numbers of their constraints.
#[derive(Clone, Debug)]
pub(in crate::optimise) struct ConstraintBases {
    /// First constraint of each face, and one past the last.
    start: Vec<usize>,
    /// `Q`, face after face, constraint after constraint, corner after corner.
    entries: Vec<f64>,
    entry_start: Vec<usize>,
}

impl ConstraintBases {
    pub fn new(panels: &Panels) -> Self {
        let (mut start, mut entry_start) = (vec![0], vec![0]);
        for f in 0..panels.n_faces() {
            let k = panels.valence(f);
            let equations = if panels.rests(f) { 0 } else { k - 3 };
            start.push(start[f] + equations);
            entry_start.push(entry_start[f] + k * equations);
        }
        Self {
            entries: vec![0.0; entry_start[panels.n_faces()]],
            start,
            entry_start,
        }
    }

    pub(crate) fn n_constraints(&self) -> usize {
        self.start[self.start.len() - 1]
    }

    /// Constraints of a face.
    pub fn of_face(&self, face: usize) -> std::ops::Range<usize> {
        self.start[face]..self.start[face + 1]
    }

    /// `Q` of a face: the row of constraint `a` (from 0) over the `k` corners.
    pub fn row(&self, face: usize, a: usize, k: usize) -> &[f64] {
        let at = self.entry_start[face] + a * k;
        &self.entries[at..at + k]
    }

    /// Recomputes the bases for a shape.
    pub(crate) fn update(&mut self, panels: &Panels, shape: &FaceShapes) {
        for f in (0..panels.n_faces()).filter(|f| !panels.rests(*f)) {
            let range = self.entry_start[f]..self.entry_start[f + 1];
            let corners = shape.face(panels, f);
            let rows = &mut self.entries[range];
            orthonormal_complement(&shape.frames[f], corners, rows);
            if panels.has_image(f) {
                fold_rows(panels, f, rows);
            }
        }
    }
}

/// Orthonormal rows that span the range of `P`, by Gram-Schmidt with the largest remaining column
/// of `P` as pivot.
fn orthonormal_complement(frame: &FaceFrame, corners: &[Corner], rows: &mut [f64]) {
    let k = corners.len();
    for a in 0..k - 3 {
        let (done, rest) = rows.split_at_mut(a * k);
        let row = &mut rest[..k];
        let left = |i: usize| {
            let taken: f64 = done.chunks_exact(k).map(|q| q[i] * q[i]).sum();
            projector(frame, corners, i, i) - taken
        };
        // The first of the largest, so that rounding does not decide between equal ones.
        let mut pivot = 0;
        for i in 1..k {
            if left(i) > left(pivot) + 1e-9 {
                pivot = i;
            }
        }
        for (i, entry) in row.iter_mut().enumerate() {
            *entry = projector(frame, corners, i, pivot);
        }
        orthogonalise(frame, corners, done, row);
        orthogonalise(frame, corners, done, row);
    }
}

/// Length below which a row that is left of an orthonormal one counts as none.
const NO_ROW: f64 = 1e-6;

/// Rows of a face that is its own image, as they act on the sources of its corners: heights of
/// images are those of their sources, so rows are averaged over orbits, those that are left are
/// made orthonormal, and the entries of an orbit are added at its source. Rows that come to nothing
/// are zero.
fn fold_rows(panels: &Panels, f: usize, rows: &mut [f64]) {
    let vertices = panels.vertices(f);
    let k = vertices.len();
    let at = |v: u32| vertices.iter().position(|w| *w == panels.source(v));
    let source: Vec<usize> = (0..k).map(|i| at(vertices[i]).unwrap_or(i)).collect();
    let mut size = vec![0.0; k];
    source.iter().for_each(|s| size[*s] += 1.0);
    for a in 0..rows.len() / k {
        let (done, rest) = rows.split_at_mut(a * k);
        let row = &mut rest[..k];
        let mut mean = vec![0.0; k];
        (0..k).for_each(|i| mean[source[i]] += row[i] / size[source[i]]);
        (0..k).for_each(|i| row[i] = mean[source[i]]);
        for _ in 0..2 {
            for q in done.chunks_exact(k) {
                let along: f64 = q.iter().zip(&*row).map(|(q, r)| q * r).sum();
                row.iter_mut().zip(q).for_each(|(r, q)| *r -= along * q);
            }
        }
        let length = row.iter().map(|r| r * r).sum::<f64>().sqrt();
        let scale = if length > NO_ROW { 1.0 / length } else { 0.0 };
        row.iter_mut().for_each(|r| *r *= scale);
    }
    for row in rows.chunks_exact_mut(k) {
        for i in 0..k {
            row[i] = if source[i] == i {
                row[i] * size[i]
            } else {
                0.0
            };
        }
    }
}

/// Removes the parts of `row` along `1`, `xi`, `eta` and the rows that are done, and normalises it.
fn orthogonalise(frame: &FaceFrame, corners: &[Corner], done: &[f64], row: &mut [f64]) {
    let k = row.len();
    let mean = row.iter().sum::<f64>() / k as f64;
    let [xx, yy, _] = frame.moments.map(|m| m.max(f64::MIN_POSITIVE));
    let x = row
        .iter()
        .zip(corners)
        .map(|(r, c)| r * c.flat.x)
        .sum::<f64>()
        / xx;
    let y = row
        .iter()
        .zip(corners)
        .map(|(r, c)| r * c.flat.y)
        .sum::<f64>()
        / yy;
    for (entry, corner) in row.iter_mut().zip(corners) {
        *entry -= mean + x * corner.flat.x + y * corner.flat.y;
    }
    for q in done.chunks_exact(k) {
        let along: f64 = q.iter().zip(&*row).map(|(q, r)| q * r).sum();
        row.iter_mut().zip(q).for_each(|(r, q)| *r -= along * q);
    }
    let length = row.iter().map(|r| r * r).sum::<f64>().sqrt();
    if length > 0.0 {
        row.iter_mut().for_each(|r| *r /= length);
    }
}
