//! Factorisations and memory that the runs on one mesh share, and what hears of their iterations.

use crate::optimise::constraints::minimum_norm::PlanarityConstraints;
use crate::optimise::error::OptimiseError;
use crate::optimise::panels::Panels;
use crate::optimise::terms::folds::FoldTerm;
use crate::progress::{Event, Progress};
use phex_numeric::{Assembly, Cholesky, DampedSolver, Record, SymmetricMatrix};
use std::ops::ControlFlow;

/// Factorisations and memory, shared by all runs on one mesh. What belongs to the energy is made
/// when it is first needed.
pub(in crate::optimise) struct Solvers {
    pub energy: EnergySolver,
    pub constraint_assembly: Assembly,
    pub constraints: Option<Dual>,
}

/// Factorisation and matrix on the constraints, handed from one solver to the next; absent if there
/// are no constraints.
pub(super) type Dual = (Cholesky, SymmetricMatrix);

/// Assembly and factorisation of the energy's Hessian.
#[derive(Default)]
pub(in crate::optimise) struct EnergySolver(Option<(Assembly, DampedSolver)>);

impl Solvers {
    pub fn new(panels: &Panels) -> Result<Self, OptimiseError> {
        let constraint_assembly = constraint_assembly(panels);
        let constraints = match constraint_assembly.pattern().dimension() {
            0 => None,
            _ => Some(system(&constraint_assembly, 1)?),
        };
        Ok(Self {
            energy: EnergySolver::default(),
            constraint_assembly,
            constraints,
        })
    }

    /// With room in the energy's matrix for what folds pay.
    pub(crate) fn with_folds(panels: &Panels, folds: &FoldTerm) -> Result<Self, OptimiseError> {
        let assembly = energy_assembly_with(panels, folds.vertices());
        let energy = EnergySolver(Some(EnergySolver::of(assembly)?));
        Ok(Self {
            energy,
            ..Self::new(panels)?
        })
    }
}

impl EnergySolver {
    fn of(assembly: Assembly) -> Result<(Assembly, DampedSolver), OptimiseError> {
        let (cholesky, matrix) = system(&assembly, 3)?;
        Ok((assembly, DampedSolver::new(cholesky, matrix)))
    }

    /// Makes it ready.
    pub(crate) fn prepare(
        &mut self,
        panels: &Panels,
    ) -> Result<(&Assembly, &mut DampedSolver), OptimiseError> {
        let made = match self.0.take() {
            Some(made) => made,
            None => Self::of(energy_assembly(panels))?,
        };
        let (assembly, solver) = self.0.insert(made);
        Ok((assembly, solver))
    }
}

/// The assembly of `J J^T`: the unknowns are the constraints, the elements the vertices.
pub(in crate::optimise) fn constraint_assembly(panels: &Panels) -> Assembly {
    let count = PlanarityConstraints::count(panels);
    Assembly::new(count, &PlanarityConstraints::elements(panels))
}

/// The assembly of the energy's Hessian: a block for every face and then one for every vertex.
pub(in crate::optimise) fn energy_assembly(panels: &Panels) -> Assembly {
    energy_assembly_with(panels, [])
}

/// The same with a block for each of some more sets of vertices.
pub(in crate::optimise) fn energy_assembly_with(
    panels: &Panels,
    more: impl IntoIterator<Item = Vec<u32>>,
) -> Assembly {
    let unknowns = |v: u32| [3 * v, 3 * v + 1, 3 * v + 2];
    let face = |f| match panels.rests(f) {
        true => Vec::new(),
        false => (panels.vertices(f).iter())
            .flat_map(|&v| unknowns(v))
            .collect(),
    };
    let faces = (0..panels.n_faces()).map(face);
    let vertices = (0..panels.n_vertices() as u32).map(|v| unknowns(v).to_vec());
    let more = more
        .into_iter()
        .map(|vertices| vertices.into_iter().flat_map(unknowns).collect());
    let elements: Vec<Vec<u32>> = faces.chain(vertices).chain(more).collect();
    Assembly::new(3 * panels.n_vertices(), &elements)
}

/// An analysed factorisation and a matrix on the pattern of an assembly.
pub(in crate::optimise) fn system(
    assembly: &Assembly,
    block: usize,
) -> Result<(Cholesky, SymmetricMatrix), OptimiseError> {
    let cholesky = Cholesky::analyse(assembly.pattern(), block)?;
    Ok((cholesky, SymmetricMatrix::zeros(assembly.pattern().clone())))
}

/// Tells of iterations and hears of cancelling.
pub(in crate::optimise) struct StepReporter<'a> {
    progress: &'a dyn Progress,
    stage: &'static str,
    iteration: usize,
    limit: usize,
}

impl<'a> StepReporter<'a> {
    /// `limit` iterations of a stage are expected at the most.
    pub fn new(progress: &'a dyn Progress, stage: &'static str, limit: usize) -> Self {
        Self {
            progress,
            stage,
            iteration: 0,
            limit,
        }
    }

    pub fn observe(&mut self, record: &Record) -> ControlFlow<()> {
        self.iteration += 1;
        self.progress.report(&Event::Iteration {
            stage: self.stage,
            iteration: self.iteration,
            limit: self.limit.max(self.iteration),
            residual: record.residual,
        });
        if self.progress.is_cancelled() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
