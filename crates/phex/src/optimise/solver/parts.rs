//! Large meshes in parts: the same energy, minimised over the vertices of some thousand faces at a
//! time while the others rest (block descent). Parts that do not touch go side by side, in groups
//! that do not depend on the number of threads. Time grows with the number of faces alone, memory
//! with the size of a part.
//!
//! Parts are made by bisection of the face centres and overlap by a few rings of faces. From phase
//! to phase the cuts lie elsewhere, so that no place stays near one. The energy never rises and no
//! panel is ever crossed, as with all vertices at once.

use super::endgame::minimise_on_constraints;
use super::energy::PanelEnergy;
use super::solvers::{Dual, Solvers, StepReporter, constraint_assembly, energy_assembly, system};
use crate::optimise::error::OptimiseError;
use crate::optimise::holds::{Hold, Holds};
use crate::optimise::panels::{FaceShapes, Panels, picked, point};
use crate::optimise::targets::reference::Reference;
use crate::optimise::terms::areas::AreaWish;
use crate::optimise::terms::guard::Guard;
use crate::optimise::terms::setting::Setting;
use crate::optimise::terms::shape_limits::FaceLimits;
use phex_mesh::{Vec3, bounds};
use phex_numeric::{Assembly, DampedOptions, DampedSolver, Damping, Outcome, Record, Status};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Faces from which a mesh is minimised in parts.
pub(in crate::optimise) const LARGE: usize = 8_000;
/// Faces of a part at the most, without those that it shares with others.
const PART: usize = 1_000;
/// Rings of faces around a part whose vertices move with it.
const OVERLAP: usize = 2;
/// Share of the faces on one side of a cut, by phases in turn.
const SHARES: [f64; 2] = [0.5, 0.4];

/// How a mesh is cut.
pub(in crate::optimise) struct Cuts {
    /// Faces of a part at the most, without those that it shares with others.
    pub most: usize,
    /// Number of the phase, on which depends where the cuts lie.
    pub phase: usize,
}

impl Cuts {
    /// Those of a phase.
    pub(super) fn of_phase(phase: usize) -> Self {
        Self { most: PART, phase }
    }
}

/// The faces of a part, and their vertices; all in order.
#[derive(Clone)]
pub(in crate::optimise) struct PartRegion {
    faces: Vec<u32>,
    /// Those that move.
    moving: Vec<u32>,
    /// All of them.
    vertices: Vec<u32>,
}

impl PartRegion {
    /// The faces at some vertices and `rings` rings more, which move, and a ring at rest.
    pub fn near(panels: &Panels, vertices: impl Iterator<Item = u32>, rings: usize) -> Self {
        let at = vertices.flat_map(|v| panels.corners_at(v as usize));
        let mut core = sorted(at.map(|&c| panels.face_of(c) as u32));
        for _ in OVERLAP..rings {
            let count = core.len();
            core = with_neighbours(panels, &core);
            if core.len() == count {
                break;
            }
        }
        Self::around(panels, &core)
    }

    /// What projects the part.
    pub fn solvers(&self, panels: &Panels) -> Result<Solvers, OptimiseError> {
        Solvers::new(&panels.part(&self.faces, &self.vertices))
    }

    /// Positions of the whole mesh where this moves, and others where it does not.
    pub fn moved(&self, x: &[f64], others: &[f64]) -> Vec<f64> {
        let mut y = others.to_vec();
        for v in self.moving.iter().map(|v| 3 * *v as usize) {
            y[v..v + 3].copy_from_slice(&x[v..v + 3]);
        }
        y
    }

    /// `core` and [`OVERLAP`] rings more, which move, and a ring at rest.
    fn around(panels: &Panels, core: &[u32]) -> Self {
        let mut faces = core.to_vec();
        (0..OVERLAP).for_each(|_| faces = with_neighbours(panels, &faces));
        let moving = vertices_of(panels, &faces);
        faces = with_neighbours(panels, &faces);
        let vertices = vertices_of(panels, &faces);
        Self {
            faces,
            moving,
            vertices,
        }
    }

    /// Puts the coordinates of its vertices in their places.
    pub(super) fn write_back(&self, part: &[f64], x: &mut [f64]) {
        for (&v, p) in self.vertices.iter().zip(part.chunks_exact(3)) {
            x[3 * v as usize..3 * v as usize + 3].copy_from_slice(p);
        }
    }
}

/// Some faces of a mesh with numbers of their own, their outer vertices at rest.
pub(in crate::optimise) struct Part<'a> {
    region: PartRegion,
    pub panels: Panels,
    pub guard: Guard,
    reference: Reference<'a>,
    rim: Vec<u32>,
    corner: Vec<bool>,
    holds: Holds,
    areas: Vec<AreaWish>,
    limits: FaceLimits,
}

impl<'a> Part<'a> {
    /// A region with the positions `x` of the whole mesh.
    pub(super) fn of(whole: &Setting<'a>, region: PartRegion, x: &[f64]) -> Self {
        let (faces, vertices) = (&region.faces, &region.vertices);
        let local = |v: &u32| vertices.binary_search(v).ok().map(|v| v as u32);
        let mut holds = whole.holds.part(local);
        for (k, v) in vertices.iter().enumerate() {
            if region.moving.binary_search(v).is_err() {
                holds.held.insert(k as u32, Hold::At(point(x, *v as usize)));
            }
        }
        Self {
            panels: (whole.panels.part(faces, vertices)).with_rest(|v| holds.fixes(v)),
            guard: whole.guard.part(faces, vertices),
            reference: (whole.reference).part(whole.panels.n_vertices(), vertices, faces),
            rim: whole.rim.iter().filter_map(local).collect(),
            corner: picked(whole.corner, vertices),
            holds,
            areas: picked(whole.areas, faces),
            limits: whole.limits.part(faces),
            region,
        }
    }

    pub fn setting(&self, mean_edge: f64) -> Setting<'_> {
        Setting {
            panels: &self.panels,
            reference: &self.reference,
            guard: &self.guard,
            rim: &self.rim,
            corner: &self.corner,
            holds: &self.holds,
            areas: &self.areas,
            limits: &self.limits,
            mean_edge,
        }
    }

    /// The values of the part's faces.
    pub fn of_faces<T: Clone>(&self, values: &[T]) -> Vec<T> {
        picked(values, &self.region.faces)
    }

    /// The coordinates of the part's vertices.
    pub fn of_vertices(&self, x: &[f64]) -> Vec<f64> {
        let at = |&v: &u32| &x[3 * v as usize..3 * v as usize + 3];
        self.region.vertices.iter().flat_map(at).copied().collect()
    }
}

/// Minimises an energy part by part. `energy` makes it for a part.
pub(in crate::optimise) fn minimise_in_parts(
    whole: &Setting<'_>,
    energy: impl for<'b> Fn(&'b Setting<'b>, &'b Assembly, &Part<'_>) -> PanelEnergy<'b> + Sync,
    x: &mut [f64],
    cuts: &Cuts,
    limits: &DampedOptions,
    reporter: &mut StepReporter<'_>,
) -> Result<Outcome, OptimiseError> {
    let reporter = Mutex::new(reporter);
    for_each_part(whole, energy, x, cuts, |problem, (cholesky, matrix), y| {
        problem.arm(y);
        let mut damping = Damping::default();
        let mut minimiser = DampedSolver::new(cholesky, matrix);
        let observe = |record: &Record| one_at_a_time(&reporter, |r| r.observe(record));
        minimiser.minimise(problem, y, &mut damping, limits, observe)
    })
}

/// Minimises an energy on the constraints part by part, with `most` iterations in each.
pub(super) fn finish_in_parts(
    whole: &Setting<'_>,
    energy: impl for<'b> Fn(&'b Setting<'b>, &'b Assembly, &Part<'_>) -> PanelEnergy<'b> + Sync,
    x: &mut [f64],
    cuts: &Cuts,
    most: usize,
    reporter: &mut StepReporter<'_>,
) -> Result<Outcome, OptimiseError> {
    let reporter = Mutex::new(reporter);
    for_each_part(whole, energy, x, cuts, |problem, mut system, y| {
        let assembly = constraint_assembly(problem.panels());
        let system = (&mut system.0, &mut system.1);
        let observe = |record: &Record| one_at_a_time(&reporter, |r| r.observe(record));
        minimise_on_constraints(problem, &assembly, system, y, most, observe)
    })
}

/// Lets parts that go side by side speak to one listener, each when no other does.
fn one_at_a_time<'a, T>(
    reporter: &Mutex<&mut StepReporter<'a>>,
    talk: impl FnOnce(&mut StepReporter<'a>) -> T,
) -> T {
    // A listener that panicked left nothing behind that could be half-done here.
    let mut reporter = reporter.lock().unwrap_or_else(PoisonError::into_inner);
    talk(&mut reporter)
}

/// Does something with the energy of each part, until it is cancelled: with those of a group side
/// by side, as none of them moves what another one sees.
fn for_each_part(
    whole: &Setting<'_>,
    energy: impl for<'b> Fn(&'b Setting<'b>, &'b Assembly, &Part<'_>) -> PanelEnergy<'b> + Sync,
    x: &mut [f64],
    cuts: &Cuts,
    work: impl Fn(&mut PanelEnergy<'_>, Dual, &mut [f64]) -> Outcome + Sync,
) -> Result<Outcome, OptimiseError> {
    let mut outcome = Outcome::empty(Status::Converged);
    let minimised = |region: PartRegion, x: &[f64]| {
        let part = Part::of(whole, region, x);
        let setting = part.setting(whole.mean_edge);
        let assembly = energy_assembly(&part.panels);
        let mut y = part.of_vertices(x);
        let mut problem = energy(&setting, &assembly, &part);
        let outcome = work(&mut problem, system(&assembly, 3)?, &mut y);
        drop(problem);
        Ok((part.region, y, outcome))
    };
    for group in apart(whole.panels, &cores(whole.panels, x, cuts)) {
        let parts: Result<Vec<_>, OptimiseError> = (group.into_par_iter().with_max_len(1))
            .map(|region| minimised(region, x))
            .collect();
        for (region, y, of_part) in parts? {
            outcome.append(of_part);
            region.write_back(&y, x);
        }
        if outcome.status == Status::Cancelled {
            break;
        }
    }
    Ok(outcome)
}

/// Regions around cores in groups, in each of which none moves a vertex of another one: each goes
/// into the first group where it can.
fn apart(panels: &Panels, cores: &[Vec<u32>]) -> Vec<Vec<PartRegion>> {
    struct PartGroup {
        regions: Vec<PartRegion>,
        moves: Vec<bool>,
        sees: Vec<bool>,
    }
    let mut groups: Vec<PartGroup> = Vec::new();
    for core in cores {
        let region = PartRegion::around(panels, core);
        let meets =
            |vertices: &[u32], marked: &[bool]| vertices.iter().any(|&v| marked[v as usize]);
        let fits =
            |g: &PartGroup| !meets(&region.moving, &g.sees) && !meets(&region.vertices, &g.moves);
        let k = groups.iter().position(fits).unwrap_or(groups.len());
        if k == groups.len() {
            groups.push(PartGroup {
                regions: Vec::new(),
                moves: vec![false; panels.n_vertices()],
                sees: vec![false; panels.n_vertices()],
            });
        }
        let group = &mut groups[k];
        region
            .moving
            .iter()
            .for_each(|&v| group.moves[v as usize] = true);
        region
            .vertices
            .iter()
            .for_each(|&v| group.sees[v as usize] = true);
        group.regions.push(region);
    }
    groups.into_iter().map(|g| g.regions).collect()
}

/// All faces in compact groups; those that are too large are cut along their longest extent.
fn cores(panels: &Panels, x: &[f64], cuts: &Cuts) -> Vec<Vec<u32>> {
    let share = SHARES[cuts.phase % SHARES.len()];
    let shape = FaceShapes::at(panels, x);
    let centres: Vec<Vec3> = shape.frames.iter().map(|f| f.plane.centre).collect();
    let (mut open, mut done) = (
        vec![(0..panels.n_faces() as u32).collect::<Vec<_>>()],
        Vec::new(),
    );
    while let Some(mut group) = open.pop() {
        if group.len() <= cuts.most.max(1) {
            group.sort_unstable();
            done.push(group);
            continue;
        }
        let axis = longest_axis(&centres, &group);
        let along = |f: &u32| centres[*f as usize][axis];
        group.sort_by(|f, g| along(f).total_cmp(&along(g)).then(f.cmp(g)));
        let rest = group.split_off(((share * group.len() as f64) as usize).max(1));
        open.extend([rest, group]);
    }
    done
}

fn longest_axis(centres: &[Vec3], group: &[u32]) -> usize {
    let [low, high] = bounds(group.iter().map(|&f| &centres[f as usize]));
    (high - low).imax()
}

/// Faces and those that share a vertex with one of them, in order.
pub(super) fn with_neighbours(panels: &Panels, faces: &[u32]) -> Vec<u32> {
    let around = |&v: &u32| panels.corners_at(v as usize).iter();
    let vertices = vertices_of(panels, faces);
    sorted((vertices.iter().flat_map(around)).map(|&c| panels.face_of(c) as u32))
}

/// Vertices of faces, in order.
fn vertices_of(panels: &Panels, faces: &[u32]) -> Vec<u32> {
    let of_face = |&f: &u32| panels.vertices(f as usize).iter().copied();
    sorted(faces.iter().flat_map(of_face))
}

fn sorted(numbers: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut numbers: Vec<u32> = numbers.collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}
