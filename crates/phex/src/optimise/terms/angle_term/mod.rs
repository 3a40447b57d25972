//! The angle condition as a penalty: `w/2 (u r)^2` for each even face, with `r` of the constraints
//! and their unit `u`.

pub(in crate::optimise) mod closing;
pub(in crate::optimise) mod walks;

use crate::optimise::panels::{Corner, FaceFrame, FaceShapes, Panels, add_at, add_outer};
use closing::Closing;
use phex_mesh::polygon::interior_angles;
use phex_mesh::{Vec2, Vec3};
use phex_numeric::Assembly;
use std::f64::consts::TAU;

pub(in crate::optimise) fn has_angle(valence: usize) -> bool {
    valence.is_multiple_of(2)
}

/// `t_0 - t_1 + t_2 - ...` of a face in its plane.
pub(in crate::optimise) fn alternating_sum(corners: &[Corner]) -> f64 {
    let flat: Vec<Vec2> = corners.iter().map(|c| c.flat).collect();
    let signed = |(i, t): (usize, f64)| if i % 2 == 0 { t } else { -t };
    interior_angles(&flat).enumerate().map(signed).sum()
}

/// Derivative of [`alternating_sum`] by each corner: `+-2 (n x e / |e|^2)` of both its edges.
pub(in crate::optimise) fn angle_gradient(frame: &FaceFrame, corners: &[Corner], i: usize) -> Vec3 {
    let k = corners.len();
    let turn = |from: usize, to: usize| {
        let e = corners[to].flat - corners[from].flat;
        Vec2::new(-e.y, e.x) / e.norm_squared()
    };
    let sum = (turn(i, (i + 1) % k) + turn((i + k - 1) % k, i)) * 2.0;
    let [a, b] = frame.plane.axes;
    let gradient = a * sum.x + b * sum.y;
    if i.is_multiple_of(2) {
        gradient
    } else {
        -gradient
    }
}

/// Unit of the angle constraint, over the mean edge: its gradient is then about as long as those of
/// planarity.
pub(in crate::optimise) const ANGLE_UNIT: f64 = 0.125;

/// Alternating sums that even faces are nearest to, of those that simple ones can have: 0 alone for
/// a quadrilateral, whose opposite angles must make pi.
pub(in crate::optimise) fn branches(panels: &Panels, shape: &FaceShapes) -> Vec<Option<f64>> {
    let nearest = |f: usize| {
        let most = (panels.valence(f) / 2) as f64 - 2.0;
        let turns = alternating_sum(shape.face(panels, f)) / TAU;
        has_angle(panels.valence(f)).then(|| turns.round().clamp(-most, most) * TAU)
    };
    (0..panels.n_faces()).map(nearest).collect()
}

/// The penalty of all faces.
pub(in crate::optimise) struct AngleTerm<'a> {
    /// Weight, times the square of the unit of the constraint.
    weight: f64,
    branch: Vec<Option<f64>>,
    closing: Closing<'a>,
}

impl<'a> AngleTerm<'a> {
    /// `weight` is that of squares of lengths.
    pub fn new(
        weight: f64,
        mean_edge: f64,
        branch: Vec<Option<f64>>,
        closing: Closing<'a>,
    ) -> Self {
        let unit = ANGLE_UNIT * mean_edge;
        Self {
            weight: weight * unit * unit,
            branch,
            closing,
        }
    }

    /// Energy of what fails to close.
    pub(crate) fn closing_energy(&self, x: &[f64]) -> f64 {
        0.5 * self.weight * self.closing.squares(x)
    }

    /// Adds gradient and Gauss-Newton blocks of what fails to close: a block for each walk, from
    /// `first` on.
    pub(crate) fn add_closing(
        &mut self,
        x: &[f64],
        gradient: &mut [f64],
        assembly: &Assembly,
        first: usize,
        blocks: &mut [f64],
    ) {
        self.closing.linearise(x, 1.0);
        for (k, walk) in self.closing.walks().walks.iter().enumerate() {
            let block = &mut blocks[assembly.block(first + k)];
            block.fill(0.0);
            let vertices = walk.distinct();
            for equation in walk.equations() {
                let value = self.weight * self.closing.values()[equation];
                let rows = vertices
                    .iter()
                    .map(|&v| *self.closing.row(v as usize, equation));
                let rows: Vec<Vec3> = rows.collect();
                for (row, &v) in rows.iter().zip(&vertices) {
                    add_at(gradient, v as usize, &(row * value));
                }
                add_outer(block, &rows, self.weight);
            }
        }
    }

    /// Energy of a face.
    pub fn energy(&self, face: usize, corners: &[Corner]) -> f64 {
        self.branch[face].map_or(0.0, |branch| {
            let r = alternating_sum(corners) - branch;
            0.5 * self.weight * r * r
        })
    }

    /// Adds gradient and Gauss-Newton block of a face.
    pub fn add(
        &self,
        face: usize,
        frame: &FaceFrame,
        corners: &[Corner],
        gradient: &mut [Vec3],
        block: &mut [f64],
    ) {
        let Some(branch) = self.branch[face] else {
            return;
        };
        let r = alternating_sum(corners) - branch;
        let rows: Vec<Vec3> = (0..corners.len())
            .map(|i| angle_gradient(frame, corners, i))
            .collect();
        let pulls = gradient.iter_mut().zip(&rows);
        pulls.for_each(|(g, row)| *g += row * (self.weight * r));
        add_outer(block, &rows, self.weight);
    }
}

#[cfg(test)]
mod tests {
    use super::walks::Walks;
    use super::*;
    use crate::optimise::panels::unknowns;
    use crate::optimise::solver::solvers::energy_assembly_with;
    use phex_mesh::HexMesh;

    fn hexagon() -> HexMesh {
        let corners = [
            [1.0, 0.1],
            [0.4, 0.9],
            [-0.6, 0.7],
            [-1.1, 0.0],
            [-0.3, -0.8],
            [0.6, -0.7],
        ];
        let place = |c: &[f64; 2]| Vec3::new(c[0], c[1], 0.0);
        HexMesh::new(corners.iter().map(place).collect(), &[[0, 1, 2, 3, 4, 5]]).unwrap()
    }

    /// A square frustum with its bottom: even faces, and a ring of four quadrilaterals that is open
    /// at the top.
    fn frustum() -> HexMesh {
        let ring = |r: f64, z: f64| {
            [[1.0, 0.1], [-0.1, 0.9], [-1.1, 0.0], [0.2, -1.0]]
                .map(|[x, y]| Vec3::new(r * x, r * y, z))
        };
        let faces = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        let positions = [ring(1.0, 0.0), ring(0.6, 0.8)].concat();
        HexMesh::new(positions, &faces).unwrap()
    }

    #[test]
    fn gradient_of_the_angles_is_that_of_differences() {
        let mesh = hexagon();
        let (panels, walks) = (Panels::new(mesh.topology()), Walks::of(&mesh));
        let x = unknowns(&mesh);
        let shape = FaceShapes::at(&panels, &x);
        let closing = Closing::new(&walks, &panels, &shape, &x);
        let term = AngleTerm::new(3.0, 0.9, branches(&panels, &shape), closing);
        let mut gradient = vec![Vec3::zeros(); 6];
        let mut block = vec![0.0; 18 * 19 / 2];
        let corners = shape.face(&panels, 0);
        term.add(0, &shape.frames[0], corners, &mut gradient, &mut block);
        let h = 1e-6;
        for v in 0..6 {
            for k in 0..2 {
                let at = |step: f64| {
                    let mut moved = x.clone();
                    moved[3 * v + k] += step;
                    term.energy(0, FaceShapes::at(&panels, &moved).face(&panels, 0))
                };
                let slope = (at(h) - at(-h)) / (2.0 * h);
                let own = gradient[panels
                    .vertices(0)
                    .iter()
                    .position(|&w| w as usize == v)
                    .unwrap()][k];
                assert!((slope - own).abs() < 1e-8, "vertex {v}: {slope} {own}");
            }
        }
        assert!(gradient.iter().any(|g| g.norm() > 1e-3));
    }

    #[test]
    fn gradient_of_what_fails_to_close_is_that_of_differences() {
        let mesh = frustum();
        let (panels, walks) = (Panels::new(mesh.topology()), Walks::of(&mesh));
        assert_eq!(walks.n_equations(), 2);
        let x = unknowns(&mesh);
        let shape = FaceShapes::at(&panels, &x);
        let closing = Closing::new(&walks, &panels, &shape, &x);
        let mut term = AngleTerm::new(3.0, 0.9, branches(&panels, &shape), closing);
        let assembly = energy_assembly_with(&panels, walks.walks.iter().map(|w| w.distinct()));
        let mut blocks = vec![0.0; assembly.n_block_entries()];
        let mut gradient = vec![0.0; x.len()];
        let first = panels.n_faces() + panels.n_vertices();
        term.add_closing(&x, &mut gradient, &assembly, first, &mut blocks);
        let h = 1e-6;
        for i in 0..x.len() {
            let at = |step: f64| {
                let mut moved = x.clone();
                moved[i] += step;
                term.closing_energy(&moved)
            };
            let slope = (at(h) - at(-h)) / (2.0 * h);
            assert!(
                (slope - gradient[i]).abs() < 1e-8,
                "{i}: {slope} {}",
                gradient[i]
            );
        }
        assert!(gradient.iter().any(|g| g.abs() > 1e-4), "{gradient:?}");
    }

    #[test]
    fn branches_are_those_that_simple_faces_can_have() {
        // A dart: its angles 20, 20 and 280, 40 degrees add up to 40 and 320, nearer to 0 and 360
        // than to 180 each.
        let dart = [[0.0, 1.0], [-0.4, -0.1], [0.0, 0.2], [0.4, -0.1]];
        let place = |c: &[f64; 2]| Vec3::new(c[0], c[1], 0.0);
        let mesh = HexMesh::new(dart.iter().map(place).collect(), &[[0, 1, 2, 3]]).unwrap();
        let panels = Panels::new(mesh.topology());
        let shape = FaceShapes::at(&panels, &unknowns(&mesh));
        let sum = alternating_sum(shape.face(&panels, 0));
        assert!((sum / TAU).round().abs() == 1.0, "{sum}");
        assert_eq!(branches(&panels, &shape), [Some(0.0)]);
    }
}
