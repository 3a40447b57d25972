//! Cures for what is wrong with panels, place by place.
//!
//! Every place has a list of cures of its own, mild ones first: drop a seed or add one, spread the seeds of a neighbourhood anew, spread
//! more of them, or fewer, and the same in a wider neighbourhood. All places get one at a time and are judged apart, when the panels have been optimised again: where
//! things have not become better, crossings with others included, the seeds (and panels, see [`Cures::new`]) are as they were before, and the next cure is tried.
//! So what helps at one place is kept, whatever happens at another.

use crate::layout::reseed::{Neighbourhoods, Reseeded};
use crate::layout::seeds::Seed;
use phex_mesh::{Vec3, VertexId};
use std::collections::BTreeSet;

/// What is wrong at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ill {
    /// Panels have a wrong shape or are not planar.
    Invalid,
    /// Panels cross others: they are too large for the space between two sheets.
    Crossing,
    /// The surface stands off.
    Bare,
    /// Panels are valid, but have little clearance.
    Tight,
}

/// A place where something is wrong.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub ill: Ill,
    pub at: Vec3,
    /// How far it counts as the same place.
    pub reach: f64,
    /// Vertices in the cells of the panels that are wrong, or nearest to the place.
    pub cells: Vec<VertexId>,
    /// How bad it is.
    pub weight: f64,
}

impl Place {
    /// Whether all panels are valid there.
    pub fn is_valid(&self) -> bool {
        matches!(self.ill, Ill::Bare | Ill::Tight)
    }

    fn is_near(&self, other: &Place) -> bool {
        (self.at - other.at).norm() <= self.reach.max(other.reach)
    }
}

/// A cure.
struct Cure {
    place: Place,
    change: Reseeded,
}

/// What a round of cures came to.
pub(super) struct Verdict {
    /// Places that are wrong when cures that have not helped are taken back, the places of those first.
    pub open: Vec<Place>,
    /// Where cures have helped, and where they were taken back.
    pub helped: Vec<Place>,
    pub undone: Vec<Place>,
}

impl Verdict {
    /// Whether panels at a point are to be as before the round: the nearest cure was taken back.
    pub fn is_undone(&self, p: Vec3) -> bool {
        let distance = |place: &Place| (place.at - p).norm();
        let nearest = |places: &[Place]| places.iter().map(distance).fold(f64::MAX, f64::min);
        let within = |place: &Place| distance(place) <= MOVED * place.reach;
        nearest(&self.undone) < nearest(&self.helped) && self.undone.iter().any(within)
    }
}

/// A place where cures have failed.
struct Failed {
    place: Place,
    times: usize,
}

/// The cures of the last round, and where some have failed.
pub(super) struct Cures {
    /// Whether panels, too, are as they were before where a cure is taken back.
    apart: bool,
    last: Vec<Cure>,
    failed: Vec<Failed>,
}

/// Reaches of a place within which panels have moved for its cure.
const MOVED: f64 = 2.0;
/// A cure must take away this share of what is wrong.
const GAIN: f64 = 0.02;
/// Failures after which seeds are spread anew within two rings, and those up to which there is something left to do.
const WIDE: usize = 5;
const LAST: usize = WIDE + 2;
/// Seeds over those that there were, in cures one after the other.
const MORE: [f64; 2] = [1.6, 3.0];

impl Cures {
    /// None yet; `apart` tells whether panels, too, are as they were before where a cure is taken back.
    pub fn new(apart: bool) -> Self {
        Self {
            apart,
            last: Vec::new(),
            failed: Vec::new(),
        }
    }

    /// Judges the cures of the last round by what was wrong before and is wrong now, and takes back what has not helped; `failed` are points
    /// where panels did not become planar.
    pub fn judge(
        &mut self,
        before: &[Place],
        now: Vec<Place>,
        failed: &[Vec3],
        seeds: &mut Vec<Seed>,
    ) -> Verdict {
        let cures = std::mem::take(&mut self.last);
        let is_failed = |p: &Vec3| nearest_cure(&cures, *p);
        let failed: BTreeSet<usize> = failed.iter().filter_map(is_failed).collect();
        // Cured apart, what is wrong between two cures is the nearer one's.
        let is_of = |k: usize, place: &Place| {
            let nearest = || nearest_cure(&cures, place.at) == Some(k);
            cures[k].place.is_near(place) && (!self.apart || nearest())
        };
        let weight = |k: usize, places: &[Place]| -> f64 {
            let own = places.iter().filter(|p| is_of(k, p));
            own.map(|p| p.weight).sum()
        };
        let is_worse = |k: usize| weight(k, &now) > (1.0 - GAIN) * weight(k, before);
        let fails: Vec<bool> = (0..cures.len())
            .map(|k| failed.contains(&k) || is_worse(k))
            .collect();
        let of_failed = |place: &Place| (0..cures.len()).any(|k| fails[k] && is_of(k, place));
        let own = cures.iter().zip(&fails).filter(|(_, fails)| **fails);
        let mut open: Vec<Place> = own.map(|(cure, _)| cure.place.clone()).collect();
        if self.apart {
            let cured: Vec<Vec3> = open.iter().map(|p| p.at).collect();
            let others = before
                .iter()
                .filter(|p| of_failed(p) && !cured.contains(&p.at));
            open.extend(others.cloned());
        }
        open.extend(now.into_iter().filter(|p| !of_failed(p)));
        let (mut helped, mut undone) = (Vec::new(), Vec::new());
        for (cure, fails) in cures.into_iter().zip(fails) {
            if fails {
                cure.change.undo(seeds);
                self.fail(&cure.place);
                undone.push(cure.place);
            } else {
                helped.push(cure.place);
            }
        }
        Verdict {
            open,
            helped,
            undone,
        }
    }

    fn fail(&mut self, place: &Place) {
        let known = self.failed.iter_mut().find(|f| f.place.is_near(place));
        match known {
            Some(failed) => failed.times += 1,
            None => self.failed.push(Failed {
                place: place.clone(),
                times: 1,
            }),
        }
    }

    fn failures(&self, place: &Place) -> usize {
        let known = self.failed.iter().find(|f| f.place.is_near(place));
        known.map_or(0, |f| f.times)
    }

    /// Gives each place its next cure; those whose neighbourhoods meet wait for each other.
    pub fn give(&mut self, places: &[Place], around: &Neighbourhoods<'_>, seeds: &mut Vec<Seed>) {
        let mut taken: BTreeSet<u32> = BTreeSet::new();
        for place in places {
            let cells = place.cells.iter();
            let core: BTreeSet<u32> = cells.filter_map(|v| around.seed_at(*v)).collect();
            let failures = self.failures(place);
            let rings = if failures < WIDE { 2 } else { 3 };
            let reach = (0..rings).fold(core.clone(), |reach, _| around.with_ring(&reach));
            if !reach.is_disjoint(&taken) {
                continue;
            }
            let Some(change) = change(place, &core, failures, around) else {
                continue;
            };
            change.apply(seeds);
            taken.extend(reach);
            self.last.push(Cure {
                place: place.clone(),
                change,
            });
        }
    }

    /// Places under treatment.
    pub fn count(&self) -> usize {
        self.last.len()
    }
}

/// The cure nearest to a point.
fn nearest_cure(cures: &[Cure], p: Vec3) -> Option<usize> {
    let distances = cures.iter().map(|cure| (cure.place.at - p).norm());
    let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.map(|n| n.0)
}

/// What is done at a place where so many cures have failed; `None` if there is nothing left.
fn change(
    place: &Place,
    core: &BTreeSet<u32>,
    failures: usize,
    around: &Neighbourhoods<'_>,
) -> Option<Reseeded> {
    let moving = around.with_ring(core);
    let times = |factor: f64| (factor * moving.len() as f64).round() as usize;
    let spread = |count| around.spread(&moving, &[], count);
    let here = &place.cells[..place.cells.len().min(1)];
    let with_one = || around.spread(&moving, here, moving.len() + 1);
    let finer = |k: usize| around.spread(&moving, here, times(MORE[k]).max(moving.len() + 2));
    match (place.ill, failures) {
        (Ill::Invalid | Ill::Tight, 0) => Some(around.dropped(core)),
        (Ill::Invalid | Ill::Tight, 1) => Some(spread(moving.len())),
        (Ill::Invalid, 2 | 3) => Some(spread(times(MORE[failures - 2]))),
        (Ill::Invalid, 4) => Some(spread(moving.len().saturating_sub(1).max(1))),
        (Ill::Invalid, WIDE..=LAST) => {
            let wide = around.with_ring(&moving);
            // As many, one less, one more.
            let count = [wide.len(), wide.len() - 1, wide.len() + 1][failures - WIDE];
            Some(around.spread(&wide, &[], count.max(1)))
        }
        (Ill::Crossing, 0 | 1) => Some(spread(times(MORE[failures]))),
        (Ill::Crossing, 2) => Some(spread(moving.len())),
        (Ill::Crossing, 3) => Some(around.dropped(core)),
        (Ill::Bare, 0) => Some(around.added(*place.cells.first()?)),
        (Ill::Bare, 1) => Some(with_one()),
        (Ill::Bare, 2 | 3) => Some(finer(failures - 2)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(x: f64, weight: f64) -> Place {
        Place {
            ill: Ill::Invalid,
            at: Vec3::new(x, 0.0, 0.0),
            reach: 1.0,
            cells: Vec::new(),
            weight,
        }
    }

    /// A cure that has replaced one seed by another.
    fn cure(place: Place, before: u32, after: u32) -> Cure {
        let seed = |v| vec![Seed::at(VertexId::new(v))];
        Cure {
            place,
            change: Reseeded {
                removed: seed(before),
                added: seed(after),
            },
        }
    }

    fn two_cures() -> (Cures, Vec<Seed>) {
        let cures = Cures {
            apart: true,
            last: vec![cure(place(0.0, 2.0), 1, 2), cure(place(9.0, 2.0), 3, 4)],
            failed: Vec::new(),
        };
        let seeds = [2, 4].map(|v| Seed::at(VertexId::new(v))).to_vec();
        (cures, seeds)
    }

    fn left(seeds: &[Seed]) -> Vec<usize> {
        seeds.iter().map(|s| s.vertex.index()).collect()
    }

    #[test]
    fn what_helps_at_one_place_is_kept_whatever_happens_at_another() {
        let (mut cures, mut seeds) = two_cures();
        let before = [place(0.0, 2.0), place(9.0, 2.0), place(30.0, 1.0)];
        // The first place is better, the second one worse by a crossing beside it, and another one is new.
        let now = vec![
            place(0.2, 1.0),
            place(9.3, 2.0),
            place(8.9, 1.0),
            place(20.0, 1.0),
        ];
        let verdict = cures.judge(&before, now, &[], &mut seeds);
        assert_eq!(left(&seeds), [2, 3]);
        let at: Vec<f64> = verdict.open.iter().map(|p| p.at.x).collect();
        assert_eq!(at, [9.0, 0.2, 20.0]);
        assert_eq!((verdict.helped.len(), verdict.undone.len()), (1, 1));
        assert!(verdict.is_undone(Vec3::new(8.0, 0.0, 0.0)));
        assert!(!verdict.is_undone(Vec3::new(1.0, 0.0, 0.0)));
        assert!(!verdict.is_undone(Vec3::new(20.0, 0.0, 0.0)));
        assert_eq!(cures.failures(&place(9.1, 1.0)), 1);
        assert_eq!(cures.failures(&place(0.0, 1.0)), 0);
    }

    #[test]
    fn a_cure_after_which_panels_are_not_planar_has_not_helped() {
        let (mut cures, mut seeds) = two_cures();
        let before = [place(0.0, 2.0), place(9.0, 2.0)];
        let verdict = cures.judge(&before, Vec::new(), &[Vec3::zeros()], &mut seeds);
        assert_eq!(left(&seeds), [1, 4]);
        assert_eq!(verdict.open.len(), 1);
        assert_eq!(verdict.undone[0].at, Vec3::zeros());
    }
}
