//! Layout, optimiser and the repair loop for one anisotropy.

use super::field::{Field, FineSurface, direction_options};
use super::{Clock, MeshOptions, PipelineError, RepairRound};
use crate::ground::Ground;
use crate::layout::seeds::Seed;
use crate::layout::{self, Layout, LayoutStatistics};
use crate::optimise::{self, Fault, Offender, Optimised, SurfaceTarget};
use crate::trim::{self, Boundary, Trimmed};
use phex_mesh::{
    FaceId, FlatFace, HexMesh, PolygonSoup, TriangleSurface, ValidateOptions, VertexId, Violation,
};
use serde::Serialize;
use std::collections::{BTreeSet, HashSet};

/// One member of the portfolio, for the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttemptSummary {
    /// Largest ratio of panel lengths along the principal directions.
    pub anisotropy: f64,
    /// Panels that are not as they should be.
    pub invalid: usize,
    /// Share of hexagons among the panels inside.
    pub hex: f64,
    /// Largest distance between panels and surface either way, away from the boundary, over the diagonal.
    pub deviation: f64,
    /// Least clearance, mean edges.
    pub clearance: f64,
}

/// A panelling for one anisotropy.
pub(super) struct Attempt {
    pub summary: AttemptSummary,
    planar: bool,
    pub layout: LayoutStatistics,
    pub result: Optimised,
    pub left: Left,
    pub reported: TriangleSurface,
    pub factorisations: usize,
    pub repairs: Vec<RepairRound>,
}

impl Attempt {
    /// Whether nothing else needs to be tried.
    pub(super) fn is_good(&self, options: &MeshOptions) -> bool {
        let s = &self.summary;
        s.invalid == 0 && s.deviation <= GOOD_DEVIATION && s.clearance >= options.good_clearance
    }

    /// What attempts are compared by, smaller is better: valid first, then close, clear and regular.
    pub(super) fn cost(&self) -> f64 {
        let s = &self.summary;
        let invalid = if self.planar { 0.0 } else { 1e6 } + 100.0 * s.invalid as f64;
        let far = 10.0 * (s.deviation / GOOD_DEVIATION - 1.0).max(0.0);
        let tight = (0.15 / s.clearance.max(1e-3) - 1.0).max(0.0);
        invalid + far + tight + (1.0 - s.hex) + s.deviation / GOOD_DEVIATION * 0.1
    }
}

/// Deviation, over the diagonal, with which no other anisotropy is tried: a little below the usual tolerance of 0.5 %.
const GOOD_DEVIATION: f64 = 4.5e-3;

/// What rounds of the repair loop are compared by, the first difference counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Badness {
    not_planar: bool,
    invalid: usize,
    tight: usize,
}

/// Rounds of the repair loop at the most that only give tight panels more room.
const MAX_POLISHES: usize = 2;

/// Layout, optimiser and the repair loop for one anisotropy.
pub(super) fn attempt(
    ground: &Ground,
    anisotropy: f64,
    clock: &mut Clock<'_>,
) -> Result<Attempt, PipelineError> {
    let (options, progress) = (&ground.options, clock.progress);
    let settings = direction_options(options, anisotropy);
    let field = Field::new(&ground.smooth, ground.panels, options, &settings, clock)?;
    let fine = FineSurface::new(ground, &field);
    let mut seeds = field.seeds.clone();
    let mut layout = clock.stage("layout", || layout::panelling(&fine.cells(), &seeds))??;
    let target = SurfaceTarget::new(ground.close_to(&fine.surface));
    let reported = ground.reported(&fine.surface);
    let mut repairs = Vec::new();
    let mut factorisations = 0;
    let mut best: Option<(Badness, Optimised, Left)> = None;
    let mut polished = 0;
    loop {
        let result = clock.timed("optimise", || {
            optimise::optimise(&layout, &target, &options.optimise, progress)
        })?;
        factorisations += result.runs.iter().map(|r| r.factorisations).sum::<usize>();
        let trimmed = clock.timed("trim", || ground.trimmed(&result.mesh, &fine.surface))?;
        let violations = clock.timed("validate", || between_panels(&trimmed.mesh, reported));
        let offenders = offenders_left(&result.offenders, &trimmed);
        let invalid = invalid_panels(&offenders, &trimmed, &violations, options.boundary);
        let tight = tight_panels(&trimmed, options);
        let badness = Badness {
            not_planar: !is_planar(&offenders),
            invalid: invalid.len(),
            tight: tight.len(),
        };
        if best.as_ref().is_none_or(|b| badness < b.0) {
            let left = Left {
                start: laid_out(&layout, &trimmed),
                trimmed,
                offenders,
                violations,
            };
            best = Some((badness, result, left));
        }
        let dropped = if invalid.is_empty() { tight } else { invalid };
        polished += usize::from(badness.invalid == 0);
        let over = polished > MAX_POLISHES || repairs.len() >= options.max_repairs;
        if dropped.is_empty() || over || progress.is_cancelled() {
            break;
        }
        let before = seeds.len();
        drop_seeds(&mut seeds, &layout, &dropped);
        repairs.push(RepairRound {
            panels: layout.mesh.topology().n_faces(),
            dropped: before - seeds.len(),
        });
        match clock.timed("layout", || layout::panelling(&fine.cells(), &seeds)) {
            Ok(next) => layout = next,
            Err(_) => break,
        }
    }
    let (badness, result, left) = best.expect("the loop runs at least once");
    let summary = clock.timed("validate", || {
        summarise(&left.trimmed.mesh, reported, anisotropy, badness.invalid)
    });
    Ok(Attempt {
        summary,
        planar: !badness.not_planar,
        layout: field.statistics,
        result,
        left,
        reported: reported.clone(),
        factorisations,
        repairs,
    })
}

fn summarise(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    anisotropy: f64,
    invalid: usize,
) -> AttemptSummary {
    let measures = phex_mesh::measure(mesh);
    let deviation = phex_mesh::deviation(mesh, surface);
    AttemptSummary {
        anisotropy,
        invalid,
        hex: measures.hex.unwrap_or(1.0),
        deviation: deviation.deviation_max.max(deviation.coverage_inner_max),
        clearance: measures.clearance.min,
    }
}

/// What a round of the repair loop leaves.
pub(super) struct Left {
    pub start: PolygonSoup,
    pub trimmed: Trimmed,
    pub offenders: Vec<Offender>,
    pub violations: Vec<Violation>,
}

/// The panels of a layout of which something is left.
fn laid_out(layout: &Layout, trimmed: &Trimmed) -> PolygonSoup {
    let kept: BTreeSet<FaceId> = trimmed.parent.iter().copied().collect();
    let mut soup = layout.mesh.to_soup();
    let mut numbers = layout.mesh.topology().faces();
    soup.faces
        .retain(|_| numbers.next().is_some_and(|f| kept.contains(&f)));
    soup
}

/// Violations that concern several panels: the optimiser's own list has the others.
pub(super) fn between_panels(mesh: &HexMesh, surface: &TriangleSurface) -> Vec<Violation> {
    phex_mesh::violations(mesh, Some(surface), &ValidateOptions::default())
}

/// Panels whose seeds the next round drops: those with a wrong shape; if there are none, those farthest from planar,
/// because one blocked panel keeps all others from their planes.
fn invalid_panels(
    offenders: &[Offender],
    trimmed: &Trimmed,
    violations: &[Violation],
    boundary: Boundary,
) -> BTreeSet<FaceId> {
    let topology = trimmed.mesh.topology();
    let crooked = |o: &&Offender| !matches!(o.fault, Fault::NotPlanar { .. });
    let shape = |v: &&Violation| !matches!(v, Violation::NotPlanar { .. });
    let located = violations.iter().filter(shape);
    let mut invalid: BTreeSet<FaceId> = offenders.iter().filter(crooked).map(|o| o.face).collect();
    invalid.extend(located.flat_map(|v| v.faces(topology)));
    if boundary != Boundary::Whole {
        invalid.extend(trim::small_rim_panels(&trimmed.mesh));
    }
    if invalid.is_empty() {
        invalid.extend(farthest_from_planar(offenders));
    }
    invalid.iter().map(|f| trimmed.parent[*f]).collect()
}

/// Panels with less than a good clearance: mostly one that is much smaller than its neighbours.
fn tight_panels(trimmed: &Trimmed, options: &MeshOptions) -> BTreeSet<FaceId> {
    let mesh = &trimmed.mesh;
    let limit = options.good_clearance * mesh.mean_edge();
    let faces = FlatFace::all(mesh);
    let tight = faces.enumerate().filter(|(f, face)| {
        // A cut says nothing of the panel.
        let cut = options.boundary != Boundary::Whole && mesh.topology().is_boundary_face(*f);
        !cut && face.clearance().distance < limit
    });
    tight.map(|(f, _)| trimmed.parent[f]).collect()
}

fn farthest_from_planar(offenders: &[Offender]) -> impl Iterator<Item = FaceId> {
    let distance = |o: &Offender| match o.fault {
        Fault::NotPlanar { distance } => distance,
        _ => 0.0,
    };
    let worst = offenders.iter().map(distance).fold(0.0, f64::max);
    let far = offenders.iter().filter(move |o| distance(o) > 0.3 * worst);
    far.map(|o| o.face)
}

/// Offenders of which something is left, with the numbers of their parts.
fn offenders_left(offenders: &[Offender], trimmed: &Trimmed) -> Vec<Offender> {
    let parts = |o: &Offender| {
        let (face, fault) = (o.face, o.fault);
        let own = trimmed.parent.enumerate().filter(move |(_, p)| **p == face);
        own.map(move |(face, _)| Offender { face, fault })
    };
    offenders.iter().flat_map(parts).collect()
}

fn is_planar(offenders: &[Offender]) -> bool {
    let planar = |o: &Offender| !matches!(o.fault, Fault::NotPlanar { .. });
    offenders.iter().all(planar)
}

/// Drops the seeds of invalid panels, never those of two neighbours in one round: one of them grows into the gap.
fn drop_seeds(seeds: &mut Vec<Seed>, layout: &Layout, invalid: &BTreeSet<FaceId>) {
    let topology = layout.mesh.topology();
    let mut chosen: BTreeSet<FaceId> = BTreeSet::new();
    for &f in invalid {
        let twins = topology.face_half_edges(f).filter_map(|h| topology.twin(h));
        if !twins.map(|t| topology.face(t)).any(|g| chosen.contains(&g)) {
            chosen.insert(f);
        }
    }
    let dropped: HashSet<VertexId> = chosen.iter().map(|f| layout.face_seed[*f]).collect();
    seeds.retain(|s| !dropped.contains(&s.vertex));
}
