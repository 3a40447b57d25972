//! Panels on sheets, by their true shapes.
//!
//! Neighbours in the mesh fit together on a sheet as they do on the building. So a sheet is filled from a first panel
//! outwards: of the panels next to those that lie on it, each turned such that it is flush with a neighbour, the one that
//! reaches least far along the sheet is put next. When none of them fits, others fill the gaps; when none of those does,
//! the sheet is closed.
//!
//! For each rotation, the places where a panel touches two others, or one and the border, come from the no-fit polygons of
//! convex pieces (Burke et al., "Complete and robust no-fit polygon generation for the irregular stock cutting problem",
//! 2007; here a source of candidates only). The first that [jagua-rs](https://crates.io/crates/jagua-rs) finds free of
//! collisions, by growing cost, is taken.
//!
//! *Guaranteed*: [`nest`] ends with an independent check in double precision of both faces of all panels. The same for any
//! number of threads.

mod candidates;
pub mod check;
mod convex;
mod engine;
mod shape;

use crate::error::FabError;
use crate::options::FabOptions;
use crate::outline::least_rectangle;
use crate::plate::Plate;
use candidates::Zone;
use engine::{Engine, Margins};
use phex_mesh::{EdgeId, Vec2};
use rayon::prelude::*;
use shape::{Place, Shape};
use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};

/// How many panels are tried for the gaps of a sheet before it is closed.
const PATIENCE: usize = 12;
/// How many of the panels next to those on a sheet are compared.
const CHOICE: usize = 8;

/// Where a panel lies on a sheet: `p -> rotation p + translation`, in mm; the sheet's corner is the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Number of the panel.
    pub plate: usize,
    /// Angle in radians, counter-clockwise.
    pub rotation: f64,
    /// Where the panel's own origin is.
    pub translation: Vec2,
}

impl Placement {
    /// Brings points of the panel to the sheet.
    pub fn apply(&self, points: &[Vec2]) -> Vec<Vec2> {
        let (s, c) = self.rotation.sin_cos();
        let turned = |p: &Vec2| Vec2::new(c * p.x - s * p.y, s * p.x + c * p.y);
        points
            .iter()
            .map(|p| turned(p) + self.translation)
            .collect()
    }
}

/// The panels of one sheet, in the order in which they were placed.
pub type SheetLayout = Vec<Placement>;

/// Puts all panels on sheets. `name` gives the name of a panel for messages.
///
/// # Errors
/// If a panel does not fit on an empty sheet, or a shape is refused.
pub fn nest(
    plates: &[Plate],
    options: &FabOptions,
    name: impl Fn(usize) -> String,
) -> Result<Vec<SheetLayout>, FabError> {
    let margins = Margins::new(options.sheet_mm, options.spacing_mm);
    let refused = |k: usize, cause: String| FabError::Nest {
        panel: name(k),
        cause,
    };
    let shapes: Vec<Shape> = plates
        .iter()
        .enumerate()
        .map(|(k, plate)| {
            Shape::new(k, plate, margins, &options.rotations).map_err(|cause| refused(k, cause))
        })
        .collect::<Result<_, _>>()?;
    let border = Border::new(options.sheet_mm, margins);
    let empty = Engine::new(&border.corners()).map_err(|cause| refused(0, cause))?;
    check_sizes(&shapes, plates, &border, &empty, options, &name)?;
    let mut left = Left::new(plates);
    let mut sheets = Vec::new();
    while let Some(first) = left.first() {
        let starts: Vec<Place> = shapes[first].starts(&border, &empty);
        let filled = starts.par_iter().map(|&start| {
            let mut sheet = Sheet::new(&empty, plates, left.clone());
            sheet.put(&shapes[first], start);
            sheet.fill(&shapes, &border);
            sheet
        });
        let filled: Vec<Sheet> = filled.collect();
        let best = filled
            .into_iter()
            .reduce(|a, b| if b.score() > a.score() { b } else { a });
        let Some(best) = best else {
            return Err(refused(
                first,
                "there is no place for it on an empty sheet".into(),
            ));
        };
        left = best.left;
        sheets.push(best.layout);
    }
    check::check(plates, &sheets, options)
        .map_err(|cause| refused(cause.plate, cause.to_string()))?;
    Ok(sheets)
}

/// Refuses panels that do not fit on an empty sheet.
fn check_sizes(
    shapes: &[Shape],
    plates: &[Plate],
    border: &Border,
    empty: &Engine,
    options: &FabOptions,
    name: &impl Fn(usize) -> String,
) -> Result<(), FabError> {
    let fits = |shape: &Shape| {
        shape
            .best_place(&shape.rotations, border, &[], empty)
            .is_some()
    };
    let large: Vec<usize> = shapes
        .par_iter()
        .enumerate()
        .filter(|(_, s)| !fits(s))
        .map(|(k, _)| k)
        .collect();
    let Some(&first) = large.first() else {
        return Ok(());
    };
    Err(FabError::TooLarge {
        panel: name(first),
        size: least_rectangle(&plates[first].outline),
        sheet: options.sheet_mm,
        spacing: options.spacing_mm,
        others: large.len() - 1,
    })
}

/// The part of a sheet that shapes (with half of the spacing round them) may cover.
struct Border {
    low: Vec2,
    high: Vec2,
}

impl Border {
    fn new(sheet: [f64; 2], margins: Margins) -> Self {
        let inset = Vec2::repeat(margins.half_spacing);
        Self {
            low: inset,
            high: Vec2::from(sheet) - inset,
        }
    }

    fn corners(&self) -> [Vec2; 4] {
        let (l, h) = (self.low, self.high);
        [l, Vec2::new(h.x, l.y), h, Vec2::new(l.x, h.y)]
    }
}

/// The panels that are on no sheet yet.
#[derive(Clone)]
struct Left {
    is_left: Vec<bool>,
    /// All panels, from one end of the mesh to the other.
    order: Vec<usize>,
}

impl Left {
    fn new(plates: &[Plate]) -> Self {
        let order = breadth_first(plates, 0);
        let end = order.last().copied().unwrap_or(0);
        Self {
            is_left: vec![true; plates.len()],
            order: breadth_first(plates, end),
        }
    }

    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.order.iter().copied().filter(|&k| self.is_left[k])
    }

    fn first(&self) -> Option<usize> {
        self.iter().next()
    }

    fn take(&mut self, plate: usize) {
        self.is_left[plate] = false;
    }
}

/// All panels by their distance from one of them in steps over edges; further parts of the mesh follow.
fn breadth_first(plates: &[Plate], start: usize) -> Vec<usize> {
    let mut seen = vec![false; plates.len()];
    let mut order = Vec::with_capacity(plates.len());
    for root in std::iter::once(start).chain(0..plates.len()) {
        let mut at = order.len();
        if !std::mem::replace(&mut seen[root], true) {
            order.push(root);
        }
        while at < order.len() {
            for next in plates[order[at]].sides.iter().filter_map(|s| s.neighbour) {
                if !std::mem::replace(&mut seen[next.index()], true) {
                    order.push(next.index());
                }
            }
            at += 1;
        }
    }
    order
}

/// A sheet that is being filled.
struct Sheet<'a> {
    plates: &'a [Plate],
    left: Left,
    engine: Engine,
    /// Convex pieces of everything on it.
    pieces: Vec<Zone>,
    layout: SheetLayout,
    area: f64,
    reach: f64,
    /// Panels that fit in none of their own rotations; they never will, since the sheet only gets fuller.
    failed: HashSet<usize>,
    /// The same for a panel flush with a certain side.
    failed_beside: HashSet<(usize, EdgeId)>,
    /// The best place of panels beside those on the sheet when it was last looked for, with the number of rotations.
    known: HashMap<usize, (usize, Place)>,
}

/// A panel with rotations to try.
struct Trial {
    plate: usize,
    /// Rotations with the side that they are flush with.
    rotations: Vec<(f64, EdgeId)>,
    back: f64,
}

impl<'a> Sheet<'a> {
    fn new(empty: &Engine, plates: &'a [Plate], left: Left) -> Self {
        Self {
            plates,
            left,
            engine: empty.clone(),
            pieces: Vec::new(),
            layout: Vec::new(),
            area: 0.0,
            reach: 0.0,
            failed: HashSet::new(),
            failed_beside: HashSet::new(),
            known: HashMap::new(),
        }
    }

    /// The more panels the better; the shorter the better if all are on it.
    fn score(&self) -> (f64, f64) {
        (self.area, -self.reach)
    }

    fn fill(&mut self, shapes: &[Shape], border: &Border) {
        loop {
            let next = self
                .grow(shapes, border)
                .or_else(|| self.fill_gap(shapes, border));
            let Some((plate, place)) = next else { break };
            self.put(&shapes[plate], place);
        }
    }

    /// The best panel beside those on the sheet.
    fn grow(&mut self, shapes: &[Shape], border: &Border) -> Option<(usize, Place)> {
        while let trials = self.beside()
            && !trials.is_empty()
        {
            let place = |trial: &Trial| {
                let shape = &shapes[trial.plate];
                let known = self.known.get(&trial.plate).filter(|(rotations, place)| {
                    *rotations == trial.rotations.len() && shape.is_free(place, &self.engine)
                });
                known.map(|(_, place)| *place).or_else(|| {
                    let rotations: Vec<f64> = trial.rotations.iter().map(|(r, _)| *r).collect();
                    shape.best_place(
                        &shape.allowed(rotations),
                        border,
                        &self.pieces,
                        &self.engine,
                    )
                })
            };
            let places: Vec<Option<Place>> = trials.par_iter().map(place).collect();
            let mut best: Option<(usize, Place)> = None;
            for (trial, place) in trials.iter().zip(places) {
                let Some(place) = place else {
                    self.failed_beside
                        .extend(trial.rotations.iter().map(|(_, edge)| (trial.plate, *edge)));
                    continue;
                };
                self.known
                    .insert(trial.plate, (trial.rotations.len(), place));
                if best.is_none_or(|(_, least)| place.cost < least.cost) {
                    best = Some((trial.plate, place));
                }
            }
            if best.is_some() {
                return best;
            }
        }
        None
    }

    /// The first of the panels that are left that fits anywhere.
    fn fill_gap(&mut self, shapes: &[Shape], border: &Border) -> Option<(usize, Place)> {
        let left: Vec<usize> = self
            .left
            .iter()
            .filter(|k| !self.failed.contains(k))
            .collect();
        for k in left
            .into_iter()
            .take(PATIENCE.saturating_sub(self.failed.len()))
        {
            let place =
                shapes[k].best_place(&shapes[k].rotations, border, &self.pieces, &self.engine);
            match place {
                Some(place) => return Some((k, place)),
                None => self.failed.insert(k),
            };
        }
        None
    }

    /// Panels that are left beside those on the sheet, with the rotations that make them flush; those whose neighbours lie
    /// farthest back come first.
    fn beside(&self) -> Vec<Trial> {
        let mut found: Vec<Trial> = Vec::new();
        for placement in &self.layout {
            for side in &self.plates[placement.plate].sides {
                let left = |k: &usize| {
                    self.left.is_left[*k] && !self.failed_beside.contains(&(*k, side.edge))
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

    fn put(&mut self, shape: &Shape, place: Place) {
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
        self.layout.push(placement);
        self.left.take(shape.plate);
        self.area += shape.area;
        self.reach = self.reach.max(place.reach);
    }
}
