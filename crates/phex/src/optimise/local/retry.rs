//! Retries at the end, around panels that stand off the surface by more than is allowed, folded,
//! needlessly concave and tight ones.
//!
//! The phases end when the energy of the whole hardly falls, and one panel counts little in it: it
//! may come out tight where its neighbours would have given way. Around each such panel some rings
//! of faces go through the last phases again, everything else at rest, with stronger closeness or
//! with a stronger barrier that reaches farther, and are projected. Around edges over which panels
//! fold these phases have folds pay, around panels that are concave where the surface is convex
//! re-entrant corners. The result is taken if it is planar, better in what was wanted, breaks
//! nothing, and costs nothing else that counts.

use super::demand::{Allowed, Demand, Judged, Wish, areas, clearances, largest, sharpest_angle};
use crate::optimise::concavity::{is_concave, to_be_convex};
use crate::optimise::error::OptimiseError;
use crate::optimise::folds::FoldTerm;
use crate::optimise::guard::Breach;
use crate::optimise::panels::{Panels, Shape, extent};
use crate::optimise::parts::{LARGE, Part, with_neighbours};
use crate::optimise::path::Path;
use crate::optimise::reached::Reached;
use crate::optimise::reference::Reference;
use crate::optimise::setting::{Setting, distances};
use crate::optimise::solvers::Solvers;

/// Clearance, in mean edges, that a panel should have, and the share of it below which it is tight.
/// Retries end half-way to a minimum and enlarge rounding, to 1e-4 of a clearance: where nothing is
/// tight they are not worth that. What was minimised part by part has ended half-way already.
const ROOMY: f64 = 0.31;
const TIGHT: f64 = 0.65;
const TIGHT_IN_PARTS: f64 = 1.0;
/// Area, over the mean, below which a panel needs less.
const SMALL: f64 = 0.4;
/// Rings of faces around a panel that count as its surroundings; two more move along.
const RINGS: usize = 2;
/// Least reach of the barriers around tight panels of a finished mesh, over the clearance that is
/// wanted: small panels are kept open, and what lies beside gives way without becoming tight.
const BEYOND: f64 = 1.25;
/// Deviation, in mean edges, that more room may always cost, and clearance that nearness may.
const NEAR: f64 = 0.018;
const ROOM: f64 = 0.15;
/// Last phases that are gone through again, by rounds: where Newton's method follows it alone often
/// finds the room without leaving the constraints.
const PHASES: [usize; 3] = [3; 3];
const PHASES_BEFORE_NEWTON: [usize; 3] = [0, 1, 3];
/// Area, over the mean, that panels of a finished mesh keep: a little more than what counts as
/// small at the boundary.
const LEAST_AREA: f64 = 1.02 * phex_mesh::LEAST_RIM_AREA;
/// Deviation, in mean edges, and sharpest angle, radians, that the growth of small panels may
/// always cost, and the clearance, where it can be and at the least.
const LARGE_NEAR: f64 = 0.05;
const LARGE_ROOM: [f64; 2] = [0.2, 0.1];
const LARGE_ANGLE: f64 = 0.155;
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

impl Path<'_> {
    /// Draws panels that stand off too far nearer, unfolds folded ones, makes concave ones convex
    /// where the surface is, and gives tight ones more room.
    pub fn retry(&mut self, reached: Reached) -> Result<Reached, OptimiseError> {
        let setting = self.setting;
        let (panels, mut x) = (setting.panels, reached.x);
        let edge = setting.mean_edge;
        let allowed = self.options.max_deviation.map(|share| share * extent(&x));
        if let Some(limit) = allowed {
            let far = far_faces(setting, &x, limit);
            let demand = Demand {
                wish: Wish::Nearness { limit },
                allowed: Allowed::new(f64::INFINITY, ROOM * edge),
            };
            self.retry_around(far, &demand, &mut x)?;
        }
        let folded = folded_faces(setting, &Shape::at(panels, &x), &x);
        let demand = Demand {
            wish: Wish::Unfolded,
            allowed: Allowed::new(FOLD_NEAR * edge, FOLD_ROOM * edge),
        };
        self.retry_around(folded, &demand, &mut x)?;
        let farthest = largest(&distances(setting, &x));
        let limit = farthest.max((NEAR * edge).min(allowed.unwrap_or(f64::MAX)));
        self.convex_where_the_surface_is(limit, &mut x)?;
        let share = match setting.reference {
            Reference::Start { .. } if panels.n_faces() > LARGE => TIGHT_IN_PARTS,
            _ => TIGHT,
        };
        let shape = Shape::at(panels, &x);
        let clearance = wanted(panels, &shape, panels.mean_edge(&x));
        let reach = None;
        let allowed = Allowed::new(limit, 0.0);
        self.widen(share, clearance, reach, allowed, &mut x)?;
        Ok(Reached::at(setting, x))
    }

    /// Takes away re-entrant corners that the surface gives no reason for.
    fn convex_where_the_surface_is(
        &mut self,
        limit: f64,
        x: &mut [f64],
    ) -> Result<(), OptimiseError> {
        let (panels, edge) = (self.setting.panels, self.setting.mean_edge);
        let shape = Shape::at(panels, x);
        let faces = to_be_convex(self.setting, &shape);
        let concave = |&f: &u32| {
            let corners = shape.face(panels, f as usize);
            faces[f as usize] && is_concave(corners, edge)
        };
        let concave = (0..panels.n_faces() as u32).filter(concave).collect();
        let demand = Demand {
            wish: Wish::Convex { faces },
            allowed: Allowed::new(limit, ROOMY * edge),
        };
        self.retry_around(concave, &demand, x)
    }

    /// Gives tight panels of a finished mesh more room where that costs neither nearness nor the
    /// sharpest angle.
    pub fn give_room(&mut self, x: &[f64]) -> Result<Vec<f64>, OptimiseError> {
        let (panels, edge) = (self.setting.panels, self.setting.mean_edge);
        let mut x = x.to_vec();
        let shape = Shape::at(panels, &x);
        let allowed = self.options.max_deviation.map(|share| share * extent(&x));
        let clearance = wanted_at_the_end(panels, &shape, edge);
        let allowed = Allowed {
            deviation: (NEAR * edge).min(allowed.unwrap_or(f64::MAX)),
            clearance: 0.0,
            angle: sharpest_angle(panels, &shape),
            area: LEAST_AREA * mean(&areas(panels, &shape)),
        };
        self.widen(1.0, clearance, Some(BEYOND), allowed, &mut x)?;
        Ok(x)
    }

    /// Makes small panels at the boundary of a finished mesh larger, where that can be without
    /// sharper angles, else with some.
    pub fn enlarge(&mut self, rim: &[bool], x: &[f64]) -> Result<Vec<f64>, OptimiseError> {
        let (panels, edge) = (self.setting.panels, self.setting.mean_edge);
        let mut x = x.to_vec();
        let shape = Shape::at(panels, &x);
        let least = LEAST_AREA * mean(&areas(panels, &shape));
        let allowed = self.options.max_deviation.map(|share| share * extent(&x));
        let sharpest = sharpest_angle(panels, &shape);
        let [room, least_room] = LARGE_ROOM;
        let last = (sharpest.min(LARGE_ANGLE), least_room);
        for (angle, clearance) in [(sharpest, room), (sharpest, least_room), last] {
            let areas = areas(panels, &Shape::at(panels, &x));
            let small = |&f: &u32| rim[f as usize] && areas[f as usize] < least;
            let small: Vec<u32> = (0..panels.n_faces() as u32).filter(small).collect();
            let wanted = rim.iter().map(|r| if *r { least } else { 0.0 }).collect();
            let demand = Demand {
                wish: Wish::Large { wanted },
                allowed: Allowed {
                    deviation: (LARGE_NEAR * edge).min(allowed.unwrap_or(f64::MAX)),
                    clearance: clearance * edge,
                    angle,
                    area: least,
                },
            };
            self.retry_around(small, &demand, &mut x)?;
        }
        Ok(x)
    }

    /// Gives panels with less than a share of the clearance that is wanted more room.
    fn widen(
        &mut self,
        share: f64,
        clearance: Vec<f64>,
        reach: Option<f64>,
        allowed: Allowed,
        x: &mut [f64],
    ) -> Result<(), OptimiseError> {
        let panels = self.setting.panels;
        let clear = clearances(panels, &Shape::at(panels, x));
        let tight = |&f: &u32| clear[f as usize] < share * clearance[f as usize];
        let tight = (0..panels.n_faces() as u32).filter(tight).collect();
        let wish = Wish::Room { clearance, reach };
        self.retry_around(tight, &Demand { wish, allowed }, x)
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
        let folds = match demand.wish {
            Wish::Unfolded => {
                let y = part.of_vertices(x);
                Some(FoldTerm::new(&part.panels, &part.guard, &y))
            }
            _ => None,
        };
        let mut solvers = match &folds {
            Some(folds) => Solvers::with_folds(&part.panels, folds)?,
            None => Solvers::new(&part.panels)?,
        };
        let mut path = Path::new(&setting, &mut solvers, &anchor, options, progress)?;
        if let Some(place) = path.folds() {
            *place = folds;
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
