//! The `4 F` constraints: planarity of every panel, the alternating sum of the angles of even ones,
//! and the closing equations.

use crate::optimise::constraints::guarded::GuardedSteps;
use crate::optimise::constraints::planarity::ConstraintBases;
use crate::optimise::panels::{FaceShapes, Panels, point, put};
use crate::optimise::terms::angle_term::closing::Closing;
use crate::optimise::terms::angle_term::walks::Walks;
use crate::optimise::terms::angle_term::{
    ANGLE_UNIT, alternating_sum, angle_gradient, branches, has_angle,
};
use crate::optimise::terms::setting::Setting;
use nalgebra::Matrix3;
use phex_mesh::Vec3;
use phex_numeric::{Assembly, Constraints, SymmetricMatrix, largest};

/// Planarity of all faces, the angle condition of the even ones, and what odd ones and loops need
/// to close.
pub(super) struct AngleConstraints<'a> {
    setting: &'a Setting<'a>,
    assembly: &'a Assembly,
    bases: ConstraintBases,
    /// First constraint of each face, and one past the last.
    start: Vec<usize>,
    /// First row vector of each face.
    row_start: Vec<usize>,
    /// Derivatives of the constraints of a face, corner after corner, constraint after constraint.
    rows: Vec<Vec3>,
    /// Alternating sum of angles that an even face is to have.
    branch: Vec<Option<f64>>,
    closing: Closing<'a>,
    steps: GuardedSteps<'a>,
    blocks: Vec<f64>,
}

/// Numbers of the constraints of all faces: `k - 3` for planarity, one more for the angles of even
/// faces.
fn constraint_starts(panels: &Panels) -> Vec<usize> {
    let mut start = vec![0];
    for f in 0..panels.n_faces() {
        start.push(start[f] + n_constraints(panels.valence(f)));
    }
    start
}

fn n_constraints(valence: usize) -> usize {
    valence - 3 + usize::from(has_angle(valence))
}

/// The assembly of `J J^T`: an element for each vertex.
pub(super) fn angle_assembly(panels: &Panels, walks: &Walks) -> Assembly {
    let start = constraint_starts(panels);
    let of_faces = start[panels.n_faces()];
    let of_corner = |&c: &u32| {
        let f = panels.face_of(c);
        (start[f]..start[f + 1]).map(|i| i as u32)
    };
    let of_vertex = |v| {
        let closing = walks.at(v).iter().map(|&k| of_faces as u32 + k);
        let faces = panels.corners_at(v).iter().flat_map(of_corner);
        faces.chain(closing).collect()
    };
    let elements: Vec<Vec<u32>> = (0..panels.n_vertices()).map(of_vertex).collect();
    Assembly::new(of_faces + walks.n_equations(), &elements)
}

impl<'a> AngleConstraints<'a> {
    pub(super) fn new(
        setting: &'a Setting<'a>,
        assembly: &'a Assembly,
        walks: &'a Walks,
        x: &[f64],
        least: f64,
    ) -> Self {
        let panels = setting.panels;
        let steps = GuardedSteps::new(setting, x, Some(least));
        let start = constraint_starts(panels);
        let mut row_start = vec![0];
        for f in 0..panels.n_faces() {
            row_start.push(row_start[f] + panels.valence(f) * (start[f + 1] - start[f]));
        }
        Self {
            bases: ConstraintBases::new(panels),
            rows: vec![Vec3::zeros(); row_start[panels.n_faces()]],
            start,
            row_start,
            branch: branches(panels, &steps.trial),
            closing: Closing::new(walks, panels, &steps.trial, x),
            steps,
            blocks: vec![0.0; assembly.n_block_entries()],
            setting,
            assembly,
        }
    }

    /// How far an even face is from its branch, in radians: twice the defect of the sum of every
    /// other angle.
    fn angle_residual(&self, shape: &FaceShapes, f: usize) -> f64 {
        let sum = || alternating_sum(shape.face(self.setting.panels, f));
        self.branch[f].map_or(0.0, |branch| sum() - branch)
    }

    fn largest_angle(&self, shape: &FaceShapes) -> f64 {
        let faces = 0..self.setting.panels.n_faces();
        largest(faces.map(|f| self.angle_residual(shape, f).abs()))
    }

    /// Largest defect of the condition at `x`, in radians, and what fails to close, by reflection.
    pub(super) fn defects(&mut self, x: &[f64]) -> [f64; 2] {
        self.steps.trial.update(self.setting.panels, x);
        let angle = 0.5 * self.largest_angle(&self.steps.trial);
        [angle, self.closing.defect(x)]
    }

    /// The same from the nearest branches.
    pub(super) fn nearest_defects(&mut self, x: &[f64]) -> [f64; 2] {
        let shape = FaceShapes::at(self.setting.panels, x);
        let nearest = branches(self.setting.panels, &shape);
        let own = std::mem::replace(&mut self.branch, nearest);
        let defects = self.defects(x);
        self.branch = own;
        defects
    }

    /// Number of the equations of the faces; the closing equations follow.
    fn of_faces(&self) -> usize {
        self.start[self.start.len() - 1]
    }

    fn unit(&self) -> f64 {
        ANGLE_UNIT * self.setting.mean_edge
    }

    pub(super) fn update_rows(&mut self, x: &[f64]) {
        let (panels, unit) = (self.setting.panels, self.unit());
        self.closing.linearise(x, unit);
        self.steps.linearised.update(panels, x);
        self.bases.update(panels, &self.steps.linearised);
        for f in 0..panels.n_faces() {
            let (frame, corners) = (
                &self.steps.linearised.frames[f],
                self.steps.linearised.face(panels, f),
            );
            let (k, m) = (corners.len(), self.start[f + 1] - self.start[f]);
            for i in 0..k {
                let rows = &mut self.rows[self.row_start[f] + i * m..][..m];
                for (a, row) in rows.iter_mut().enumerate() {
                    *row = if a < k - 3 {
                        frame.plane.normal * self.bases.row(f, a, k)[i]
                    } else {
                        angle_gradient(frame, corners, i) * unit
                    };
                }
            }
        }
    }

    /// First constraint of a corner's face, and the derivatives of its constraints by that corner.
    fn corner_rows(&self, corner: u32) -> (usize, &[Vec3]) {
        let f = self.setting.panels.face_of(corner);
        let local = corner as usize - self.setting.panels.corners(f).start;
        let m = self.start[f + 1] - self.start[f];
        (
            self.start[f],
            &self.rows[self.row_start[f] + local * m..][..m],
        )
    }

    /// `J W J^T` for the last linearisation.
    pub(super) fn assemble(
        &mut self,
        metric: impl Fn(usize) -> Matrix3<f64>,
        normal: &mut SymmetricMatrix,
    ) {
        let panels = self.setting.panels;
        let mut blocks = std::mem::take(&mut self.blocks);
        for v in 0..panels.n_vertices() {
            let corners = panels.corners_at(v).iter();
            let faces = corners.flat_map(|&c| self.corner_rows(c).1);
            let rows: Vec<Vec3> = faces.chain(self.closing.rows_at(v)).copied().collect();
            let w = metric(v);
            let mut entries = blocks[self.assembly.block(v)].iter_mut();
            for (a, row) in rows.iter().enumerate() {
                let weighted = w * row;
                for (other, entry) in rows[..=a].iter().zip(&mut entries) {
                    *entry = weighted.dot(other);
                }
            }
        }
        self.blocks = blocks;
        self.assembly.assemble(&self.blocks, normal);
    }

    /// Every equation that a vertex has a part in, with its derivative.
    fn rows_at(&self, v: usize) -> impl Iterator<Item = (usize, &Vec3)> + '_ {
        let corners = self.setting.panels.corners_at(v).iter();
        let faces = corners.flat_map(|&c| {
            let (first, rows) = self.corner_rows(c);
            (first..).zip(rows)
        });
        let first = self.of_faces();
        let equations = self.closing.at(v).iter().map(move |&k| first + k as usize);
        faces.chain(equations.zip(self.closing.rows_at(v)))
    }

    /// `J d`.
    pub(super) fn applied(&self, d: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        for v in 0..self.setting.panels.n_vertices() {
            for (k, row) in self.rows_at(v) {
                values[k] += row.dot(&point(d, v));
            }
        }
    }
}

impl Constraints for AngleConstraints<'_> {
    fn linearise(&mut self, x: &[f64], values: &mut [f64], normal: &mut SymmetricMatrix) {
        self.update_rows(x);
        let panels = self.setting.panels;
        for f in 0..panels.n_faces() {
            let corners = self.steps.linearised.face(panels, f);
            for (a, value) in values[self.start[f]..self.start[f + 1]]
                .iter_mut()
                .enumerate()
            {
                *value = if a < corners.len() - 3 {
                    let row = self.bases.row(f, a, corners.len()).iter();
                    row.zip(corners).map(|(q, c)| q * c.height).sum()
                } else {
                    self.unit() * self.angle_residual(&self.steps.linearised, f)
                };
            }
        }
        values[self.of_faces()..].copy_from_slice(self.closing.values());
        self.assemble(|_| Matrix3::identity(), normal);
    }

    fn transposed(&self, y: &[f64], d: &mut [f64]) {
        for v in 0..self.setting.panels.n_vertices() {
            let sum: Vec3 = self.rows_at(v).map(|(k, row)| row * y[k]).sum();
            put(d, v, &sum);
        }
    }

    fn step_bound(&mut self, _x: &[f64], step: &[f64]) -> f64 {
        self.steps.bound(step)
    }

    fn admissible(&mut self, x: &[f64]) -> Option<f64> {
        let held = self.steps.admits(x);
        let angle = || 0.5 * self.largest_angle(&self.steps.trial);
        held.then(|| {
            self.steps
                .planarity()
                .max(angle())
                .max(self.closing.defect(x))
        })
    }

    fn hold_back(&mut self, x: &[f64], step: &mut [f64]) {
        self.steps.hold_back(x, step);
    }

    fn step_length(&self, step: &[f64]) -> f64 {
        self.steps.length(step)
    }
}
