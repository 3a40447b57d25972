//! A symmetric mesh: the part between mirror planes is panelled, the rest is its image.
//!
//! Rows run along the planes or at right angles to them, and lattice points lie in them, so that
//! panels there are cut in two or have an edge in the plane. A group without mirror planes is not
//! used: the seam of its domain would be free, and a lattice on the domain has no reason to meet
//! itself there.

use super::domain::{Ground, without_long_triangles};
use super::finish::JudgedMesh;
use super::laid_out::LaidOut;
use super::repeated::made_equal;
use super::rim::corner_points;
use super::sized::mean_length;
use super::{Candidate, Clock, Effort, MeshOptions, MeshRun, Method, PipelineError, Statistics};
use crate::layout::same_topology;
use crate::optimise::{self, BoundaryHold, PUT_THERE, Quotient, Steering, SurfaceTarget};
use crate::progress::{Event, Progress};
use crate::quality::{Assessment, Judge, Limits, Merit, References};
use crate::repetition::RepetitionTask;
use crate::search::{AreaField, Site, search};
use crate::smooth_surface::{self, SmoothTarget};
use crate::symmetry::{
    self, FoldedTarget, Found, Group, Isometry, Orbits, SYMMETRY_TOLERANCE, Symmetries, Symmetry,
    SymmetrySummary, WholePanels,
};
use crate::trim::Boundary;
use nalgebra::Matrix3;
use phex_mesh::{HexMesh, PerFace, TriangleSurface, Vec3};
use phex_numeric::Outcome;
use std::cmp::Ordering;

/// Numbers of panels, over the one that is asked for, that are tried until panels are within
/// limits: it is chance whether every cell at a mirror plane is large enough to be a panel, and how
/// many are irregular.
const OTHER_COUNTS: [f64; 4] = [1.04, 0.96, 1.08, 0.92];
/// Numbers that are tried at the most where the first is within limits; half as many as there are
/// images, since a try costs less the more there are.
const ENOUGH: u32 = 4;
/// Error of the number of panels, as a logarithm, up to which others alone count: among numbers
/// that are tried with one group, and among groups.
const MISCOUNT: f64 = 0.12;
const MISCOUNT_OF_GROUPS: f64 = 0.2;

/// A symmetric mesh of a normalised surface; `None` where there is no group to use, or panels
/// can't follow it, which is said.
///
/// # Errors
/// As [`mesh_surface`](super::mesh_surface).
pub(super) fn mesh_with_panels(
    surface: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<Option<MeshRun>, PipelineError> {
    match symmetric(surface, panels, options, clock) {
        Ok(run) => Ok(Some(run)),
        Err(NotSymmetric::Pipeline(error)) => Err(error),
        // What is asked for by name is had or refused; what is only welcome is done without.
        Err(NotSymmetric::Symmetry(reason)) if options.symmetry == Symmetry::Auto => {
            let message = format!("panels are not symmetric: {reason}");
            clock.progress.report(&Event::Note { message });
            Ok(None)
        }
        Err(NotSymmetric::Symmetry(reason)) => Err(PipelineError::Symmetry {
            asked: options.symmetry,
            reason,
        }),
    }
}

fn symmetric(
    surface: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, NotSymmetric> {
    let progress = clock.progress;
    if let Some(reason) = not_symmetric(options) {
        return Err(reason.to_owned().into());
    }
    let smooth = clock.stage("target", || smooth_target(surface, panels, options))?;
    let whole = smooth.finest();
    let has = clock.stage("symmetry", || symmetry::find(whole, SYMMETRY_TOLERANCE))?;
    let found = has.mirrored.as_ref().ok_or_else(|| without_mirrors(&has))?;
    let across = half_turn_across(found, options.symmetry);
    let found = across.as_ref().unwrap_or(found);
    let groups = used(found, whole, panels, options.symmetry)?;
    let facets = References::of_facets(Some(surface));
    let judge = Judge::new(whole, facets, options.limits());
    let made = |group: Group, share: f64| {
        let panels = (share * panels as f64).round() as usize;
        let domain = DomainPanels::new(whole, found, group, panels, options)?;
        let run = domain.mesh(clock)?;
        let judgement = judge.whole(&run.mesh, run.wished.as_slice());
        Ok(SymmetricRun {
            merit: judgement.merit,
            avoidable: judgement.irregular_and_uneven(),
            run,
        })
    };
    let names = names_of(&groups);
    let SymmetricRun { merit, mut run, .. } = match best_of(&groups, panels, made, progress) {
        Err(NotSymmetric::Symmetry(reason)) => {
            return Err(format!("with the symmetry {names}: {reason}").into());
        }
        made => made?,
    };
    // What is there is kept where there is no time for anything else.
    let is_welcome = options.symmetry == Symmetry::Auto && !progress.is_cancelled();
    if is_welcome && !merit.is_within() {
        let smooth = Some(whole);
        let checks = Assessment::new(
            &run.mesh,
            References { smooth, ..facets },
            &options.limits(),
        );
        let failed: Vec<&str> = checks.failures().map(|check| check.name).collect();
        let failed = failed.join(", ");
        return Err(
            format!("with the symmetry {names} panels are outside limits: {failed}").into(),
        );
    }
    run.statistics.target_vertices = Statistics::of(&smooth, panels).target_vertices;
    run.statistics.panels_asked = panels;
    if let Some(summary) = &run.statistics.symmetry {
        let irregular = phex_mesh::irregular_faces(run.mesh.topology());
        let price = price_of(irregular, merit.is_within());
        let message = format!("{}{price}", followed(summary, &groups));
        progress.report(&Event::Note { message });
    }
    Ok(run)
}

fn smooth_target(surface: &TriangleSurface, panels: usize, options: &MeshOptions) -> SmoothTarget {
    let cut = without_long_triangles(surface, panels, options);
    let near = cut.as_ref().map_or(surface, |c| &c.surface);
    let vertices = options.cell_vertices(panels) as usize;
    smooth_surface::smooth_target(near, vertices, &options.target)
}

fn within_tolerance() -> String {
    format!("within {} % of its diagonal", 100.0 * SYMMETRY_TOLERANCE)
}

/// What is said of a surface without mirror planes: whether it has a rotation, or nearly such a
/// plane.
fn without_mirrors(has: &Symmetries) -> String {
    let within = within_tolerance();
    let nearly = has.nearly.map_or_else(String::new, |off| {
        let percent = 100.0 * off;
        format!(": its image in the best one is {percent:.3} % off")
    });
    match has.turns {
        Some(n) => format!(
            "the surface has a rotation of order {n} and no mirror plane {within}{nearly}, and panels follow mirror planes \
             alone"
        ),
        None => format!("the surface has no mirror plane {within}{nearly}"),
    }
}

fn names_of(groups: &[Group]) -> String {
    let names: Vec<String> = groups.iter().map(|group| group.name()).collect();
    names.join(", ")
}

/// Which group panels follow, and which of the larger ones they could not.
fn followed(summary: &SymmetrySummary, groups: &[Group]) -> String {
    let is_larger = |group: &&Group| group.name() != summary.group;
    let larger = groups.iter().take_while(is_larger).count();
    match larger {
        0 => summary.sentence(),
        _ => format!(
            "{}; with {} they are outside limits, less regular or even, or not as many as asked for",
            summary.sentence(),
            names_of(&groups[..larger])
        ),
    }
}

/// What a symmetry may have cost, for the end of a sentence.
fn price_of(irregular: usize, is_within: bool) -> String {
    let irregular = match irregular {
        0 => None,
        1 => Some("one panel is irregular without need".to_owned()),
        n => Some(format!("{n} panels are irregular without need")),
    };
    let outside = (!is_within).then(|| "panels are outside limits".to_owned());
    let told: Vec<String> = irregular.into_iter().chain(outside).collect();
    match told.is_empty() {
        true => String::new(),
        false => format!("; {}, perhaps because of the symmetry", told.join(" and ")),
    }
}

/// What is told where panels could have symmetries of the surface and were not asked to.
pub(super) fn unused(ground: &Ground) -> Option<String> {
    let options = &ground.options;
    if options.symmetry != Symmetry::None || not_symmetric(options).is_some() {
        return None;
    }
    // It is a hint: the level of the directions, with a quarter of the vertices, is enough.
    let level = &ground.smooth.levels[ground.field_level(options)];
    symmetry::find(level, SYMMETRY_TOLERANCE).mirrored?;
    // Which group it is the full surface decides, where it is asked for.
    let told = "the surface has mirror planes that panels do not follow; `--symmetry auto` tries whether they can, and may take twice as long";
    Some(told.to_owned())
}

/// A symmetric mesh and what the judge says of it.
struct SymmetricRun {
    merit: Merit,
    /// What irregular and uneven panels cost: another symmetry may have none.
    avoidable: f64,
    run: MeshRun,
}

impl SymmetricRun {
    /// By how much the number of panels misses the one that is asked for, as a logarithm.
    fn miss(&self, panels: usize) -> f64 {
        (self.run.mesh.topology().n_faces() as f64 / panels as f64).ln()
    }

    /// What counts before the cost, smaller is better: whether panels are outside limits, and
    /// whether their number is off by more than `most`.
    fn rank(&self, (panels, most): WantedCount) -> [bool; 2] {
        [!self.merit.is_within(), self.miss(panels).abs() > most]
    }

    /// Whether panels are within limits, and about as many as they are to be.
    fn is_usable(&self, wanted: WantedCount) -> bool {
        self.rank(wanted) == [false; 2]
    }

    /// Whether regular and even panels with `fewer` images each, as a factor, could be better.
    fn could_be_better(&self, fewer: f64) -> bool {
        Merit::default().counting_fewer_images(fewer).cost < self.avoidable
    }

    /// Whether it is better than another one, of which each panel has more images by a factor.
    fn is_better(&self, other: &Self, wanted: WantedCount, more: f64) -> bool {
        match self.rank(wanted).cmp(&other.rank(wanted)) {
            Ordering::Equal => (self.merit.counting_fewer_images(more)).is_better(&other.merit),
            order => order.is_lt(),
        }
    }
}

type SymmetricAttempt = Result<SymmetricRun, NotSymmetric>;

/// The number of panels that is asked for, and by how much one may miss it, as a logarithm.
type WantedCount = (usize, f64);

/// The best mesh that groups lead to, one after the other while panels are outside limits, or too
/// many or too few, or a smaller group could be worth it; `made` makes one for a group and a number
/// of panels over the one that is asked for.
fn best_of(
    groups: &[Group],
    panels: usize,
    mut made: impl FnMut(Group, f64) -> SymmetricAttempt,
    progress: &dyn Progress,
) -> SymmetricAttempt {
    let mut best = best_count(groups[0], panels, &mut made, progress);
    let mut of = groups[0];
    let wanted = (panels, MISCOUNT_OF_GROUPS);
    for group in &groups[1..] {
        let fewer = f64::from(of.order()) / f64::from(group.order());
        let is_over = match &best {
            Err(error) => matches!(error, NotSymmetric::Pipeline(_)),
            Ok(best) => best.is_usable(wanted) && !best.could_be_better(fewer),
        };
        if progress.is_cancelled() || is_over {
            break;
        }
        let next = best_count(*group, panels, &mut made, progress);
        let is_better = match (&best, &next) {
            (Ok(first), Ok(second)) => second.is_better(first, wanted, fewer),
            _ => next.is_ok(),
        };
        if is_better {
            (best, of) = (next, *group);
        }
    }
    best
}

/// The best mesh of a group, of numbers of panels near to the one that is asked for.
fn best_count(
    group: Group,
    panels: usize,
    mut made: impl FnMut(Group, f64) -> SymmetricAttempt,
    progress: &dyn Progress,
) -> SymmetricAttempt {
    let enough = (group.order() / 2).clamp(1, ENOUGH) as usize;
    let wanted = (panels, MISCOUNT);
    // Panels in the planes count once: how many lie there is not known before.
    let mut excess: Vec<f64> = Vec::new();
    let mut best = made(group, 1.0);
    excess.extend(best.as_ref().ok().map(|run| run.miss(panels)));
    for (done, count) in (1..).zip(OTHER_COUNTS) {
        let is_over = matches!(best, Err(NotSymmetric::Pipeline(_))) || progress.is_cancelled();
        let is_enough = |best: &SymmetricRun| {
            let is_regular = phex_mesh::irregular_faces(best.run.mesh.topology()) == 0;
            best.is_usable(wanted) && (done >= enough || is_regular)
        };
        if is_over || best.as_ref().is_ok_and(is_enough) {
            break;
        }
        let mean = excess.iter().sum::<f64>() / excess.len().max(1) as f64;
        let share = count * (-mean).exp();
        let next = made(group, share);
        excess.extend((next.as_ref().ok()).map(|run| run.miss(panels) - share.ln()));
        let is_better = match (&best, &next) {
            (Ok(first), Ok(second)) => second.is_better(first, wanted, 1.0),
            _ => next.is_ok(),
        };
        if is_better {
            best = next;
        }
    }
    best
}

/// What keeps panels from following the symmetries of a surface, whichever it has.
fn not_symmetric(options: &MeshOptions) -> Option<&'static str> {
    let guides = &options.directions.guides;
    let lines = !guides.lines.is_empty() || !guides.cones.is_empty();
    let reasons = [
        (
            options.method != Method::Lattice,
            "rows of a brick wall follow curves of the whole surface and not of its parts",
        ),
        (
            options.boundary != Boundary::Snap,
            "panels that are cut at the boundary or stick out of it are not laid out between mirror planes; the boundary can be `snap`",
        ),
        (
            lines,
            "guide lines and cones hold for the whole surface and not for its parts",
        ),
        (
            !options.steering.is_empty(),
            "held vertices hold for the whole surface and not for its parts",
        ),
        (
            options.size_field.is_some(),
            "a field of sizes holds for the whole surface and not for its parts",
        ),
    ];
    let reason = reasons.into_iter().find(|(is_set, _)| *is_set);
    reason.map(|(_, reason)| reason)
}

/// Why there is no symmetric mesh.
enum NotSymmetric {
    /// Nor is there another one.
    Pipeline(PipelineError),
    /// What is in the way of symmetry alone.
    Symmetry(String),
}

impl From<String> for NotSymmetric {
    fn from(reason: String) -> Self {
        Self::Symmetry(reason)
    }
}

impl<E: Into<PipelineError>> From<E> for NotSymmetric {
    fn from(error: E) -> Self {
        match error.into() {
            PipelineError::Cancelled => Self::Pipeline(PipelineError::Cancelled),
            error => Self::Symmetry(error.to_string()),
        }
    }
}

/// What was found about the axis of its half turn, where one is wanted that is about another axis
/// than the rotations that were found.
fn half_turn_across(found: &Found, wanted: Symmetry) -> Option<Found> {
    let is_about_axis = found.revolution || found.group.rotations.is_multiple_of(2);
    let is_other = wanted == Symmetry::Turns(2) && !is_about_axis;
    found.half_turn_across().filter(|_| is_other)
}

/// The parts of the group that panels may follow, one after the other until they are within limits.
///
/// # Errors
/// What the surface has instead of what is wanted.
fn used(
    found: &Found,
    surface: &TriangleSurface,
    panels: usize,
    wanted: Symmetry,
) -> Result<Vec<Group>, String> {
    let (all, level) = (found.group.rotations, found.group.level);
    let rotations = match wanted {
        Symmetry::Mirror => {
            return Ok(vec![Group {
                rotations: 1,
                level: false,
            }]);
        }
        // The largest order is the one that was looked for: others may hold as well.
        Symmetry::Turns(n)
            if found.revolution
                || all.is_multiple_of(n)
                || symmetry::has_turn(surface, &found.frame, n, SYMMETRY_TOLERANCE) =>
        {
            vec![n]
        }
        Symmetry::Turns(n) => {
            return Err(format!(
                "the surface has the symmetry {}, and no rotation of order {n} {}",
                found.group.name(),
                within_tolerance()
            ));
        }
        _ if found.revolution => fewer_turns(turns_of_revolution(found, surface, panels)),
        _ => fewer_turns(all),
    };
    let group = |rotations| Group { rotations, level };
    let mut groups: Vec<Group> = rotations.into_iter().map(group).collect();
    if level && wanted == Symmetry::Auto {
        groups.push(Group {
            rotations: 1,
            level: false,
        });
    }
    Ok(groups)
}

/// Rotations of the largest of the smaller groups that is tried.
const FEW_TURNS: u32 = 6;

/// A number of rotations, the largest of its divisors that is small, and 1.
fn fewer_turns(all: u32) -> Vec<u32> {
    let small = (1..=FEW_TURNS.min(all / 2)).rev();
    let divisor = small.into_iter().find(|n| all.is_multiple_of(*n));
    let mut turns = vec![all, divisor.unwrap_or(1), 1];
    turns.dedup();
    turns
}

/// Panels round a surface of revolution for each of its rotations.
const PANELS_A_TURN: f64 = 4.0;

/// The order of rotation for a surface of revolution: six where the axis meets the surface, for a
/// hexagon there, else so that few panels lie in each part.
fn turns_of_revolution(found: &Found, surface: &TriangleSurface, panels: usize) -> u32 {
    let radius = |p: &Vec3| found.frame.inside(*p).xy().norm();
    let radii: Vec<f64> = surface.positions().iter().map(radius).collect();
    let length = mean_length(surface, panels);
    let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
    if least < length {
        return 6;
    }
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    let round = std::f64::consts::TAU * mean / length;
    (round / PANELS_A_TURN).round().clamp(2.0, 24.0) as u32
}

/// Areas that panels are to have.
fn areas_of(laid: &LaidOut) -> AreaField<'_> {
    AreaField {
        surface: &laid.surface,
        wish: &laid.wish,
    }
}

/// Panels brought to the boundary, where there is one and they are no worse for it.
fn on_boundary(
    mesh: HexMesh,
    site: &Site<'_>,
    target: &FoldedTarget<'_>,
    quotient: &Quotient,
    clock: &mut Clock<'_>,
) -> Result<HexMesh, NotSymmetric> {
    let Some(hold) = &site.hold else {
        return Ok(mesh);
    };
    let progress = clock.progress;
    let next = clock.timed("optimise", || {
        optimise::onto_boundary(&mesh, target, hold, quotient, site.options, progress)
    })?;
    let mut now = JudgedMesh::new(mesh, site);
    now.offer(next.map(|next| next.mesh));
    Ok(now.mesh)
}

/// A fundamental domain on its way to panels, scaled to diagonal 1 about a point of all planes.
struct DomainPanels<'a> {
    whole: &'a TriangleSurface,
    found: &'a Found,
    group: Group,
    surface: TriangleSurface,
    scale: f64,
    panels: usize,
    options: MeshOptions,
}

impl<'a> DomainPanels<'a> {
    fn new(
        whole: &'a TriangleSurface,
        found: &'a Found,
        group: Group,
        panels: usize,
        options: &MeshOptions,
    ) -> Result<Self, NotSymmetric> {
        let inside = whole.mapped(|p| found.frame.inside(*p));
        let part = symmetry::cut(&inside, &group.walls())?;
        let scale = part.diagonal();
        let surface = part.mapped(|p| p / scale);
        // Panels in mirror planes are half there: two in three of them, about, are cut.
        let each = mean_length(whole, panels) / scale;
        let walls = group.walls();
        let sides = surface.topology().boundary_edges().filter(|e| {
            let ends = surface.topology().edge_vertices(*e);
            let on = |n: &Vec3| {
                ends.iter()
                    .all(|v| n.dot(&surface.positions()[*v]).abs() < PUT_THERE)
            };
            walls.iter().any(on)
        });
        let cut: f64 = sides.map(|e| surface.edge_length(e)).sum();
        let share = surface.area() / (whole.area() / (scale * scale));
        let count = panels as f64 * share + 0.4 * cut / each;
        let mut options = options.clone();
        options.boundary = Boundary::Snap;
        options.symmetry = Symmetry::None;
        options.directions.mirrors = group.mirrors();
        let deviation = &mut options.optimise.max_deviation;
        *deviation = deviation.map(|d| d / scale);
        options.optimise.panels = options.optimise.panels.scaled(1.0 / scale);
        options.repeat_rel = options.repeat_rel.map(|r| r * whole.diagonal() / scale);
        Ok(Self {
            whole,
            found,
            group,
            surface,
            scale,
            panels: count.round().max(1.0) as usize,
            options,
        })
    }

    fn mesh(&self, clock: &mut Clock<'_>) -> Result<MeshRun, NotSymmetric> {
        let ground = clock.stage("target", || {
            Ground::new(&self.surface, self.panels, &self.options)
        })?;
        let candidate = Candidate::first(&self.options);
        let options = candidate.options(&self.options);
        let laid = LaidOut::new(&ground, candidate, clock)?;
        let ground = laid.ground(&ground);
        let layout = &laid.layout;
        let parts = symmetry::completed(layout, self.group)?;
        let parts = parts.calmed(self.group);
        let target = FoldedTarget::new(ground.close_to(&laid.surface), self.group.walls());
        let progress = clock.progress;
        let optimised = clock.timed("optimise", || {
            optimise::optimise_quotient(
                &parts.layout,
                &parts.quotient,
                &target,
                &options.optimise,
                progress,
            )
        })?;
        let (mesh, before) =
            self.finished(&parts, optimised.mesh, &target, (ground, &laid), clock)?;
        let mut statistics = Statistics {
            layout: laid.statistics,
            ..Statistics::default()
        };
        statistics.add(optimised.run);
        self.assembled(
            (&mesh, &areas_of(&laid).wished(&mesh)),
            before.as_ref(),
            (statistics, optimised.outcome),
            clock,
        )
    }

    /// Panels brought to the boundary, and searched; and as they were before edges were made equal,
    /// where that is asked for.
    fn finished(
        &self,
        parts: &WholePanels,
        mesh: HexMesh,
        target: &FoldedTarget<'_>,
        (ground, laid): (&Ground, &LaidOut),
        clock: &mut Clock<'_>,
    ) -> Result<(HexMesh, Option<HexMesh>), NotSymmetric> {
        let (options, walls) = (&self.options, self.group.walls());
        let reported = ground.reported(&laid.surface);
        let facets = ground.given_facets();
        let others = References::of_facets(Some(facets));
        let judge = Judge::new(reported, others, options.limits());
        let mut corners = corner_points(reported, options);
        corners.retain(|p| walls.iter().all(|n| n.dot(p).abs() > PUT_THERE));
        let hold = target.boundary().map(|curves| BoundaryHold {
            curves: curves.clone(),
            corners,
        });
        let site = Site {
            judge: &judge,
            close_to: &SurfaceTarget::new(reported),
            hold,
            mirrors: &walls,
            areas: Some(areas_of(laid)),
            options: &options.optimise,
        };
        let progress = clock.progress;
        let mut now = on_boundary(mesh, &site, target, &parts.quotient, clock)?;
        if options.effort != Effort::Draft && !progress.is_cancelled() {
            now = clock.timed("search", || search(now, &site, progress)).mesh;
        }
        let Some(tolerance) = options.repeat_rel.filter(|_| !progress.is_cancelled()) else {
            return Ok((now, None));
        };
        let equal = self.with_equal_edges(&now, &site, target, tolerance, clock)?;
        Ok((equal, Some(now)))
    }

    /// Panels with as many edges of equal lengths as there are, judged with all their images on the
    /// whole surface.
    fn with_equal_edges(
        &self,
        mesh: &HexMesh,
        site: &Site<'_>,
        target: &FoldedTarget<'_>,
        tolerance: f64,
        clock: &mut Clock<'_>,
    ) -> Result<HexMesh, NotSymmetric> {
        let quotient = symmetry::quotient_of(mesh, self.group)?;
        let around = (self.whole).mapped(|p| self.found.frame.inside(*p) / self.scale);
        let judge = self.whole_judge(&around);
        let elements = self.group.elements();
        let merit = |mesh: &HexMesh| match symmetry::unfolded(&quotient, mesh, &elements) {
            Ok(all) => {
                let any = vec![0.0; all.mesh.topology().n_faces()];
                judge.with_cover(judge.whole(&all.mesh, &any).merit, &all.mesh)
            }
            Err(_) => Merit {
                invalid: f64::INFINITY,
                ..Merit::default()
            },
        };
        let task = RepetitionTask {
            site,
            merit: &merit,
            target,
            quotient: &quotient,
            steering: &Steering::default(),
            tolerance,
        };
        let progress = clock.progress;
        Ok(clock.timed("repetition", || made_equal(&task, mesh, progress))?)
    }

    /// The judge of the part with all its images, on the whole surface in the part's coordinates.
    fn whole_judge<'b>(&self, whole: &'b TriangleSurface) -> Judge<'b> {
        let limits = self.options.limits();
        let of_whole = |share: f64| share * self.scale;
        let limits = Limits {
            deviation_rel: limits.deviation_rel.map(of_whole),
            boundary_rel: limits.boundary_rel.map(of_whole),
            ..limits
        };
        Judge::new(whole, References::default(), limits)
    }

    /// What is said where the images of a part do not make up the surface.
    fn not_closed(&self, cause: &str) -> String {
        format!(
            "a part with about {} panels, repeated {} times, does not close to the surface ({cause}): more panels, or a symmetry of fewer rotations, may help",
            self.panels,
            self.group.order()
        )
    }

    /// The part and all its images, normalised.
    fn assembled(
        &self,
        (part, wished): (&HexMesh, &PerFace<f64>),
        before: Option<&HexMesh>,
        (statistics, outcome): (Statistics, Outcome),
        clock: &mut Clock<'_>,
    ) -> Result<MeshRun, NotSymmetric> {
        let (whole, found) = (self.whole, self.found);
        let elements = self.group.elements();
        let quotient = symmetry::quotient_of(part, self.group)?;
        let unfolded = |mesh: &HexMesh| {
            symmetry::unfolded(&quotient, mesh, &elements).map_err(|e| e.to_string())
        };
        let all = unfolded(part)?;
        let before = before.map(unfolded).transpose()?;
        let frame = &found.frame;
        let outside = |mesh: &HexMesh| mesh.mapped(|p| frame.outside(p * self.scale));
        let operation = |e: &Matrix3<f64>| {
            let map = frame.axes.transpose() * e * frame.axes;
            Isometry::new(&map, frame.origin - map * frame.origin)
        };
        let orbits = Orbits {
            operations: elements.iter().map(operation).collect(),
            vertices: all.vertices,
            panels: all.panels,
        };
        let mesh = outside(&all.mesh);
        if let Err(cause) = same_topology(whole.topology(), mesh.topology()) {
            return Err(self.not_closed(&cause).into());
        }
        let distinct = part.topology().n_faces();
        let statistics = Statistics {
            symmetry: Some(SymmetrySummary {
                group: self.group.name(),
                order: self.group.order(),
                revolution: found.revolution,
                distance_rel: symmetry::distance(whole, frame, self.group),
                tolerance_rel: SYMMETRY_TOLERANCE,
                distinct_panels: distinct,
                operations: orbits.operations.clone(),
            }),
            ..statistics
        };
        let wish = |(source, _): &(u32, u32)| wished.as_slice()[*source as usize];
        let wished = PerFace::from_vec(orbits.panels.iter().map(wish).collect());
        Ok(MeshRun {
            wished: wished.map(|area| area * self.scale.powi(2)),
            orbits: Some(orbits),
            unrepeated: before.map(|b| outside(&b.mesh)),
            stages: std::mem::take(&mut clock.stages),
            ..MeshRun::new(mesh, whole.clone(), outcome, statistics)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{fewer_turns, price_of};

    #[test]
    fn what_a_symmetry_costs_is_told() {
        assert_eq!(price_of(0, true), "");
        let one = price_of(1, true);
        assert_eq!(
            one,
            "; one panel is irregular without need, perhaps because of the symmetry"
        );
        assert!(price_of(24, true).starts_with("; 24 panels are irregular without need, perhaps"));
        assert!(price_of(1, false).contains("need and panels are outside limits, perhaps"));
    }

    #[test]
    fn smaller_groups_are_parts_of_the_larger_ones() {
        assert_eq!(fewer_turns(20), [20, 5, 1]);
        assert_eq!(fewer_turns(12), [12, 6, 1]);
        assert_eq!(fewer_turns(4), [4, 2, 1]);
        assert_eq!(fewer_turns(5), [5, 1]);
        assert_eq!(fewer_turns(2), [2, 1]);
        assert_eq!(fewer_turns(1), [1]);
    }
}
