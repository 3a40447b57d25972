//! Starts: simple panels near the surface.
//!
//! *Smoothed cells*: each vertex moves half-way to the mean of its neighbours and back to the
//! surface, until every panel is simple and on its side of the surface (Voronoi cells mostly are
//! from the beginning; a few rounds make them even). Vertices of the boundary are averaged along
//! the boundary; corners stay.
//!
//! *Kinked cells*: each interior vertex moves towards the point where the best planes of its three
//! panels meet, which is near the circumcentre in the metric `|II|` (Dupin duality): `d = (A^T A +
//! eps I)^-1 A^T b`, rows of `A` the three normals, `b_i = n_i . (p_i - x)` with the centres `p_i`,
//! no farther than 0.8 panels. Where panels would suffer, their vertices back off. Where the
//! surface is nearly flat the planes hardly meet; `eps` is set by the middle singular value.

use crate::layout::{Layout, VertexKind};
use crate::optimise::Target;
use crate::optimise::panels::{FaceShapes, Panels, flatten, points};
use crate::optimise::simple::areas;
use crate::optimise::terms::barrier::clearance;
use crate::optimise::terms::guard::{Breach, Guard};
use nalgebra::Matrix3;
use phex_mesh::{Topology, Vec3, VertexId};

/// A start and the number of its panels that are not simple or not on their side.
#[derive(Clone, Debug)]
pub(in crate::optimise) struct Start {
    pub x: Vec<f64>,
    pub n_bad: usize,
}

/// Panels that are not simple or not on their side.
fn bad_faces(panels: &Panels, guard: &Guard, x: &[f64]) -> (Vec<usize>, FaceShapes) {
    let shape = FaceShapes::at(panels, x);
    let face = |b: Breach| match b {
        Breach::NotSimple(f) | Breach::WrongSide(f) => Some(f),
        Breach::Fan(_) | Breach::Fold(_) => None,
    };
    let breaches = guard.breaches(panels, &shape, x).into_iter();
    let mut faces: Vec<usize> = breaches.filter_map(face).collect();
    faces.sort_unstable();
    faces.dedup();
    (faces, shape)
}

/// Neighbours whose mean each vertex moves to.
fn averaging_stencils(topology: &Topology) -> Vec<Vec<u32>> {
    let stencil = |v: VertexId| {
        let rim = topology.is_boundary_vertex(v);
        let neighbours = topology.neighbours(v).into_iter();
        let wanted = neighbours.filter(|&n| !rim || topology.is_boundary_vertex(n));
        wanted.map(|n| n.index() as u32).collect()
    };
    topology.vertices().map(stencil).collect()
}

/// Cells that are smoothed on the surface.
pub(in crate::optimise) struct Smoothing<'a> {
    pub layout: &'a Layout,
    pub target: &'a dyn Target,
    pub panels: &'a Panels,
    pub guard: &'a Guard,
    /// Least and largest number of rounds.
    pub steps: [usize; 2],
}

impl Smoothing<'_> {
    /// From the layout's own cells. Stops early when asked to.
    pub(crate) fn of_cells(&self, cancelled: impl Fn() -> bool) -> Start {
        let positions = self.layout.mesh.positions.as_slice().to_vec();
        self.from(positions, |_| true, cancelled)
    }

    /// From some positions, of which those move that are free.
    pub fn from(
        &self,
        mut positions: Vec<Vec3>,
        free: impl Fn(usize) -> bool,
        cancelled: impl Fn() -> bool,
    ) -> Start {
        let stencils = averaging_stencils(self.layout.mesh.topology());
        let [least, most] = self.steps;
        let mut best = Start {
            x: flatten(&positions),
            n_bad: usize::MAX,
        };
        for round in 0..=most {
            let x = flatten(&positions);
            let n_bad = bad_faces(self.panels, self.guard, &x).0.len();
            if n_bad < best.n_bad || (n_bad == 0 && round <= least) {
                best = Start { x, n_bad };
            }
            if (n_bad == 0 && round >= least) || cancelled() {
                break;
            }
            self.smooth(&mut positions, &stencils, &free);
        }
        best
    }

    fn smooth(&self, positions: &mut [Vec3], stencils: &[Vec<u32>], free: &impl Fn(usize) -> bool) {
        let kind = |v: usize| self.layout.vertex_kind[VertexId::new(v as u32)];
        let moves = |v: &usize| {
            free(*v) && kind(*v) != VertexKind::BoundaryCorner && !stencils[*v].is_empty()
        };
        let moving: Vec<usize> = (0..positions.len()).filter(moves).collect();
        let halfway = |&v: &usize| {
            let ring = &stencils[v];
            let sum: Vec3 = ring.iter().map(|&n| positions[n as usize]).sum();
            positions[v] * 0.5 + sum * (0.5 / ring.len() as f64)
        };
        let moved: Vec<Vec3> = moving.iter().map(halfway).collect();
        let feet = self.target.closest_points(&moved, &[]);
        for (&v, foot) in moving.iter().zip(&feet) {
            positions[v] = foot.position;
        }
        let on_rim = moving.iter().zip(&moved);
        let on_rim = on_rim.filter(|(v, _)| kind(**v) == VertexKind::Boundary);
        let (rim, points): (Vec<usize>, Vec<Vec3>) = on_rim.map(|(v, p)| (*v, *p)).unzip();
        if let Some(curve) = self.target.closest_on_boundary(&points) {
            for (&v, q) in rim.iter().zip(&curve) {
                positions[v] = q.position;
            }
        }
    }
}

/// A start moved towards the circumcentres of the best planes of its own faces.
pub(in crate::optimise) fn kinked(
    topology: &Topology,
    panels: &Panels,
    guard: &Guard,
    given: &Start,
) -> Start {
    let mean_edge = panels.mean_edge(&given.x);
    let before = points(&given.x);
    let (bad_before, shape) = bad_faces(panels, guard, &given.x);
    let steps = circumcentre_steps(topology, panels, &shape, &before);
    let allowed = |f: usize| bad_before.binary_search(&f).is_ok();
    let least: Vec<f64> = (0..panels.n_faces())
        .map(|f| (0.6 * clearance(shape.face(panels, f))).min(0.12 * mean_edge))
        .collect();
    let mut blend = vec![1.0; before.len()];
    const ROUNDS: usize = 30;
    for round in 0..=ROUNDS {
        let moved = |v: usize| before[v] + steps[v] * blend[v];
        let x = flatten(&(0..before.len()).map(moved).collect::<Vec<_>>());
        let (bad, shape) = bad_faces(panels, guard, &x);
        let suffers = |&f: &usize| {
            bad.binary_search(&f).is_ok() || clearance(shape.face(panels, f)) < least[f]
        };
        let all = 0..panels.n_faces();
        let suffering: Vec<usize> = all.filter(|f| !allowed(*f) && suffers(f)).collect();
        if suffering.is_empty() {
            let n_bad = bad.len();
            return Start { x, n_bad };
        }
        let factor = if round + 1 < ROUNDS { 0.6 } else { 0.0 };
        for &v in suffering.iter().flat_map(|&f| panels.vertices(f)) {
            blend[v as usize] *= factor;
        }
    }
    given.clone()
}

/// Normal equations of the planes of the three panels at a vertex.
struct PlanesAtVertex {
    /// `A^T A`.
    matrix: Matrix3<f64>,
    /// `A^T b`.
    rhs: Vec3,
    /// Middle singular value of `A`.
    middle: f64,
}

impl PlanesAtVertex {
    /// Of an interior vertex of degree 3 at `position`.
    fn new(topology: &Topology, shape: &FaceShapes, v: VertexId, position: Vec3) -> Option<Self> {
        if topology.is_boundary_vertex(v) || topology.face_degree(v) != 3 {
            return None;
        }
        let (mut matrix, mut rhs) = (Matrix3::zeros(), Vec3::zeros());
        for f in topology.faces_at(v).map(|f| f.index()) {
            let n = shape.normal(f);
            matrix += n * n.transpose();
            rhs += n * n.dot(&(shape.frames[f].plane.centre - position));
        }
        let mut squares = matrix.symmetric_eigenvalues();
        squares.as_mut_slice().sort_by(f64::total_cmp);
        let middle = squares[1].max(0.0).sqrt();
        Some(Self {
            matrix,
            rhs,
            middle,
        })
    }

    /// Regularised way to where they meet.
    fn step(&self, typical: f64) -> Vec3 {
        let eps = (0.2 * self.middle.max(0.35 * typical)).powi(2) + 1e-12;
        let regularised = self.matrix + Matrix3::from_diagonal_element(eps);
        let solved = regularised.cholesky().map(|c| c.solve(&self.rhs));
        solved.unwrap_or_else(Vec3::zeros)
    }
}

/// Step of each vertex to its regularised circumcentre; zero on the boundary.
fn circumcentre_steps(
    topology: &Topology,
    panels: &Panels,
    shape: &FaceShapes,
    positions: &[Vec3],
) -> Vec<Vec3> {
    let extents: Vec<f64> = areas(panels, shape).into_iter().map(f64::sqrt).collect();
    let planes = |v: VertexId| PlanesAtVertex::new(topology, shape, v, positions[v.index()]);
    let systems: Vec<_> = topology.vertices().map(planes).collect();
    let mut middles: Vec<f64> = systems.iter().flatten().map(|s| s.middle).collect();
    middles.sort_by(f64::total_cmp);
    let typical = middles.get(middles.len() / 2).copied().unwrap_or(0.0);
    let step = |(v, system): (VertexId, &Option<PlanesAtVertex>)| {
        let Some(system) = system else {
            return Vec3::zeros();
        };
        let faces = topology.faces_at(v).map(|f| f.index());
        let lengths: f64 = faces.map(|f| extents[f]).sum();
        let longest = 0.8 * lengths / 3.0;
        let step = system.step(typical);
        step * (longest / step.norm().max(longest))
    };
    topology.vertices().zip(&systems).map(step).collect()
}
