//! A sheet filled from a first panel outwards, neighbours beside neighbours.

use super::candidates::Zone;
use super::engine::Engine;
use super::left::Left;
use super::shape::{FreePlace, PlateShape};
use super::{Border, Placement, SheetLayout};
use crate::plate::{Plate, PlateSide};
use phex_mesh::EdgeId;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};

/// How many panels are tried for the gaps of a sheet before it is closed.
const PATIENCE: usize = 12;
/// How many of the panels next to those on a sheet are compared.
const CHOICE: usize = 8;

/// A sheet that is being filled.
pub struct Sheet<'a> {
    plates: &'a [Plate],
    /// Panels that are on no sheet.
    pub left: Left,
    engine: Engine,
    /// Convex pieces of everything on it.
    pieces: Vec<Zone>,
    /// What is on it.
    pub layout: SheetLayout,
    /// Numbers in the layout of panels beside which some may be left.
    front: Vec<usize>,
    area: f64,
    reach: f64,
    /// Panels that fit in none of their own rotations; they never will, since the sheet only gets
    /// fuller.
    failed: HashSet<usize>,
    /// The same for a panel flush with a certain side.
    failed_beside: HashSet<(usize, EdgeId)>,
    /// The best place of panels beside those on the sheet when it was last looked for, with the
    /// number of rotations.
    known: HashMap<usize, (usize, FreePlace)>,
}

/// A panel with rotations to try.
struct Trial {
    plate: usize,
    /// Rotations with the side that they are flush with.
    rotations: Vec<(f64, EdgeId)>,
    back: f64,
}

impl<'a> Sheet<'a> {
    /// An empty one.
    pub fn new(empty: &Engine, plates: &'a [Plate], left: Left) -> Self {
        Self {
            plates,
            left,
            engine: empty.clone(),
            pieces: Vec::new(),
            layout: Vec::new(),
            front: Vec::new(),
            area: 0.0,
            reach: 0.0,
            failed: HashSet::new(),
            failed_beside: HashSet::new(),
            known: HashMap::new(),
        }
    }

    /// The more panels the better; the shorter the better if all are on it.
    pub fn score(&self) -> (f64, f64) {
        (self.area, -self.reach)
    }

    /// Puts panels on it until none fits.
    pub fn fill(&mut self, shapes: &[PlateShape], border: &Border) {
        loop {
            let next = self
                .grow(shapes, border)
                .or_else(|| self.fill_gap(shapes, border));
            let Some((plate, place)) = next else { break };
            self.put(&shapes[plate], place);
        }
    }

    /// The best panel beside those on the sheet.
    fn grow(&mut self, shapes: &[PlateShape], border: &Border) -> Option<(usize, FreePlace)> {
        while let trials = self.beside()
            && !trials.is_empty()
        {
            let known = |t: &Trial| {
                let known = self.known.get(&t.plate);
                known.filter(|(rotations, _)| *rotations == t.rotations.len())
            };
            let (old, new): (Vec<&Trial>, Vec<&Trial>) =
                trials.iter().partition(|t| known(t).is_some());
            let place = |t: &&Trial| self.place(t, shapes, border);
            let places: Vec<Option<FreePlace>> = new.par_iter().map(place).collect();
            let mut best: Option<(usize, FreePlace)> = None;
            for (trial, place) in new.into_iter().zip(places) {
                self.learn(trial, place, &mut best);
            }
            // A sheet gets fuller: what a panel cost before is nearly the least that it costs now.
            let cost = |t: &Trial| self.known.get(&t.plate).map_or(0.0, |(_, p)| p.cost);
            let mut old: Vec<(f64, &Trial)> = old.into_iter().map(|t| (cost(t), t)).collect();
            old.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (before, trial) in old {
                if best.is_some_and(|(_, least)| least.cost <= before) {
                    break;
                }
                let place = self.known[&trial.plate].1;
                let place = if shapes[trial.plate].is_free(&place, &self.engine) {
                    Some(place)
                } else {
                    self.place(trial, shapes, border)
                };
                self.learn(trial, place, &mut best);
            }
            if best.is_some() {
                return best;
            }
        }
        None
    }

    /// The best place of a panel in the rotations of a trial.
    fn place(&self, trial: &Trial, shapes: &[PlateShape], border: &Border) -> Option<FreePlace> {
        let shape = &shapes[trial.plate];
        let rotations = shape.allowed(trial.rotations.iter().map(|(r, _)| *r).collect());
        shape.best_place(&rotations, border, &self.pieces, &self.engine)
    }

    /// Keeps what was found for a trial, and the best of all.
    fn learn(
        &mut self,
        trial: &Trial,
        place: Option<FreePlace>,
        best: &mut Option<(usize, FreePlace)>,
    ) {
        let Some(place) = place else {
            let edges = trial.rotations.iter().map(|(_, edge)| *edge);
            self.failed_beside
                .extend(edges.map(|edge| (trial.plate, edge)));
            return;
        };
        self.known
            .insert(trial.plate, (trial.rotations.len(), place));
        if best.is_none_or(|(_, least)| place.cost < least.cost) {
            *best = Some((trial.plate, place));
        }
    }

    /// The first of the panels that are left that fits anywhere.
    fn fill_gap(&mut self, shapes: &[PlateShape], border: &Border) -> Option<(usize, FreePlace)> {
        let more = PATIENCE.saturating_sub(self.failed.len());
        let new = self.left.iter().filter(|k| !self.failed.contains(k));
        for k in new.take(more).collect::<Vec<_>>() {
            let place =
                shapes[k].best_place(&shapes[k].rotations, border, &self.pieces, &self.engine);
            match place {
                Some(place) => return Some((k, place)),
                None => self.failed.insert(k),
            };
        }
        None
    }

    /// Panels that are left beside those on the sheet, with the rotations that make them flush;
    /// those whose neighbours lie farthest back come first.
    fn beside(&mut self) -> Vec<Trial> {
        let is_left = |side: &PlateSide| side.neighbour.is_some_and(|f| self.left.holds(f.index()));
        let has_left = |k: &usize| self.plates[self.layout[*k].plate].sides.iter().any(is_left);
        self.front.retain(has_left);
        let mut found: Vec<Trial> = Vec::new();
        for placement in self.front.iter().map(|k| &self.layout[*k]) {
            for side in &self.plates[placement.plate].sides {
                let left = |k: &usize| {
                    self.left.holds(*k) && !self.failed_beside.contains(&(*k, side.edge))
                };
                let Some(plate) = side.neighbour.map(|f| f.index()).filter(left) else {
                    continue;
                };
                let Some(rotation) = self.flush(placement, side.edge, plate) else {
                    continue;
                };
                match found.iter_mut().find(|t| t.plate == plate) {
                    Some(trial) => trial.rotations.push((rotation, side.edge)),
                    None => found.push(Trial {
                        plate,
                        rotations: vec![(rotation, side.edge)],
                        back: placement.translation.x,
                    }),
                }
            }
        }
        found.sort_by(|a, b| a.back.total_cmp(&b.back));
        found.truncate(CHOICE);
        found
    }

    /// The rotation of a panel that lays its side along that of a placed neighbour.
    fn flush(&self, placement: &Placement, edge: EdgeId, plate: usize) -> Option<f64> {
        let angle = |k: usize| {
            let plate = &self.plates[k];
            let side = plate.sides.iter().position(|s| s.edge == edge)?;
            let d = plate.top[(side + 1) % plate.top.len()] - plate.top[side];
            Some(d.y.atan2(d.x))
        };
        let turn = placement.rotation + angle(placement.plate)? + PI - angle(plate)?;
        Some(turn.rem_euclid(TAU))
    }

    /// Puts a panel there.
    pub fn put(&mut self, shape: &PlateShape, place: FreePlace) {
        let placement = Placement {
            plate: shape.plate,
            rotation: place.rotation,
            translation: place.translation,
        };
        self.engine
            .put(&shape.item, place.rotation, place.translation);
        self.pieces.extend(
            shape
                .pieces
                .iter()
                .map(|piece| Zone::new(placement.apply(piece))),
        );
        self.front.push(self.layout.len());
        self.layout.push(placement);
        self.left.take(shape.plate);
        self.area += shape.area;
        self.reach = self.reach.max(place.reach);
    }
}
