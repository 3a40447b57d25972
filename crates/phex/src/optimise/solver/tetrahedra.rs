//! The paper's own formulation, for comparison: a face is planar if every four of its corners span
//! no volume.
//!
//! ```text
//! E = w_c/2 sum |x - p(x)|^2 + w/2 sum (6 V_abcd / h^2)^2 + w_t/2 sum |x - x_0|^2
//! ```
//!
//! over the vertices `x` with foot points `p` on the surface, and over all tetrahedra of four
//! corners of a face (15 in a hexagon), `h` the mean edge; the last, slight term is ours, since
//! nothing else decides along the surface. `w` rises tenfold from phase to phase until panels are
//! planar to the tolerance.
//!
//! Source: Wang and Liu, "A note on planar hexagonal meshes" (2010), section 3. *Not guaranteed*:
//! anything about validity: nothing keeps panels from crossing themselves, which is what this
//! solver is there to show. Offenders are named as ever.

use super::reached::{ResultOrigin, Run};
use super::solvers::{Solvers, StepReporter};
use super::start::Start;
use crate::optimise::Stage;
use crate::optimise::error::OptimiseError;
use crate::optimise::options::{OptimiseOptions, PathKind, StartKind};
use crate::optimise::panels::{FaceShapes, add_at, add_block, point};
use crate::optimise::terms::closeness::Feet;
use crate::optimise::terms::setting::{Setting, longest};
use crate::progress::Progress;
use nalgebra::Matrix3;
use phex_mesh::Vec3;
use phex_numeric::{
    Assembly, DampedProblem, DampedSolver, Damping, Outcome, Record, Status, SymmetricMatrix,
};
use std::ops::ControlFlow;

/// Weights of the volumes: the first, the factor from phase to phase, and the number of phases.
const WEIGHTS: (f64, f64, usize) = (1.0, 10.0, 13);

/// Closeness and volumes.
struct Tetrahedra<'a> {
    setting: &'a Setting<'a>,
    assembly: &'a Assembly,
    /// `w_c`.
    closeness: f64,
    /// `w_t`, and `x_0`.
    anchor: (f64, Vec<f64>),
    /// `w`.
    weight: f64,
    shape: FaceShapes,
    feet: Feet,
    blocks: Vec<f64>,
}

/// Six times the volume of a tetrahedron, and its gradient at the four corners.
fn volume([a, b, c, d]: [Vec3; 4]) -> (f64, [Vec3; 4]) {
    let (u, v, w) = (b - a, c - a, d - a);
    let (at_b, at_c, at_d) = (v.cross(&w), w.cross(&u), u.cross(&v));
    (u.dot(&at_b), [-(at_b + at_c + at_d), at_b, at_c, at_d])
}

/// Calls `visit` for every four of `k` corners.
fn for_each_four(k: usize, mut visit: impl FnMut([usize; 4])) {
    for a in 0..k {
        for b in a + 1..k {
            for c in b + 1..k {
                (c + 1..k).for_each(|d| visit([a, b, c, d]));
            }
        }
    }
}

impl<'a> Tetrahedra<'a> {
    /// `assembly` has a block for every face and then one for every vertex.
    pub fn new(
        setting: &'a Setting<'a>,
        assembly: &'a Assembly,
        options: &OptimiseOptions,
        x: &[f64],
    ) -> Self {
        Self {
            setting,
            assembly,
            closeness: options.vertex_closeness,
            anchor: (options.anchor, x.to_vec()),
            weight: WEIGHTS.0,
            shape: FaceShapes::at(setting.panels, x),
            feet: Feet::default(),
            blocks: vec![0.0; assembly.n_block_entries()],
        }
    }

    /// Weight of a volume squared.
    fn scaled(&self) -> f64 {
        self.weight / self.setting.mean_edge.powi(4)
    }

    fn visit(&mut self, x: &[f64]) {
        self.shape.update(self.setting.panels, x);
        self.feet
            .update(self.setting.reference, &self.shape, x, &[]);
    }

    fn corners(&self, face: usize) -> Vec<Vec3> {
        let corners = self.shape.face(self.setting.panels, face).iter();
        corners.map(|c| c.position).collect()
    }

    fn volumes(&self) -> f64 {
        let mut sum = 0.0;
        for f in 0..self.setting.panels.n_faces() {
            let corners = self.corners(f);
            for_each_four(corners.len(), |four| {
                sum += volume(four.map(|i| corners[i])).0.powi(2);
            });
        }
        0.5 * self.scaled() * sum
    }

    fn add_face(&mut self, f: usize, gradient: &mut [f64]) {
        let (corners, weight) = (self.corners(f), self.scaled());
        let vertices = self.setting.panels.vertices(f);
        let block = &mut self.blocks[self.assembly.block(f)];
        block.fill(0.0);
        for_each_four(corners.len(), |four| {
            let (v, slopes) = volume(four.map(|i| corners[i]));
            for (m, (&i, s)) in four.iter().zip(&slopes).enumerate() {
                add_at(gradient, vertices[i] as usize, &(s * (weight * v)));
                for (&j, t) in four[..=m].iter().zip(&slopes) {
                    add_block(block, i, j, &(s * t.transpose() * weight));
                }
            }
        });
    }

    /// Way of a vertex from its anchor.
    fn pull(&self, x: &[f64], v: usize) -> Vec3 {
        point(x, v) - point(&self.anchor.1, v)
    }

    fn add_vertices(&mut self, x: &[f64], gradient: &mut [f64]) {
        let panels = self.setting.panels;
        for v in 0..panels.n_vertices() {
            let term = self.feet.vertex(v, self.closeness);
            let slope = term.gradient + self.pull(x, v) * self.anchor.0;
            add_at(gradient, v, &slope);
            let block = &mut self.blocks[self.assembly.block(panels.n_faces() + v)];
            block.fill(0.0);
            let slight = Matrix3::from_diagonal_element(self.anchor.0);
            add_block(block, 0, 0, &(term.hessian + slight));
        }
    }
}

impl DampedProblem for Tetrahedra<'_> {
    fn energy(&mut self, x: &[f64]) -> f64 {
        self.visit(x);
        let near = |v| {
            let apart = self.feet.vertex(v, 1.0).gradient.norm_squared();
            self.closeness * apart + self.anchor.0 * self.pull(x, v).norm_squared()
        };
        let near: f64 = (0..self.setting.panels.n_vertices()).map(near).sum();
        0.5 * near + self.volumes()
    }

    fn linearise(&mut self, x: &[f64], gradient: &mut [f64], hessian: &mut SymmetricMatrix) {
        self.visit(x);
        gradient.fill(0.0);
        (0..self.setting.panels.n_faces()).for_each(|f| self.add_face(f, gradient));
        self.add_vertices(x, gradient);
        let (setting, assembly) = (self.setting, self.assembly);
        setting.holds.restrict(
            setting.panels,
            assembly,
            self.closeness,
            x,
            gradient,
            &mut self.blocks,
        );
        assembly.assemble(&self.blocks, hessian);
    }

    fn step_bound(&mut self, _x: &[f64], _step: &[f64]) -> f64 {
        1.0
    }

    fn step_length(&self, step: &[f64]) -> f64 {
        longest(step) / self.setting.mean_edge
    }

    fn residual(&self) -> f64 {
        self.shape.max_height() / self.setting.mean_edge
    }

    fn retract(&self, x: &mut [f64]) {
        self.setting.holds.retract(x);
    }
}

/// The penalty method: `x` is moved until panels are planar, or the weights are through.
fn penalise(
    energy: &mut Tetrahedra<'_>,
    solver: &mut DampedSolver,
    x: &mut [f64],
    options: &OptimiseOptions,
    mut observe: impl FnMut(&Record) -> ControlFlow<()>,
) -> Outcome {
    let mut outcome = Outcome::empty(Status::IterationLimit);
    let mut damping = Damping::default();
    for _ in 0..WEIGHTS.2 {
        let phase = options.phase(energy.weight);
        let made = solver.minimise(energy, x, &mut damping, &phase, &mut observe);
        outcome.append(made);
        let planar = energy.residual() <= options.planarity_tolerance;
        if planar || outcome.status == Status::Cancelled {
            break;
        }
        energy.weight *= WEIGHTS.1;
    }
    if outcome.status == Status::Converged && energy.residual() > options.planarity_tolerance {
        outcome.status = Status::IterationLimit;
    }
    outcome
}

impl Stage<'_> {
    /// Optimises one start by the paper's formulation.
    pub(crate) fn run_tetrahedra(
        &self,
        solvers: &mut Solvers,
        kind: StartKind,
        start: &Start,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Run, OptimiseError> {
        let setting = self.setting(&start.x);
        let mut x = start.x.clone();
        let (assembly, minimiser) = solvers.energy.prepare(&self.panels)?;
        let mut energy = Tetrahedra::new(&setting, assembly, options, &x);
        let mut reporter =
            StepReporter::new(progress, "optimise", WEIGHTS.2 * options.max_iterations);
        let observe = |record: &Record| reporter.observe(record);
        let outcome = penalise(&mut energy, minimiser, &mut x, options, observe);
        let way = ResultOrigin {
            kind,
            path: PathKind::Tetrahedra,
            in_parts: 0,
            outcome,
        };
        Ok(self.conclude(start.n_bad, x, way, options))
    }
}

#[cfg(test)]
mod tests {
    use super::super::solvers::energy_assembly;
    use super::*;
    use crate::optimise::Reference;
    use crate::optimise::holds::{Hold, Holds};
    use crate::optimise::panels::{Panels, unknowns};
    use crate::optimise::terms::guard::Guard;
    use crate::optimise::tests::fixtures::{Shape as Surface, brick_wall, jittered};

    #[test]
    fn a_hexagon_has_fifteen_tetrahedra() {
        let mut all = Vec::new();
        for_each_four(6, |four| all.push(four));
        assert_eq!(all.len(), 15);
        all.dedup();
        assert_eq!(all.len(), 15);
    }

    #[test]
    fn the_volume_of_a_corner_of_the_cube_and_its_gradient() {
        let mut corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let (v, slopes) = volume(corners);
        assert_eq!(v, 1.0);
        for k in 0..4 {
            for c in 0..3 {
                corners[k][c] += 1e-3;
                let slope = (volume(corners).0 - v) / 1e-3;
                corners[k][c] -= 1e-3;
                assert!((slope - slopes[k][c]).abs() < 1e-12, "{k} {c}");
            }
        }
    }

    /// Gradient by central differences; a fixed vertex has none, and its rows of the Hessian are
    /// those of the identity.
    #[test]
    fn gradient_is_right_and_held_vertices_are_left_out() {
        let shape = Surface::Wave;
        let mesh = jittered(&brick_wall(shape, 7, 3), 0.1, 2);
        let panels = Panels::new(mesh.topology());
        let mut x = unknowns(&mesh);
        let mut holds = Holds::default();
        holds.held.insert(4, Hold::At(point(&x, 4)));
        let setting = Setting {
            panels: &panels,
            reference: &Reference::Surface(&shape),
            guard: &Guard::new(mesh.topology(), None, 0.1),
            rim: &[],
            corner: &vec![false; panels.n_vertices()],
            holds: &holds,
            areas: &crate::optimise::terms::areas::any(panels.n_faces()),
            limits: &crate::optimise::FaceLimits::none(panels.n_faces()),
            mean_edge: panels.mean_edge(&x),
        };
        let assembly = energy_assembly(&panels);
        let mut energy = Tetrahedra::new(&setting, &assembly, &OptimiseOptions::default(), &x);
        energy.weight = 3.0;
        let mut gradient = vec![0.0; x.len()];
        let mut hessian = SymmetricMatrix::zeros(assembly.pattern().clone());
        energy.linearise(&x, &mut gradient, &mut hessian);
        for i in 0..x.len() {
            let step = 1e-5 * setting.mean_edge;
            let at = x[i];
            let mut energy_at = |value| {
                x[i] = value;
                energy.energy(&x)
            };
            let slope = (energy_at(at + step) - energy_at(at - step)) / (2.0 * step);
            x[i] = at;
            let expected = if i / 3 == 4 { 0.0 } else { slope };
            assert!((gradient[i] - expected).abs() < 1e-6, "{i}");
        }
        let mut unit = vec![0.0; x.len()];
        let mut product = unit.clone();
        unit[12] = 1.0;
        hessian.mul(&unit, &mut product);
        assert_eq!(product, unit);
    }
}
