//! Retries at the end, around panels that stand off the surface by more than is allowed, folded and tight ones.
//!
//! The phases end when the energy of the whole hardly falls, and one panel counts little in it: it may come out tight where its neighbours
//! would have given way. Around each such panel some rings of faces go through the last phases again, everything else at rest,
//! with stronger closeness or with a stronger barrier that reaches farther, and are projected. Around edges over which panels fold these
//! phases have folds pay. The result is taken if it is planar, better in what was wanted, breaks nothing, and costs nothing else that counts.

use super::barrier::clearance;
use super::closeness::Reference;
use super::energy::{Setting, distances};
use super::guard::Breach;
use super::hinges::HingeTerm;
use super::options::OptimiseError;
use super::panels::{Panels, Shape, extent};
use super::parts::{LARGE, Part, with_neighbours};
use super::path::Path;
use super::run::Reached;
use super::simple::area;
use super::solvers::Solvers;

/// Clearance, in mean edges, that a panel should have, and the share of it below which it is tight. Retries end half-way to a
/// minimum and enlarge rounding, to 1e-4 of a clearance: where nothing is tight they are not worth that. What was minimised part by
/// part has ended half-way already.
const ROOMY: f64 = 0.31;
const TIGHT: f64 = 0.65;
const TIGHT_IN_PARTS: f64 = 1.0;
/// Area, over the mean, below which a panel needs less.
const SMALL: f64 = 0.4;
/// Rings of faces around a panel that count as its surroundings; two more move along.
const RINGS: usize = 2;
/// The same where a layout has changed; more where with fewer panels do not become planar.
const SETTLED_RINGS: [usize; 2] = [2, 5];
/// Factor of barriers or closeness from one round for a group of panels to the next.
const STRONGER: f64 = 4.0;
/// Reach of the barriers of tight panels, over the reach that is usual.
const FARTHER: f64 = 1.4;
/// Least reach of the barriers around tight panels of a finished mesh, over the clearance that is wanted: small panels are kept
/// open, and what lies beside gives way without becoming tight.
const BEYOND: f64 = 1.25;
/// Deviation, in mean edges, that more room may always cost, and clearance that nearness may.
const NEAR: f64 = 0.018;
const ROOM: f64 = 0.15;
/// Last phases that are gone through again, by rounds: where Newton's method follows it alone often finds the room without leaving the
/// constraints.
const PHASES: [usize; 3] = [3; 3];
const PHASES_BEFORE_NEWTON: [usize; 3] = [0, 1, 3];
/// Area, over the mean, that panels of a finished mesh keep: a little more than what counts as small at the boundary.
const LEAST_AREA: f64 = 1.02 * phex_mesh::LEAST_RIM_AREA;
/// Weight of a fold at first, over that of closeness, and the factor from each round to the next.
const FOLD_WEIGHT: f64 = 1.0;
const FOLD_STRONGER: f64 = 10.0;
/// Deviation, in mean edges, that a fold's end may always cost, and the clearance.
const FOLD_NEAR: f64 = 0.3;
const FOLD_ROOM: f64 = 0.08;

/// Clearance that each face should have; less where faces are small.
fn wanted(panels: &Panels, shape: &Shape, mean_edge: f64) -> Vec<f64> {
    let areas = areas(panels, shape);
    let mean = mean(&areas);
    let wanted = areas.iter().map(|&a| wanted_of(a, mean, mean_edge));
    wanted.collect()
}

/// The same for a finished mesh: small panels need as much as the largest beside them.
fn wanted_at_the_end(panels: &Panels, shape: &Shape, mean_edge: f64) -> Vec<f64> {
    let areas = areas(panels, shape);
    let around = |f: usize| with_neighbours(panels, &[f as u32]);
    let largest = |f: usize| {
        around(f)
            .iter()
            .map(|g| areas[*g as usize])
            .fold(0.0, f64::max)
    };
    let mean = mean(&areas);
    let of_face = |f: usize| wanted_of(largest(f), mean, mean_edge);
    (0..panels.n_faces()).map(of_face).collect()
}

fn areas(panels: &Panels, shape: &Shape) -> Vec<f64> {
    let areas = (0..panels.n_faces()).map(|f| area(shape.face(panels, f)).abs());
    areas.collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Clearance for an area.
fn wanted_of(area: f64, mean: f64, mean_edge: f64) -> f64 {
    ROOMY * mean_edge * (area / (SMALL * mean)).sqrt().min(1.0)
}

/// Groups of faces that hang together.
fn groups(panels: &Panels, mut faces: Vec<u32>) -> Vec<Vec<u32>> {
    let mut groups = Vec::new();
    while let Some(first) = faces.pop() {
        let mut group = vec![first];
        loop {
            let around = with_neighbours(panels, &group);
            let (near, far) = faces.iter().partition(|f| around.binary_search(f).is_ok());
            faces = far;
            let near: Vec<u32> = near;
            if near.is_empty() {
                break;
            }
            group.extend(near);
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// What is wanted of a part. Lengths are in the unit of the mesh.
enum Demand {
    /// A clearance of each face; the deviation may grow up to `limit`, the sharpest angle fall to `angle`, radians.
    /// Barriers reach at least `reach` times as far as the clearance of their face.
    Room {
        clearance: Vec<f64>,
        limit: f64,
        angle: f64,
        reach: Option<f64>,
        /// Area below which no more faces may come.
        area: f64,
    },
    /// Distances to the surface of `limit` at the most; clearances may shrink to `least`.
    Nearness { limit: f64, least: f64 },
    /// No folds; the deviation may grow up to `limit`, clearances may shrink to `least`.
    Unfolded { limit: f64, least: f64 },
}

impl Demand {
    fn of_part(&self, part: &Part<'_>) -> Self {
        match self {
            Self::Room {
                clearance,
                limit,
                angle,
                reach,
                area,
            } => Self::Room {
                clearance: part.of_faces(clearance),
                limit: *limit,
                angle: *angle,
                reach: *reach,
                area: *area,
            },
            Self::Nearness { limit, least } => Self::Nearness {
                limit: *limit,
                least: *least,
            },
            Self::Unfolded { limit, least } => Self::Unfolded {
                limit: *limit,
                least: *least,
            },
        }
    }

    /// How much is missing; 0 if nothing is.
    fn shortfall(&self, clearances: &[f64], distances: &[f64], folds: f64) -> f64 {
        let squared = |excess: f64| excess.max(0.0).powi(2);
        match self {
            Self::Room { clearance, .. } => {
                let pairs = clearances.iter().zip(clearance);
                pairs.map(|(c, wanted)| squared(1.0 - c / wanted)).sum()
            }
            Self::Nearness { limit, .. } => {
                distances.iter().map(|d| squared(d / limit - 1.0)).sum()
            }
            Self::Unfolded { .. } => folds,
        }
    }

    /// Faces that are too small.
    fn small(&self, panels: &Panels, shape: &Shape) -> usize {
        match self {
            Self::Room { area, .. } => {
                let areas = areas(panels, shape);
                areas.iter().filter(|a| *a < area).count()
            }
            Self::Nearness { .. } | Self::Unfolded { .. } => 0,
        }
    }

    /// Whether `now` costs too much against `before` in the other respect.
    fn costs_too_much(&self, now: &Judged, before: &Judged) -> bool {
        match self {
            Self::Room { limit, angle, .. } => {
                now.deviation > limit.max(before.deviation)
                    || now.angle < angle.min(before.angle)
                    || now.small > before.small
            }
            Self::Nearness { least, .. } => now.clearance < least.min(before.clearance),
            Self::Unfolded { limit, least } => {
                now.deviation > limit.max(before.deviation)
                    || now.clearance < least.min(before.clearance)
            }
        }
    }

    /// Asks for more of what is wanted of some faces, in a round.
    fn insist(&self, path: &mut Path<'_>, faces: &[usize], round: usize) {
        match self {
            Self::Room {
                clearance, reach, ..
            } => {
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
            Self::Nearness { .. } => {
                let closeness = &mut path.weights.closeness;
                closeness.vertex *= STRONGER;
                closeness.centre *= STRONGER;
                closeness.rim *= STRONGER;
            }
            Self::Unfolded { .. } => {
                let closeness = path.weights.closeness.vertex;
                let weight = FOLD_WEIGHT * closeness * FOLD_STRONGER.powi(round as i32);
                if let Some(Some(hinges)) = path.hinges() {
                    hinges.weight = weight;
                }
            }
        }
    }
}

impl Path<'_> {
    /// Draws panels that stand off too far nearer, and gives tight panels more room.
    pub fn retry(&mut self, reached: Reached) -> Result<Reached, OptimiseError> {
        let setting = self.setting;
        let (panels, mut x) = (setting.panels, reached.x);
        let edge = setting.mean_edge;
        let allowed = self.options.max_deviation.map(|share| share * extent(&x));
        if let Some(limit) = allowed {
            let least = ROOM * edge;
            let far = far_faces(setting, &x, limit);
            self.retry_around(far, &Demand::Nearness { limit, least }, &mut x)?;
        }
        let shape = Shape::at(panels, &x);
        let folded = folded_faces(setting, &shape, &x);
        let limit = FOLD_NEAR * edge;
        let least = FOLD_ROOM * edge;
        self.retry_around(folded, &Demand::Unfolded { limit, least }, &mut x)?;
        let share = match setting.reference {
            Reference::Start { .. } if panels.n_faces() > LARGE => TIGHT_IN_PARTS,
            _ => TIGHT,
        };
        let shape = Shape::at(panels, &x);
        let clearance = wanted(panels, &shape, panels.mean_edge(&x));
        let farthest = largest(&distances(setting, &x));
        let demand = Demand::Room {
            clearance,
            limit: farthest.max((NEAR * edge).min(allowed.unwrap_or(f64::MAX))),
            angle: 0.0,
            reach: None,
            area: 0.0,
        };
        self.widen(share, &demand, &mut x)?;
        Ok(Reached::at(setting, x))
    }

    /// Gives tight panels of a finished mesh more room where that costs neither nearness nor the sharpest angle.
    pub fn give_room(&mut self, x: &[f64]) -> Result<Vec<f64>, OptimiseError> {
        let (panels, edge) = (self.setting.panels, self.setting.mean_edge);
        let mut x = x.to_vec();
        let shape = Shape::at(panels, &x);
        let allowed = self.options.max_deviation.map(|share| share * extent(&x));
        let demand = Demand::Room {
            clearance: wanted_at_the_end(panels, &shape, edge),
            limit: (NEAR * edge).min(allowed.unwrap_or(f64::MAX)),
            angle: sharpest_angle(panels, &shape),
            reach: Some(BEYOND),
            area: LEAST_AREA * mean(&areas(panels, &shape)),
        };
        self.widen(1.0, &demand, &mut x)?;
        Ok(x)
    }

    /// Gives panels with less than a share of the clearance that is wanted more room.
    fn widen(&mut self, share: f64, demand: &Demand, x: &mut [f64]) -> Result<(), OptimiseError> {
        let Demand::Room { clearance, .. } = demand else {
            return Ok(());
        };
        let panels = self.setting.panels;
        let clear = clearances(panels, &Shape::at(panels, x));
        let tight = |&f: &u32| clear[f as usize] < share * clearance[f as usize];
        let tight = (0..panels.n_faces() as u32).filter(tight).collect();
        self.retry_around(tight, demand, x)
    }

    /// Takes what is around some faces from the start to planar panels, everything else at rest in `x`; false if they do not become planar.
    pub fn settle_around(&mut self, faces: Vec<u32>, x: &mut [f64]) -> Result<bool, OptimiseError> {
        for group in groups(self.setting.panels, faces) {
            let mut settled = false;
            for rings in SETTLED_RINGS {
                settled = settled || self.settle_group(&group, rings, x)?;
            }
            if !settled || self.is_over() {
                return Ok(settled);
            }
        }
        Ok(true)
    }

    fn settle_group(
        &mut self,
        group: &[u32],
        rings: usize,
        x: &mut [f64],
    ) -> Result<bool, OptimiseError> {
        let part = Part::around(self.setting, &self.surroundings(group, rings), x);
        let setting = part.setting(self.setting.mean_edge);
        let (mut solvers, start) = (Solvers::new(&part.panels)?, part.of_vertices(self.start));
        let (options, progress) = (self.options, &self.reporter);
        let mut path = Path::new(&setting, &mut solvers, &start, options, progress)?;
        path.barriers = part.of_faces(&self.barriers);
        let reached = path.settle()?;
        self.in_parts += path.in_parts + path.outcome.factorisations;
        if path.is_over() {
            self.outcome.status = path.outcome.status;
        }
        let settled = path.is_over() || reached.is_planar(options);
        if settled {
            part.write_back(&reached.x, x);
        }
        Ok(settled)
    }

    /// Faces and some rings around them.
    fn surroundings(&self, group: &[u32], rings: usize) -> Vec<u32> {
        let wider = |core: Vec<u32>, _| with_neighbours(self.setting.panels, &core);
        (0..rings).fold(group.to_vec(), wider)
    }

    fn retry_around(
        &mut self,
        faces: Vec<u32>,
        demand: &Demand,
        x: &mut [f64],
    ) -> Result<(), OptimiseError> {
        for group in groups(self.setting.panels, faces) {
            if !self.is_over() {
                self.retry_group(&group, demand, x)?;
            }
        }
        Ok(())
    }

    fn retry_group(
        &mut self,
        group: &[u32],
        demand: &Demand,
        x: &mut [f64],
    ) -> Result<(), OptimiseError> {
        let part = Part::around(self.setting, &self.surroundings(group, RINGS), x);
        let setting = part.setting(self.setting.mean_edge);
        let anchor = part.of_vertices(self.start);
        let (options, progress) = (self.options, &self.reporter);
        let hinges = match demand {
            Demand::Unfolded { .. } => {
                let y = part.of_vertices(x);
                Some(HingeTerm::new(&part.panels, &part.guard, &y))
            }
            Demand::Room { .. } | Demand::Nearness { .. } => None,
        };
        let mut solvers = match &hinges {
            Some(hinges) => Solvers::with_hinges(&part.panels, hinges)?,
            None => Solvers::new(&part.panels)?,
        };
        let mut path = Path::new(&setting, &mut solvers, &anchor, options, progress)?;
        if let Some(folds) = path.hinges() {
            *folds = hinges;
        }
        path.weights = self.weights;
        path.barriers = part.of_faces(&self.barriers);
        let (group, demand) = (part.local_faces(group), demand.of_part(&part));
        let mut best = Judged::at(&setting, &demand, part.of_vertices(x));
        let phases: &[usize] = match path.newton_iterations() {
            0 => &PHASES,
            _ => &PHASES_BEFORE_NEWTON,
        };
        for (round, &count) in phases.iter().enumerate() {
            demand.insist(&mut path, &group, round);
            let now = Judged::at(&setting, &demand, path.again(&best.x, count)?);
            let dear = demand.costs_too_much(&now, &best);
            if path.is_over() {
                break;
            }
            if !dear && now.planarity <= options.planarity_tolerance && now.is_better(&best) {
                best = now;
            }
            if best.shortfall == 0.0 {
                break;
            }
        }
        self.in_parts += path.in_parts + path.outcome.factorisations;
        if path.is_over() {
            self.outcome.status = path.outcome.status;
        }
        part.write_back(&best.x, x);
        Ok(())
    }
}

/// Faces of which a corner or the centre is farther than `limit` from the surface.
fn far_faces(setting: &Setting<'_>, x: &[f64], limit: f64) -> Vec<u32> {
    let (panels, distances) = (setting.panels, distances(setting, x));
    let far = |k: usize| distances[k] > limit;
    let is_far = |&f: &u32| {
        let mut corners = panels.vertices(f as usize).iter();
        far(panels.n_vertices() + f as usize) || corners.any(|&v| far(v as usize))
    };
    (0..panels.n_faces() as u32).filter(is_far).collect()
}

/// Faces that fold against a neighbour.
fn folded_faces(setting: &Setting<'_>, shape: &Shape, x: &[f64]) -> Vec<u32> {
    let breaches = setting.guard.breaches(setting.panels, shape, x);
    let faces = breaches.iter().filter_map(|b| match b {
        Breach::Fold(faces) => Some(faces.map(|f| f as u32)),
        _ => None,
    });
    let mut faces: Vec<u32> = faces.flatten().collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

fn clearances(panels: &Panels, shape: &Shape) -> Vec<f64> {
    let faces = 0..panels.n_faces();
    faces.map(|f| clearance(shape.face(panels, f))).collect()
}

/// The smallest angle between two edges of a face, radians.
fn sharpest_angle(panels: &Panels, shape: &Shape) -> f64 {
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

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// What a part is judged by.
struct Judged {
    x: Vec<f64>,
    planarity: f64,
    shortfall: f64,
    clearance: f64,
    deviation: f64,
    angle: f64,
    /// Faces with less than the least area.
    small: usize,
    breaches: usize,
}

impl Judged {
    fn at(setting: &Setting<'_>, demand: &Demand, x: Vec<f64>) -> Self {
        let shape = Shape::at(setting.panels, &x);
        let clearances = clearances(setting.panels, &shape);
        let distances = distances(setting, &x);
        let breaches = setting.guard.breaches(setting.panels, &shape, &x);
        let excess = |b: &Breach| match b {
            Breach::Fold([f, g]) => -shape.normal(*f).dot(&shape.normal(*g)),
            _ => 0.0,
        };
        let folds = breaches.iter().map(excess).sum();
        Self {
            planarity: shape.max_height() / setting.mean_edge,
            shortfall: demand.shortfall(&clearances, &distances, folds),
            clearance: clearances.into_iter().fold(f64::INFINITY, f64::min),
            deviation: largest(&distances),
            angle: sharpest_angle(setting.panels, &shape),
            small: demand.small(setting.panels, &shape),
            breaches: breaches.len(),
            x,
        }
    }

    fn is_better(&self, other: &Self) -> bool {
        self.breaches <= other.breaches && self.shortfall < other.shortfall
    }
}
