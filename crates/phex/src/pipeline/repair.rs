//! Layout, optimiser and the repair loop for a lattice of one kind.

use super::field::{Field, FineSurface, Way, direction_options, resolved};
use super::portfolio::GOOD_DEVIATION;
use super::{Clock, MeshOptions, PipelineError, RepairRound, rim};
use crate::directions::guides::Cone;
use crate::ground::{Beyond, Ground};
use crate::layout::seeds::Seed;
use crate::layout::{self, Layout, LayoutError, LayoutStatistics};
use crate::optimise::{self, Fault, Offender, Optimised, SurfaceTarget};
use crate::trim::{Boundary, Trimmed};
use phex_mesh::{
    Deviation, FaceId, FlatFace, HexMesh, PolygonSoup, TriangleSurface, ValidateOptions, Vec3,
    VertexId, Violation,
};
use std::collections::{BTreeSet, HashSet};

/// A panelling made in one way.
pub(super) struct Attempt {
    /// Panels that are not as they should be.
    pub invalid: usize,
    pub planar: bool,
    pub layout: LayoutStatistics,
    /// Cones of the direction field, normalised.
    pub cones: Vec<Cone>,
    /// See [`Field::regular_possible`].
    pub regular_possible: bool,
    pub result: Optimised,
    pub left: Left,
    pub reported: TriangleSurface,
    pub beyond: Option<Beyond>,
    pub factorisations: usize,
    pub repairs: Vec<RepairRound>,
}

/// What rounds of the repair loop are compared by, the first difference counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Badness {
    not_planar: bool,
    invalid: usize,
    bare: usize,
    tight: usize,
}

/// Rounds of the repair loop at the most on a mesh that is valid: they add panels where the surface stands off, or give tight
/// panels more room.
const MAX_POLISHES: usize = 3;
/// Share of the panels up to which a round adds panels, and a number that is always allowed: where the surface stands off in more
/// places than that, panels are too large everywhere, and more of them here and there only spoil the rows.
const MAX_ADDED_SHARE: f64 = 0.02;
const MAX_ADDED: usize = 2;
/// Distance of these places from each other, mean edges.
const ADDED_APART: f64 = 3.0;

/// Layout, optimiser and the repair loop for a lattice of one kind.
pub(super) fn attempt(
    ground: &Ground,
    way: Way,
    clock: &mut Clock<'_>,
) -> Result<Attempt, PipelineError> {
    let (options, progress) = (&way.options(&ground.options), clock.progress);
    let settings = direction_options(options, way.anisotropy);
    let seamless = match way.seamless {
        true => Some(resolved(ground, options, &settings, clock)?),
        false => None,
    };
    let ground = seamless.as_ref().unwrap_or(ground);
    let level = match way.seamless {
        true => ground.smooth.levels.len() - 1,
        false => ground.field_level(options),
    };
    let field = Field::new(ground, level, options, &settings, clock)?;
    let fine = FineSurface::new(ground, &field);
    let mut seeds = field.placed.seeds.clone();
    let mut layout = clock.stage("layout", || calm_panels(&fine, &seeds))??;
    let target = SurfaceTarget::new(ground.close_to(&fine.surface));
    let reported = ground.reported(&fine.surface);
    let beyond = ground.beyond(&fine.surface);
    let reach = beyond.as_ref().map_or(reported, |b| &b.smooth);
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
        let deviation = clock.timed("validate", || {
            phex_mesh::deviation_beyond(&trimmed.mesh, reported, reach)
        });
        let bare = bare_places(&trimmed.mesh, reported, &deviation, options);
        let badness = Badness {
            not_planar: !is_planar(&offenders),
            invalid: invalid.len(),
            bare: bare.len(),
            tight: tight.len(),
        };
        if best.as_ref().is_none_or(|b| badness < b.0) {
            let left = Left {
                start: laid_out(&layout, &trimmed),
                trimmed,
                offenders,
                violations,
                deviation: inner_deviation(&deviation),
            };
            best = Some((badness, result, left));
        }
        let edit = Edit::new(invalid, bare, tight);
        polished += usize::from(badness.invalid == 0);
        let over = polished > MAX_POLISHES || repairs.len() >= options.max_repairs;
        if edit.is_empty() || over || progress.is_cancelled() {
            break;
        }
        repairs.push(edit.apply(&mut seeds, &layout, &fine.surface));
        match clock.timed("layout", || calm_panels(&fine, &seeds)) {
            Ok(next) => layout = next,
            Err(_) => break,
        }
    }
    let (badness, mut result, mut left) = best.expect("the loop runs at least once");
    let held = clock.timed("optimise", || {
        rim::to_boundary(&mut left, reported, options, progress)
    })?;
    result.runs.extend(held);
    Ok(Attempt {
        invalid: badness.invalid,
        planar: !badness.not_planar,
        layout: field.placed.statistics,
        cones: field.cones(&ground.smooth),
        regular_possible: field.regular_possible(&ground.smooth),
        result,
        left,
        reported: reported.clone(),
        beyond,
        factorisations,
        repairs,
    })
}

fn calm_panels(fine: &FineSurface, seeds: &[Seed]) -> Result<Layout, LayoutError> {
    layout::panelling(&fine.cells(), seeds).map(layout::calmed)
}

/// What a round of the repair loop leaves.
pub(super) struct Left {
    pub start: PolygonSoup,
    pub trimmed: Trimmed,
    pub offenders: Vec<Offender>,
    pub violations: Vec<Violation>,
    /// Largest distance between panels and surface either way, away from the boundary, over the diagonal.
    pub deviation: f64,
}

/// Largest distance between panels and surface either way, away from the boundary.
pub(super) fn inner_deviation(deviation: &Deviation) -> f64 {
    deviation.deviation_max.max(deviation.coverage_inner_max)
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
        invalid.extend(phex_mesh::small_rim_faces(&trimmed.mesh));
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

/// What a round of the repair loop changes.
struct Edit {
    drop: BTreeSet<FaceId>,
    add: Vec<Vec3>,
}

impl Edit {
    /// Invalid panels come first, then places where the surface stands off, then tight panels.
    fn new(invalid: BTreeSet<FaceId>, bare: Vec<Vec3>, tight: BTreeSet<FaceId>) -> Self {
        match (invalid.is_empty(), bare.is_empty()) {
            (false, _) => Self::dropping(invalid),
            (true, true) => Self::dropping(tight),
            (true, false) => Self {
                drop: BTreeSet::new(),
                add: bare,
            },
        }
    }

    fn dropping(drop: BTreeSet<FaceId>) -> Self {
        Self {
            drop,
            add: Vec::new(),
        }
    }

    fn is_empty(&self) -> bool {
        self.drop.is_empty() && self.add.is_empty()
    }

    fn apply(&self, seeds: &mut Vec<Seed>, layout: &Layout, fine: &TriangleSurface) -> RepairRound {
        let before = seeds.len();
        drop_seeds(seeds, layout, &self.drop);
        let dropped = before - seeds.len();
        let before = seeds.len();
        let known: HashSet<VertexId> = seeds.iter().map(|s| s.vertex).collect();
        let places = fine.closest_points(&self.add).into_iter();
        let corners = places.map(|p| fine.topology().face_vertices(p.triangle)[0]);
        seeds.extend(corners.filter(|v| !known.contains(v)).map(Seed::at));
        seeds.sort_by_key(|s| s.vertex);
        seeds.dedup_by_key(|s| s.vertex);
        RepairRound {
            panels: layout.mesh.topology().n_faces(),
            dropped,
            added: seeds.len() - before,
        }
    }
}

/// Places where the surface stands off from the panels farther than is good, the farthest first.
fn bare_places(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    deviation: &Deviation,
    options: &MeshOptions,
) -> Vec<Vec3> {
    let limit = GOOD_DEVIATION * deviation.diagonal;
    let distances = deviation.coverage_distance.enumerate();
    let mut far: Vec<(VertexId, f64)> = distances
        .filter(|(v, d)| **d > limit && deviation.inside[*v])
        .map(|(v, d)| (v, *d))
        .collect();
    far.extend(rim::bare_rim(mesh, surface, options, limit));
    far.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let apart = ADDED_APART * mesh.mean_edge();
    let panels = mesh.topology().n_faces() as f64;
    let most = MAX_ADDED.max((MAX_ADDED_SHARE * panels) as usize);
    let mut places: Vec<Vec3> = Vec::new();
    for (v, _) in far {
        let p = surface.positions()[v];
        if places.iter().all(|q| (p - q).norm() > apart) {
            places.push(p);
        }
        if places.len() > most {
            return Vec::new();
        }
    }
    places
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
