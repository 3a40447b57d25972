//! What a round of the repair loop is judged by.

use super::cures::{Ill, Place};
use super::{Clock, MeshOptions, PipelineError, rim};
use crate::ground::Ground;
use crate::layout::Layout;
use crate::optimise::{Fault, Offender, Optimised};
use crate::trim::{Boundary, Trimmed};
use phex_mesh::{
    Deviation, FaceId, FlatFace, HexMesh, PolygonSoup, TriangleSurface, ValidateOptions, Vec3,
    VertexId, Violation,
};
use std::collections::BTreeSet;

/// What rounds of the repair loop are compared by, the first difference counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Badness {
    pub not_planar: bool,
    pub broken: usize,
    pub invalid: usize,
    pub bare: usize,
    pub tight: usize,
}

/// Share of the panels up to which a round adds panels, and a number that is always allowed: where the surface stands off in more
/// places than that, panels are too large everywhere, and more of them here and there only spoil the rows.
const MAX_ADDED_SHARE: f64 = 0.02;
const MAX_ADDED: usize = 2;
/// Distance of these places from each other, mean edges.
const ADDED_APART: f64 = 3.0;
/// Panel lengths within which a place counts as the same.
const SAME_PLACE: f64 = 2.5;
/// What a place where the surface stands off counts, for each time that it is as far as is good, what a panel does that only folds
/// over an edge or is small, and a tight one; any other invalid one counts 1.
const BARE: f64 = 0.3;
const MILD: f64 = 0.3;
const TIGHT: f64 = 0.02;

/// An optimised layout, judged.
pub(super) struct Judged {
    pub badness: Badness,
    pub result: Optimised,
    pub left: Left,
}

/// What rounds are judged against.
pub(super) struct Judge<'a> {
    pub ground: &'a Ground,
    /// The surface that cells were drawn on.
    pub fine: &'a TriangleSurface,
    /// The surface that is reported against, and that with what is beyond its boundary.
    pub reported: &'a TriangleSurface,
    pub reach: &'a TriangleSurface,
    pub options: &'a MeshOptions,
}

impl Judge<'_> {
    /// Trims the result of a layout and tells what is wrong with it.
    pub fn judged(
        &self,
        layout: &Layout,
        result: Optimised,
        clock: &mut Clock<'_>,
    ) -> Result<(Judged, Wrong), PipelineError> {
        let options = self.options;
        let mut trimmed = clock.timed("trim", || self.ground.trimmed(&result.mesh, self.fine))?;
        let mut violations = clock.timed("validate", || self.violations(&trimmed.mesh));
        let offenders = offenders_left(&result.offenders, &trimmed);
        // What was cut is small by chance, and no cause to lay panels out anew.
        let cut = options.boundary != Boundary::Whole && self.ground.is_extended();
        if cut && is_planar(&offenders) {
            let progress = clock.progress;
            let larger = clock.timed("trim", || {
                rim::enlarged(&trimmed.mesh, self.reported, options, progress)
            })?;
            if let Some(larger) = larger {
                let now = clock.timed("validate", || self.violations(&larger.mesh));
                if now.len() <= violations.len() {
                    (trimmed.mesh, violations) = (larger.mesh, now);
                }
            }
        }
        let invalid = invalid_panels(&offenders, &trimmed, &violations, options.boundary);
        let deviation = clock.timed("validate", || {
            phex_mesh::deviation_beyond(&trimmed.mesh, self.reported, self.reach)
        });
        let wrong = Wrong {
            mild: mild(&invalid, &offenders, &trimmed, &violations),
            crossing: crossing(&trimmed, &violations),
            bare: bare_places(&trimmed.mesh, self.reported, &deviation, options),
            tight: tight_panels(&trimmed, options),
            invalid,
        };
        let badness = Badness {
            not_planar: !is_planar(&offenders),
            broken: wrong.invalid.len() - wrong.mild.len(),
            invalid: wrong.invalid.len(),
            bare: wrong.bare.len(),
            tight: wrong.tight.len(),
        };
        let left = Left {
            start: laid_out(layout, &trimmed),
            trimmed,
            offenders,
            violations,
            deviation: inner_deviation(&deviation),
        };
        let judged = Judged {
            badness,
            result,
            left,
        };
        Ok((judged, wrong))
    }
}

impl Judge<'_> {
    /// What is wrong between the panels of a mesh, and with the sides that they show.
    fn violations(&self, mesh: &HexMesh) -> Vec<Violation> {
        let mut violations = between_panels(mesh, self.reported);
        phex_mesh::add_flips(&mut violations, mesh, self.ground.given_facets());
        violations
    }
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

impl Left {
    /// Whether no panel is invalid, but for its size.
    pub fn is_sound(&self) -> bool {
        self.offenders.is_empty() && self.violations.is_empty()
    }
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

/// Panels that are to be cured: those with a wrong shape, and those farthest from planar, because one blocked panel keeps others
/// from their planes.
pub(super) fn invalid_panels(
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
    invalid.extend(farthest_from_planar(offenders));
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

/// What is wrong with a round's panels, numbered as in the layout.
pub(super) struct Wrong {
    invalid: BTreeSet<FaceId>,
    /// Those of them that only fold over an edge, or are small.
    mild: BTreeSet<FaceId>,
    /// Those of them that cross others.
    crossing: BTreeSet<FaceId>,
    bare: Vec<(Vec3, f64)>,
    tight: BTreeSet<FaceId>,
}

impl Wrong {
    /// Places where something is wrong: tight panels count only where all are valid and close.
    pub fn places(&self, layout: &Layout, fine: &TriangleSurface) -> Vec<Place> {
        let weight = |f: &FaceId| if self.mild.contains(f) { MILD } else { 1.0 };
        let ill = |group: &[FaceId]| match group.iter().any(|f| self.crossing.contains(f)) {
            true => Ill::Crossing,
            false => Ill::Invalid,
        };
        let mut places = of_panels(layout, &self.invalid, ill, weight);
        let points: Vec<Vec3> = self.bare.iter().map(|b| b.0).collect();
        let feet = fine.closest_points(&points);
        let bare = self.bare.iter().zip(&feet);
        places.extend(bare.map(|((at, excess), foot)| Place {
            ill: Ill::Bare,
            at: *at,
            reach: SAME_PLACE * length_near(layout, *at),
            cells: vec![fine.topology().face_vertices(foot.triangle)[0]],
            weight: BARE * excess,
        }));
        if places.is_empty() {
            places = of_panels(layout, &self.tight, |_| Ill::Tight, |_| TIGHT);
        }
        places
    }
}

/// Panels that cross others.
fn crossing(trimmed: &Trimmed, violations: &[Violation]) -> BTreeSet<FaceId> {
    let topology = trimmed.mesh.topology();
    let crossings = violations
        .iter()
        .filter(|v| matches!(v, Violation::Crossing { .. }));
    let faces = crossings.flat_map(|v| v.faces(topology));
    faces.map(|f| trimmed.parent[f]).collect()
}

/// The invalid panels that have no fault but an edge over which they fold, or a small area at the boundary.
fn mild(
    invalid: &BTreeSet<FaceId>,
    offenders: &[Offender],
    trimmed: &Trimmed,
    violations: &[Violation],
) -> BTreeSet<FaceId> {
    let topology = trimmed.mesh.topology();
    let grave = violations
        .iter()
        .filter(|v| !matches!(v, Violation::Fold { .. } | Violation::NotPlanar { .. }));
    let faces = grave.flat_map(|v| v.faces(topology));
    let bad = |o: &&Offender| !matches!(o.fault, Fault::Folded { .. } | Fault::NotPlanar { .. });
    let broken = faces.chain(offenders.iter().filter(bad).map(|o| o.face));
    let broken: BTreeSet<FaceId> = broken.map(|f| trimmed.parent[f]).collect();
    invalid.difference(&broken).copied().collect()
}

/// Length of the panel whose middle is nearest.
fn length_near(layout: &Layout, p: Vec3) -> f64 {
    let distances = layout.face_point.enumerate();
    let nearest = distances.map(|(f, q)| ((q - p).norm_squared(), f));
    let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(0.0, |(_, f)| layout.face_length[f])
}

/// Groups of panels that hang together.
fn of_panels(
    layout: &Layout,
    panels: &BTreeSet<FaceId>,
    ill: impl Fn(&[FaceId]) -> Ill,
    weight: impl Fn(&FaceId) -> f64,
) -> Vec<Place> {
    let topology = layout.mesh.topology();
    let mut left = panels.clone();
    let mut places = Vec::new();
    while let Some(first) = left.pop_first() {
        let mut group = vec![first];
        let mut next = 0;
        while next < group.len() {
            let twins = topology.face_half_edges(group[next]);
            let twins = twins.filter_map(|h| topology.twin(h));
            let beside: Vec<FaceId> = twins.map(|t| topology.face(t)).collect();
            group.extend(beside.into_iter().filter(|f| left.remove(f)));
            next += 1;
        }
        let weight = group.iter().map(&weight).sum();
        places.push(place_of(layout, &group, ill(&group), weight));
    }
    places
}

fn place_of(layout: &Layout, group: &[FaceId], ill: Ill, weight: f64) -> Place {
    let sum: Vec3 = group.iter().map(|f| layout.face_point[*f]).sum();
    let at = sum / group.len() as f64;
    let extent = group.iter().map(|f| (layout.face_point[*f] - at).norm());
    let length = layout.face_length[group[0]];
    Place {
        ill,
        at,
        reach: extent.fold(0.0, f64::max) + SAME_PLACE * length,
        cells: group.iter().map(|f| layout.face_seed[*f]).collect(),
        weight,
    }
}

/// Places where the surface stands off from the panels farther than is good, the farthest first, and how many times as far.
fn bare_places(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    deviation: &Deviation,
    options: &MeshOptions,
) -> Vec<(Vec3, f64)> {
    let limit = options.good_deviation() * deviation.diagonal;
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
    let mut places: Vec<(Vec3, f64)> = Vec::new();
    for (v, distance) in far {
        let p = surface.positions()[v];
        if places.iter().all(|(q, _)| (p - q).norm() > apart) {
            places.push((p, distance / limit));
        }
        if places.len() > most {
            break;
        }
    }
    // The worst of them are resolved where features are to be.
    let resolve = options.sizes.adaptive.is_some();
    let none = places.len() > most && !resolve;
    places.truncate(if none { 0 } else { most });
    places
}
