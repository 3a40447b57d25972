//! Closing equations: reflections along the edges of a walk must bring its start back.
//!
//! ```text
//! R x = x,   R = H_n ... H_2 H_1,   H = I - 2 e e^T for each edge e of a closed walk from the root
//! ```
//!
//! with the image `x` of the root on the unit sphere, chosen once. Even faces close by their
//! angles. Round an odd face inside `R` is a reflection, and `x` must lie in its mirror: one
//! equation. Round a loop that is no face (of an annulus, a torus) it is a rotation, whose axis `x`
//! must be, or with an odd number of edges a rotation and a reflection, whose mirror must then hold
//! `x`: two equations either way. Odd faces at the boundary leave an edge free and need none.

use super::walks::{Walk, Walks};
use crate::optimise::panels::{FaceShapes, Panels, point};
use nalgebra::{Matrix3, SymmetricEigen};
use phex_mesh::Vec3;

/// Mean square of what fails to close below which a start counts as closing.
const CLOSES: f64 = 1e-18;
/// Cosine to the start that faces the normals best, from which on one that closes is as good.
const AS_GOOD: f64 = 0.99;

/// Mean square of what fails to close that weighs as much as facing the normals.
const SOFT: f64 = 1e-2;

/// The closing equations of a mesh in one piece.
#[derive(Clone, Debug)]
pub(in crate::optimise) struct Closing<'a> {
    walks: &'a Walks,
    start: Vec3,
    /// Derivatives, vertex after vertex, in the order of [`Walks::at`].
    rows: Vec<Vec3>,
    values: Vec<f64>,
}

/// One step of a walk.
struct WalkStep {
    from: usize,
    to: usize,
    along: Vec3,
    length: f64,
    /// The image before the step.
    before: Vec3,
}

impl<'a> Closing<'a> {
    pub fn new(walks: &'a Walks, panels: &Panels, shape: &FaceShapes, x: &[f64]) -> Self {
        Self {
            start: best_start(walks, panels, shape, x),
            rows: vec![Vec3::zeros(); walks.n_places()],
            values: vec![0.0; walks.n_equations()],
            walks,
        }
    }

    /// Largest failure to close, over the number of reflections: as it were, that of one
    /// reflection.
    pub fn defect(&self, x: &[f64]) -> f64 {
        let of_walk = |walk: &Walk| self.gap(walk, x).norm() / walk.n_steps() as f64;
        self.walks.walks.iter().map(of_walk).fold(0.0, f64::max)
    }

    /// From the start to where a walk brings it.
    fn gap(&self, walk: &Walk, x: &[f64]) -> Vec3 {
        reflected_along(walk, x, self.start) - self.start
    }

    /// What fails to close, by the last [`linearise`](Self::linearise).
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Derivatives by a vertex of the equations [`Walks::at`] it.
    pub(crate) fn rows_at(&self, vertex: usize) -> &[Vec3] {
        &self.rows[self.walks.places(vertex)]
    }

    /// Derivative of an equation by a vertex of its walk.
    pub fn row(&self, vertex: usize, equation: usize) -> &Vec3 {
        &self.rows[self.walks.place(vertex, equation)]
    }

    /// All walks.
    pub(crate) fn walks(&self) -> &'a Walks {
        self.walks
    }

    /// Sum of the squares of what fails to close at `x`.
    pub fn squares(&self, x: &[f64]) -> f64 {
        let of_walk = |walk: &Walk| {
            let gap = self.gap(walk, x);
            let along = |d: Vec3| d.dot(&gap).powi(2);
            self.directions(walk, x).into_iter().map(along).sum::<f64>()
        };
        self.walks.walks.iter().map(of_walk).sum()
    }

    /// Numbers of the equations at a vertex.
    pub fn at(&self, vertex: usize) -> &[u32] {
        self.walks.at(vertex)
    }

    /// Values and derivatives at `x`, times `unit`.
    pub fn linearise(&mut self, x: &[f64], unit: f64) {
        self.rows.fill(Vec3::zeros());
        let walks = self.walks;
        for walk in &walks.walks {
            let mut steps = Vec::with_capacity(walk.n_steps());
            let mut image = self.start;
            for ends in walk.steps() {
                steps.push(WalkStep::new(x, ends, image));
                image = reflected(x, ends, image);
            }
            let gap = image - self.start;
            for (k, direction) in self.directions(walk, x).into_iter().enumerate() {
                let equation = walk.first + k;
                self.values[equation] = unit * direction.dot(&gap);
                self.add_derivatives(equation, &steps, direction * unit);
            }
        }
    }

    /// Unit vectors along which a walk can fail to close: the mirror's normal, or all that are
    /// perpendicular to the start.
    fn directions(&self, walk: &Walk, x: &[f64]) -> Vec<Vec3> {
        if walk.is_mirror() {
            vec![mirror_normal(&product(walk, x)) * 0.5]
        } else {
            let axis = Vec3::ith(self.start.iamin(), 1.0);
            let first = self.start.cross(&axis).normalize();
            vec![first, self.start.cross(&first)]
        }
    }

    /// Backwards along the walk with the adjoint `y`: `d(y . H s) = -2 de . (y (e . s) + s (y .
    /// e))`.
    fn add_derivatives(&mut self, equation: usize, steps: &[WalkStep], direction: Vec3) {
        let mut y = direction;
        for step in steps.iter().rev() {
            let (e, s) = (&step.along, &step.before);
            let by_direction = (y * e.dot(s) + s * y.dot(e)) * (-2.0 / step.length);
            let by_end = by_direction - e * e.dot(&by_direction);
            self.rows[self.walks.place(step.to, equation)] += by_end;
            self.rows[self.walks.place(step.from, equation)] -= by_end;
            y -= e * (2.0 * e.dot(&y));
        }
    }
}

impl WalkStep {
    fn new(x: &[f64], [from, to]: [u32; 2], before: Vec3) -> Self {
        let (from, to) = (from as usize, to as usize);
        let edge = point(x, to) - point(x, from);
        let length = edge.norm();
        Self {
            from,
            to,
            along: edge / length,
            length,
            before,
        }
    }
}

fn reflected(x: &[f64], [from, to]: [u32; 2], image: Vec3) -> Vec3 {
    let e = (point(x, to as usize) - point(x, from as usize)).normalize();
    image - e * (2.0 * e.dot(&image))
}

/// An image reflected along all of a walk.
fn reflected_along(walk: &Walk, x: &[f64], image: Vec3) -> Vec3 {
    walk.steps().fold(image, |s, ends| reflected(x, ends, s))
}

/// The product of the reflections along a walk.
fn product(walk: &Walk, x: &[f64]) -> Matrix3<f64> {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    Matrix3::from_columns(&axes.map(|axis| reflected_along(walk, x, axis)))
}

/// The unit vector `m` of a reflection `I - 2 m m^T`.
fn mirror_normal(reflection: &Matrix3<f64>) -> Vec3 {
    let doubled = Matrix3::identity() - (reflection + reflection.transpose()) * 0.5;
    let largest = doubled.diagonal().imax();
    doubled.column(largest).normalize()
}

/// The unit vector that faces the normals best when it is reflected to all vertices and nearly
/// closes or, if about as good, one that closes.
fn best_start(walks: &Walks, panels: &Panels, shape: &FaceShapes, x: &[f64]) -> Vec3 {
    let mut products = vec![Matrix3::identity(); panels.n_vertices()];
    for &[from, to] in &walks.tree {
        let e = (point(x, to as usize) - point(x, from as usize)).normalize();
        let before = products[from as usize];
        products[to as usize] = before - e * (e.transpose() * before) * 2.0;
    }
    let normal = |v: usize| -> Vec3 {
        let faces = panels.corners_at(v).iter().map(|&c| panels.face_of(c));
        faces.map(|f| shape.normal(f)).sum()
    };
    let facing: Vec3 = products
        .iter()
        .enumerate()
        .map(|(v, r)| r.tr_mul(&normal(v)))
        .sum();
    let facing = facing.try_normalize(0.0).unwrap_or_else(Vec3::z);
    let gaps = walks
        .walks
        .iter()
        .map(|w| product(w, x) - Matrix3::identity());
    let squares: Matrix3<f64> = gaps.map(|gap| gap.tr_mul(&gap)).sum();
    let eigen = SymmetricEigen::new(squares / walks.walks.len().max(1) as f64);
    let closing: Vec3 = (0..3)
        .filter(|&k| eigen.eigenvalues[k] <= CLOSES)
        .map(|k| eigen.eigenvectors.column(k).into_owned())
        .map(|axis| axis * axis.dot(&facing))
        .sum();
    let mean = squares / (SOFT * walks.walks.len().max(1) as f64);
    let softened = (mean + Matrix3::identity())
        .try_inverse()
        .and_then(|soft| (soft * facing).try_normalize(0.0));
    closing
        .try_normalize(AS_GOOD)
        .unwrap_or(softened.unwrap_or(facing))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::panels::unknowns;
    use phex_mesh::HexMesh;

    /// A dodecahedron of sorts: twelve odd faces, none planar.
    fn bent() -> HexMesh {
        let faces: [[u32; 5]; 12] = [
            [0, 1, 2, 3, 4],
            [0, 5, 10, 6, 1],
            [1, 6, 11, 7, 2],
            [2, 7, 12, 8, 3],
            [3, 8, 13, 9, 4],
            [4, 9, 14, 5, 0],
            [15, 16, 10, 5, 14],
            [16, 17, 11, 6, 10],
            [17, 18, 12, 7, 11],
            [18, 19, 13, 8, 12],
            [19, 15, 14, 9, 13],
            [19, 18, 17, 16, 15],
        ];
        let ring = |k: usize, radius: f64, z: f64| {
            let t = std::f64::consts::TAU * (k as f64) / 5.0;
            Vec3::new(
                radius * t.cos(),
                radius * t.sin(),
                z + 0.02 * (3.0 * t).sin(),
            )
        };
        let place = |k: usize| match k {
            0..5 => ring(k, 0.6, 0.8),
            5..10 => ring(k - 5, 1.0, 0.2),
            10..15 => ring(k - 10, 1.0, -0.2) + Vec3::new(0.1, -0.05, 0.0),
            _ => ring(k - 15, 0.6, -0.8),
        };
        HexMesh::new((0..20).map(place).collect(), &faces).unwrap()
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let mesh = bent();
        let (panels, walks) = (Panels::new(mesh.topology()), Walks::of(&mesh));
        assert_eq!(walks.n_equations(), 12);
        let x = unknowns(&mesh);
        let mut closing = Closing::new(&walks, &panels, &FaceShapes::at(&panels, &x), &x);
        closing.linearise(&x, 1.0);
        let directions: Vec<Vec3> = walks
            .walks
            .iter()
            .map(|w| closing.directions(w, &x)[0])
            .collect();
        let value = |equation: usize, x: &[f64]| {
            let steps = walks.walks[equation].steps();
            let end = steps.fold(closing.start, |s, ends| reflected(x, ends, s));
            directions[equation].dot(&(end - closing.start))
        };
        let h = 1e-6;
        let mut seen = 0;
        for v in 0..panels.n_vertices() {
            for (&equation, row) in closing.at(v).iter().zip(closing.rows_at(v)) {
                for k in 0..3 {
                    let at = |step: f64| {
                        let mut moved = x.clone();
                        moved[3 * v + k] += step;
                        value(equation as usize, &moved)
                    };
                    let slope = (at(h) - at(-h)) / (2.0 * h);
                    assert!(
                        (slope - row[k]).abs() < 1e-8,
                        "vertex {v}, equation {equation}: {slope} {row}"
                    );
                    seen += 1;
                }
            }
        }
        assert!(seen > 200 && closing.values().iter().any(|c| c.abs() > 1e-3));
    }
}
