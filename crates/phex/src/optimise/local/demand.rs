//! What the retries at the end want of a part of a mesh, what it may cost, and how a result is
//! judged by that.

use crate::optimise::areas::AreaWish;
use crate::optimise::barrier::clearance;
use crate::optimise::concavity::{self, ConcavityTerm};
use crate::optimise::guard::Breach;
use crate::optimise::panels::{Panels, Shape};
use crate::optimise::parts::Part;
use crate::optimise::path::Path;
use crate::optimise::setting::{Setting, distances};
use crate::optimise::simple::area;

/// Factor of barriers or closeness from one round for a group of panels to the next.
const STRONGER: f64 = 4.0;
/// Reach of the barriers of tight panels, over the reach that is usual.
const FARTHER: f64 = 1.4;
/// Area that small faces pay for, over what is wanted: a penalty leaves a rest.
const AMPLE: f64 = 1.1;
/// Weight of a fold, a re-entrant corner or a small face at first, over that of closeness, and the
/// factor from each round to the next.
const FIRST_WEIGHT: f64 = 1.0;
const HEAVIER: f64 = 10.0;

/// What is wanted, and what it may cost. Lengths are in the unit of the mesh.
pub(super) struct Demand {
    pub wish: Wish,
    pub allowed: Allowed,
}

pub(super) enum Wish {
    /// A clearance of each face. Barriers reach at least `reach` times as far as the clearance of
    /// their face.
    Room {
        clearance: Vec<f64>,
        reach: Option<f64>,
    },
    /// Distances to the surface of `limit` at the most.
    Nearness { limit: f64 },
    /// No folds.
    Unfolded,
    /// No re-entrant corners of these faces.
    Convex { faces: Vec<bool> },
    /// An area of each face, 0 for any.
    Large { wanted: Vec<f64> },
}

/// Values up to which a result may always be worse; beyond them it may not be worse than before.
#[derive(Clone, Copy)]
pub(super) struct Allowed {
    /// Largest distance to the surface.
    pub deviation: f64,
    /// Least clearance.
    pub clearance: f64,
    /// Sharpest angle, radians.
    pub angle: f64,
    /// Area below which no more faces may come.
    pub area: f64,
}

impl Allowed {
    /// As much deviation, and clearances no smaller than a value.
    pub fn new(deviation: f64, clearance: f64) -> Self {
        Self {
            deviation,
            clearance,
            angle: 0.0,
            area: 0.0,
        }
    }
}

/// Relative difference that is rounding: much of a mesh stays where it is, and what is farthest off
/// or sharpest there must not count for more or less by chance.
const ROUNDING: f64 = 1e-9;

impl Demand {
    pub fn of_part(&self, part: &Part<'_>) -> Self {
        let wish = match &self.wish {
            Wish::Room { clearance, reach } => Wish::Room {
                clearance: part.of_faces(clearance),
                reach: *reach,
            },
            Wish::Nearness { limit } => Wish::Nearness { limit: *limit },
            Wish::Unfolded => Wish::Unfolded,
            Wish::Convex { faces } => Wish::Convex {
                faces: part.of_faces(faces),
            },
            Wish::Large { wanted } => Wish::Large {
                wanted: part.of_faces(wanted),
            },
        };
        Self {
            wish,
            allowed: self.allowed,
        }
    }

    /// How much is missing; 0 if nothing is.
    fn shortfall(&self, setting: &Setting<'_>, at: &DemandPlace<'_>) -> f64 {
        let squared = |excess: f64| excess.max(0.0).powi(2);
        match &self.wish {
            Wish::Room { clearance, .. } => {
                let pairs = at.clearances.iter().zip(clearance);
                pairs.map(|(c, wanted)| squared(1.0 - c / wanted)).sum()
            }
            Wish::Nearness { limit } => {
                let distances = at.distances.iter();
                distances.map(|d| squared(d / limit - 1.0)).sum()
            }
            Wish::Unfolded => {
                let excess = |b: &Breach| match b {
                    Breach::Fold([f, g]) => -at.shape.normal(*f).dot(&at.shape.normal(*g)),
                    _ => 0.0,
                };
                at.breaches.iter().map(excess).sum()
            }
            Wish::Convex { faces } => {
                let depth = |f: usize| {
                    let corners = at.shape.face(setting.panels, f);
                    concavity::depth(corners, setting.mean_edge)
                };
                let wished = (0..faces.len()).filter(|&f| faces[f]);
                wished.map(depth).sum()
            }
            Wish::Large { wanted } => {
                let pairs = at.areas.iter().zip(wanted).filter(|(_, w)| **w > 0.0);
                pairs.map(|(a, w)| squared(1.0 - a / w)).sum()
            }
        }
    }

    /// Whether `now` costs too much against `before` in other respects.
    pub fn costs_too_much(&self, now: &Judged, before: &Judged) -> bool {
        let worse = |now: f64, bound: f64| now > bound * (1.0 + ROUNDING);
        worse(now.deviation, self.allowed.deviation.max(before.deviation))
            || worse(self.allowed.clearance.min(before.clearance), now.clearance)
            || worse(self.allowed.angle.min(before.angle), now.angle)
            || now.small > before.small
    }

    /// Asks for more of what is wanted of some faces, in a round.
    pub fn insist(&self, path: &mut Path<'_>, faces: &[usize], round: usize) {
        let heavy = path.weights.closeness.vertex * FIRST_WEIGHT * HEAVIER.powi(round as i32);
        match &self.wish {
            Wish::Room { clearance, reach } => {
                if let Some(reach) = reach {
                    let barriers = path.barriers.iter_mut().zip(clearance);
                    barriers.for_each(|(b, c)| b.reach = b.reach.max(reach * c));
                }
                for &f in faces {
                    let barrier = &mut path.barriers[f];
                    match round {
                        0 => barrier.reach *= FARTHER,
                        _ => barrier.weight *= STRONGER,
                    }
                }
            }
            Wish::Nearness { .. } => {
                let closeness = &mut path.weights.closeness;
                closeness.vertex *= STRONGER;
                closeness.centre *= STRONGER;
                closeness.rim *= STRONGER;
            }
            Wish::Unfolded => {
                if let Some(Some(folds)) = path.folds() {
                    folds.weight = heavy;
                }
            }
            Wish::Convex { faces } => {
                let edge = path.setting.mean_edge;
                if let Some(concavity) = path.concavity() {
                    *concavity = Some(ConcavityTerm {
                        weight: heavy,
                        faces: faces.clone(),
                        edge,
                    });
                }
            }
            Wish::Large { wanted } => {
                // What gives way must not become tight.
                if round > 0 {
                    path.barriers.iter_mut().for_each(|b| b.weight *= STRONGER);
                }
                if let Some(areas) = path.areas() {
                    let wishes = areas.iter_mut().zip(wanted);
                    for (wish, area) in wishes.filter(|(_, area)| **area > 0.0) {
                        *wish = AreaWish {
                            area: AMPLE * area,
                            weight: heavy,
                            at_least: true,
                        };
                    }
                }
            }
        }
    }
}

pub(super) fn areas(panels: &Panels, shape: &Shape) -> Vec<f64> {
    let areas = (0..panels.n_faces()).map(|f| area(shape.face(panels, f)).abs());
    areas.collect()
}

pub(super) fn clearances(panels: &Panels, shape: &Shape) -> Vec<f64> {
    let faces = 0..panels.n_faces();
    faces.map(|f| clearance(shape.face(panels, f))).collect()
}

/// The smallest angle between two edges of a face, radians.
pub(super) fn sharpest_angle(panels: &Panels, shape: &Shape) -> f64 {
    let of_face = |f: usize| {
        let corners = shape.face(panels, f);
        let n = corners.len();
        let edge = |k: usize, l: usize| corners[l % n].position - corners[k].position;
        let angle = |k: usize| edge(k, k + 1).angle(&edge(k, k + n - 1));
        (0..n).map(angle).fold(f64::INFINITY, f64::min)
    };
    let faces = 0..panels.n_faces();
    faces.map(of_face).fold(f64::INFINITY, f64::min)
}

pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// What is measured of a part.
struct DemandPlace<'a> {
    shape: &'a Shape,
    clearances: Vec<f64>,
    distances: Vec<f64>,
    areas: Vec<f64>,
    breaches: Vec<Breach>,
}

/// What a part is judged by.
pub(super) struct Judged {
    pub x: Vec<f64>,
    pub planarity: f64,
    pub shortfall: f64,
    clearance: f64,
    deviation: f64,
    angle: f64,
    /// Faces with less than the least area.
    small: usize,
    breaches: usize,
}

impl Judged {
    pub fn at(setting: &Setting<'_>, demand: &Demand, x: Vec<f64>) -> Self {
        let shape = Shape::at(setting.panels, &x);
        let place = DemandPlace {
            shape: &shape,
            clearances: clearances(setting.panels, &shape),
            distances: distances(setting, &x),
            areas: areas(setting.panels, &shape),
            breaches: setting.guard.breaches(setting.panels, &shape, &x),
        };
        let small = place
            .areas
            .iter()
            .filter(|a| **a * (1.0 + ROUNDING) < demand.allowed.area);
        let small = small.count();
        Self {
            planarity: shape.max_height() / setting.mean_edge,
            shortfall: demand.shortfall(setting, &place),
            clearance: place.clearances.into_iter().fold(f64::INFINITY, f64::min),
            deviation: largest(&place.distances),
            angle: sharpest_angle(setting.panels, &shape),
            small,
            breaches: place.breaches.len(),
            x,
        }
    }

    pub fn is_better(&self, other: &Self) -> bool {
        let is_less = self.shortfall * (1.0 + ROUNDING) < other.shortfall;
        self.breaches <= other.breaches && is_less
    }
}
