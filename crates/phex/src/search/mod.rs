//! Search: local changes of a finished mesh, each kept if the judge says that it is better.
//!
//! A *transaction* takes the panels within a few rings of a defect and tries what may cure it: the
//! same panels with more weight on what they lack; where that is not enough creases that fold cut
//! off (`chamfer`), two of them merged, an edge turned, a panel split; where panels are too large
//! all of them split. Where many panels are broken, as along the edges of a box, all of them are
//! tried at once first, with more weight alone, and then with all creases cut off. Each candidate
//! is made regular again by turns of edges (`draft`); the most regular ones are made planar by the
//! optimiser with everything around it at rest, and judged ([`crate::quality::Judge`]) with the
//! same figures as the whole mesh; the best is kept if it is better than what there was, else
//! nothing has changed. Places that do not touch are searched side by side. It is one mechanism for
//! closed and open, uniform and adaptive meshes, whatever made them. Where nothing is left outside
//! limits, sharp corners are blunted in the same way, as far as no panel moves farther off the
//! surface than the farthest was; then long edges are shortened and large or slender panels at the
//! boundary made smaller, as far as that and no corner gets sharper.
//!
//! *Guaranteed*: a mesh never gets worse by [`crate::quality::Merit`]; interior vertices keep three
//! panels; outside of the patches that are kept positions are the same to the last bit; the same
//! result for any number of threads. What it costs follows the number of defects.
//!
//! *Fails* where panels are too large for the surface in many places: then defects are left, and
//! named.

mod candidates;
mod chamfer;
mod draft;
mod patch;
mod site;
mod trial;

#[cfg(test)]
mod tests;

use crate::progress::{Event, Progress};
use crate::quality::{Defect, Judgement, Shapes, defects};
use patch::{Change, Patch, applied};
use phex_mesh::{FaceId, HexMesh, Vec3};
use rayon::prelude::*;
use serde::Serialize;
use site::Whole;
pub use site::{AreaField, Site};
use std::collections::BTreeSet;
use std::ops::Range;
use trial::DefectPatch;

/// Rings of panels around a defect that may be joined anew, at first and where that has failed.
const RINGS: [usize; 3] = [1, 2, 4];
/// Sweeps over all defects at the most.
const SWEEPS: usize = 30;
/// Share of invalid panels above which nothing is searched: panels are too large everywhere. Folds
/// can be cured, as at the rim of a lens, or are the surface's own, as along the ridges of a roof.
const HOPELESS: f64 = 1.0 / 3.0;
/// Places outside limits, and their share of the panels, above which panels are too large
/// everywhere: more of them here and there would only spoil the rows. What is broken is searched
/// all the same.
const FEW: f64 = 3.0;
const FEW_SHARE: f64 = 0.06;
/// Sweeps in a row that change nothing after which no more begin: each width has failed by then at
/// the worst place, and at what touches it.
const FRUITLESS: usize = RINGS.len();
/// Candidates after which no sweep begins, and one more for each panel: the cost follows the
/// panels.
const LEAST_TRIED: usize = 60;
/// Broken places from which on all are tried at once, first.
const MANY_BROKEN: usize = 8;
/// Mean edges within which two places are the same.
const SAME: f64 = 0.8;
/// Mean edges from a change within which other changes may help that have not before.
const NEAR: f64 = 6.0;

/// What a search came to.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SearchSummary {
    /// Defects before it.
    pub defects: usize,
    /// Sweeps over them.
    pub sweeps: usize,
    /// Places at which something was tried.
    pub places: usize,
    /// Candidates that were made planar and judged.
    pub tried: usize,
    /// Changes that were kept.
    pub kept: usize,
    /// Defects that are left.
    pub left: usize,
    /// Whether so many panels were broken that no change was tried: they are too large for the
    /// surface.
    pub is_hopeless: bool,
}

/// A mesh after a search.
pub struct Searched {
    /// The mesh.
    pub mesh: HexMesh,
    /// What the judge says of it.
    pub judgement: Judgement,
    /// What was done.
    pub summary: SearchSummary,
}

/// A place where candidates have failed.
struct Failed {
    place: Vec3,
    times: usize,
}

/// Searches a mesh until no local change makes it better, or until it is cancelled.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let torus = triangulate(&Shape::from_name("torus", &[])?, &TriangulationOptions::default())?;
/// use phex::optimise::{OptimiseOptions, SurfaceTarget};
/// use phex::quality::{Judge, Limits, References};
/// use phex::search::{Site, search};
/// use phex::{Effort, MeshOptions, PanelSize, Silent, mesh_surface};
///
/// let options = MeshOptions { size: PanelSize::Panels(60), effort: Effort::Draft, ..Default::default() };
/// let run = mesh_surface(&torus, &options, &Silent)?;
/// let limits = Limits::new(Some(0.02), None);
/// let judge = Judge::new(&run.target, References::default(), limits);
/// let site = Site {
///     judge: &judge,
///     close_to: &SurfaceTarget::new(&run.target),
///     hold: None,
///     mirrors: &[],
///     areas: None,
///     options: &OptimiseOptions::default(),
/// };
/// let found = search(run.mesh, &site, &Silent);
/// assert!(found.summary.left <= found.summary.defects);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn search(mesh: HexMesh, site: &Site<'_>, progress: &dyn Progress) -> Searched {
    let whole = Whole::of(&mesh, site, Shapes::Any);
    let summary = SearchSummary {
        defects: defects(&mesh, &whole.findings).len(),
        ..SearchSummary::default()
    };
    let mut state = SearchState {
        mesh,
        whole,
        summary,
        failed: Vec::new(),
    };
    let invalid = state
        .whole
        .findings
        .of_face
        .iter()
        .filter(|f| f.invalid > 0.0)
        .count();
    let many = HOPELESS * state.mesh.topology().n_faces() as f64;
    state.summary.is_hopeless = invalid as f64 > many;
    if !state.summary.is_hopeless {
        state.together(site, progress);
        state.sweep(site, progress);
    }
    state.summary.left = defects(&state.mesh, &state.whole.findings).len();
    let judgement = state.shaped(site, progress);
    Searched {
        judgement,
        mesh: state.mesh,
        summary: state.summary,
    }
}

/// A mesh that is being searched.
struct SearchState {
    mesh: HexMesh,
    whole: Whole,
    summary: SearchSummary,
    failed: Vec<Failed>,
}

impl SearchState {
    /// Sweeps over sharp corners, and then over long edges and large panels at the boundary, too,
    /// where nothing is left that is worse. What the judge says of the result.
    fn shaped(&mut self, site: &Site<'_>, progress: &dyn Progress) -> Judgement {
        let mut plain = self.whole.findings.clone();
        for shapes in [Shapes::Corners, Shapes::Sizes] {
            let (kept, wished) = (self.summary.kept, site.wished_areas(&self.mesh));
            self.whole.yardstick.shapes = shapes;
            let found = plain.counting_shapes(&self.mesh, &wished, &self.whole.yardstick);
            if let Some(found) = found.filter(|_| plain.merit.is_within()) {
                self.whole.findings = found;
                self.failed.clear();
                self.sweep(site, progress);
            }
            if self.summary.kept > kept {
                plain = self.whole.findings.clone().without_shapes();
            }
        }
        plain
    }

    /// All places with broken panels at once: with more emphasis alone, since what one of them
    /// needs of its neighbours they can't give while they rest; then with folds cut off, since a
    /// strip has fewest ends where it follows the whole of a crease.
    fn together(&mut self, site: &Site<'_>, progress: &dyn Progress) {
        for how in [DefectPatch::emphasised, DefectPatch::chamfered] {
            let all = defects(&self.mesh, &self.whole.findings);
            let broken: Vec<Defect> = all.into_iter().filter(|d| d.is_broken).collect();
            if broken.len() < MANY_BROKEN {
                return;
            }
            let faces: Vec<FaceId> = broken.iter().flat_map(|d| d.faces.clone()).collect();
            let resting = site.resting(&self.mesh);
            let place = DefectPatch {
                patch: Patch::around(&self.mesh, &faces, RINGS[1], &resting),
                defect: Defect {
                    faces,
                    amount: broken.iter().map(|d| d.amount).sum(),
                    ..broken[0].clone()
                },
                wide: false,
            };
            self.summary.places += 1;
            self.summary.tried += 1;
            if let Some(change) = how(&place, &self.whole, site, progress) {
                let kept = take(&mut self.mesh, &mut self.whole, &[change], site);
                self.summary.kept += usize::from(kept == [Some(true)]);
            }
        }
    }

    /// Sweeps over the defects until none of them is cured.
    fn sweep(&mut self, site: &Site<'_>, progress: &dyn Progress) {
        let Self {
            mesh,
            whole,
            summary,
            failed,
        } = self;
        let most = LEAST_TRIED + mesh.topology().n_faces();
        let mut fruitless = 0;
        while summary.sweeps < SWEEPS
            && summary.tried < most
            && fruitless < FRUITLESS
            && !progress.is_cancelled()
        {
            let places = chosen(mesh, whole, failed, &site.resting(mesh));
            if places.is_empty() {
                break;
            }
            summary.sweeps += 1;
            summary.places += places.len();
            let tried: Vec<(Option<Change>, usize)> = (places.par_iter().with_max_len(1))
                .map(|place| place.best(whole, site, progress))
                .collect();
            summary.tried += tried.iter().map(|t| t.1).sum::<usize>();
            let edge = whole.yardstick.mean_edge;
            let (mut at, mut changes) = (Vec::new(), Vec::new());
            for (place, (change, _)) in places.iter().zip(tried) {
                match change {
                    Some(change) => {
                        at.push(&place.defect);
                        changes.push(change);
                    }
                    None => fail(failed, place.defect.place, edge),
                }
            }
            progress.report(&Event::Counted {
                stage: "search",
                done: summary.sweeps,
                total: SWEEPS,
            });
            let kept = take(mesh, whole, &changes, site);
            fruitless = match kept.contains(&Some(true)) {
                true => 0,
                false => fruitless + 1,
            };
            summary.kept += kept.iter().filter(|kept| **kept == Some(true)).count();
            for (defect, kept) in at.iter().zip(kept) {
                note(failed, defect, kept, edge);
            }
            // Where most of the worst sizes stay as they are the others would, too.
            if whole.yardstick.shapes == Shapes::Sizes && 2 * changes.len() < places.len() {
                break;
            }
        }
    }
}

/// Notes whether the change of a defect was kept, if it was tried: what failed near it may now do.
fn note(failed: &mut Vec<Failed>, defect: &Defect, kept: Option<bool>, mean_edge: f64) {
    let far = |f: &Failed| (f.place - defect.place).norm() > NEAR * mean_edge;
    match kept {
        Some(true) => failed.retain(|f| defect.is_allowed || far(f)),
        Some(false) => fail(failed, defect.place, mean_edge),
        None => {}
    }
}

/// Notes that candidates have failed at a place.
fn fail(failed: &mut Vec<Failed>, place: Vec3, mean_edge: f64) {
    let known = failed
        .iter_mut()
        .find(|f| (f.place - place).norm() < SAME * mean_edge);
    match known {
        Some(failed) => failed.times += 1,
        None => failed.push(Failed { place, times: 1 }),
    }
}

/// Defects at which something is left to try, the worst first, none of whose patches touch.
fn chosen(
    mesh: &HexMesh,
    whole: &Whole,
    failed: &[Failed],
    resting: &BTreeSet<FaceId>,
) -> Vec<DefectPatch> {
    let same = SAME * whole.yardstick.mean_edge;
    let mut taken: BTreeSet<FaceId> = BTreeSet::new();
    let mut places = Vec::new();
    let mut all = defects(mesh, &whole.findings);
    let is_misshapen = |f: &FaceId| whole.findings.of_face[*f].misshapen() > 0.0;
    all.retain(|d| {
        let counts = whole.yardstick.shapes == Shapes::Any || d.faces.iter().any(is_misshapen);
        counts && d.faces.iter().all(|f| !resting.contains(f))
    });
    let outside = all.iter().filter(|d| !d.is_broken && !d.is_allowed).count();
    let too_large = outside as f64 > FEW + FEW_SHARE * mesh.topology().n_faces() as f64;
    for defect in all.into_iter().filter(|d| d.is_broken || !too_large) {
        let before = failed
            .iter()
            .find(|f| (f.place - defect.place).norm() < same);
        let times = before.map_or(0, |f| f.times);
        // What is allowed is worth one try, in which its neighbours can give way, too.
        let again = |_: &&usize| times == 0 || !defect.is_allowed;
        let rings = RINGS.get(times + usize::from(defect.is_allowed));
        let rings = rings.filter(again);
        let Some(rings) = rings else {
            continue;
        };
        if defect.faces.iter().any(|f| taken.contains(f)) {
            continue;
        }
        let patch = Patch::around(mesh, &defect.faces, *rings, resting);
        if patch.faces.iter().all(|f| !taken.contains(f)) {
            taken.extend(&patch.faces);
            places.push(DefectPatch {
                defect,
                patch,
                wide: times > 0,
            });
        }
    }
    places
}

/// Takes changes: all of them if the mesh as a whole is better for it, else half of them, a
/// quarter, and so on. Tells which were kept; nothing of those that are to be tried again, because
/// panels have other numbers now.
fn take(
    mesh: &mut HexMesh,
    whole: &mut Whole,
    changes: &[Change],
    site: &Site<'_>,
) -> Vec<Option<bool>> {
    first_better(changes.len(), |which| {
        let Some(next) = applied(mesh, &changes[which]) else {
            return false;
        };
        let judged = Whole::of(&next, site, whole.yardstick.shapes);
        let better = judged.findings.merit.is_less(&whole.findings.merit);
        if better {
            (*mesh, *whole) = (next, judged);
        }
        better
    })
}

/// Looks for the first run of `count` changes that is better, from all of them to halves, quarters
/// and single ones: few looks, whatever one bad change spoils. Tells of each whether it is part of
/// that run, or bad by itself; nothing of the others.
fn first_better(
    count: usize,
    mut is_better: impl FnMut(Range<usize>) -> bool,
) -> Vec<Option<bool>> {
    let mut kept = vec![None; count];
    let mut open = vec![(0, count)];
    while let Some((from, to)) = open.pop().filter(|(from, to)| from < to) {
        if is_better(from..to) {
            kept[from..to].fill(Some(true));
            break;
        }
        if to - from == 1 {
            kept[from] = Some(false);
            continue;
        }
        let middle = from + (to - from) / 2;
        open.extend([(middle, to), (from, middle)]);
    }
    kept
}
