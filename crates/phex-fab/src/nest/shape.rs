//! One panel as the nesting sees it.

use super::body::Body;
use super::candidates::{Zone, cheapest};
use super::convex::convex_pieces;
use super::engine::{Engine, Margins, Refusal, item};
use super::{Border, Placement};
use crate::options::Rotations;
use crate::outline::{convex_hull, grown};
use crate::plate::Plate;
use jagua_rs::entities::Item;
use phex_mesh::polygon::{sides, signed_area};
use phex_mesh::{Vec2, bounds};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// Angles closer than this are one.
const SAME_ANGLE: f64 = 1e-6;
/// How many rotations of the first panel of a sheet are compared.
const STARTS: usize = 2;

/// A panel with half of the spacing round it.
pub struct PlateShape {
    /// Number of the panel.
    pub plate: usize,
    /// The shape in the collision library.
    pub item: Arc<Item>,
    /// Convex pieces of a shape that is larger by what single precision may lose.
    pub pieces: Vec<Vec<Vec2>>,
    /// Area with the spacing, in mm².
    pub area: f64,
    /// Angles to try.
    pub rotations: Vec<f64>,
    is_free: bool,
}

/// A place that is free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreePlace {
    /// Angle in radians.
    pub rotation: f64,
    /// Where the panel's origin is.
    pub translation: Vec2,
    /// The less the better.
    pub cost: f64,
    /// How far along the sheet it reaches.
    pub reach: f64,
}

impl PlateShape {
    /// Prepares a panel.
    ///
    /// # Errors
    /// If the library refuses its shape.
    pub fn new(
        number: usize,
        plate: &Plate,
        margins: Margins,
        rotations: &Rotations,
    ) -> Result<Self, Refusal> {
        let wider = |distance: f64| grown(&plate.outline, &vec![distance; plate.outline.len()]);
        let exact = wider(margins.half_spacing + margins.rounding);
        let loose = wider(margins.half_spacing + 2.0 * margins.rounding);
        Ok(Self {
            plate: number,
            item: item(number, &exact)?,
            pieces: convex_pieces(&loose),
            area: signed_area(&exact),
            rotations: angles(&exact, rotations),
            is_free: *rotations == Rotations::Free,
        })
    }

    /// The panel as a body that can be pushed.
    pub fn body(&self) -> Body {
        let angles = (!self.is_free).then(|| self.rotations.clone());
        Body::new(&self.pieces, angles)
    }

    /// Where it may lie first on an empty sheet: in the rotations in which it reaches least far.
    pub fn starts(&self, border: &Border, empty: &Engine) -> Vec<FreePlace> {
        let places = self
            .rotations
            .iter()
            .filter_map(|&r| self.best_at(r, border, &[], empty));
        let mut places: Vec<FreePlace> = places.collect();
        places.sort_by(|a, b| a.reach.total_cmp(&b.reach));
        // Half a turn of everything on a sheet is the same sheet.
        let same = |a: &FreePlace, b: &FreePlace| {
            (a.rotation - b.rotation)
                .rem_euclid(PI)
                .min((b.rotation - a.rotation).rem_euclid(PI))
                < SAME_ANGLE
        };
        let mut starts: Vec<FreePlace> = Vec::new();
        for place in places {
            if starts.len() < STARTS && !starts.iter().any(|s| same(s, &place)) {
                starts.push(place);
            }
        }
        starts
    }

    /// Whether a place is free.
    pub fn is_free(&self, place: &FreePlace, engine: &Engine) -> bool {
        let mut scratch = self.item.shape_cd().as_ref().clone();
        engine.is_free(&self.item, place.rotation, place.translation, &mut scratch)
    }

    /// Rotations of which all are allowed: the given ones, or those of the options.
    pub fn allowed(&self, wanted: Vec<f64>) -> Vec<f64> {
        if self.is_free {
            wanted
        } else {
            self.rotations.clone()
        }
    }

    /// The best free place in one of several rotations on a sheet that holds some convex pieces.
    pub fn best_place(
        &self,
        rotations: &[f64],
        border: &Border,
        placed: &[Zone],
        engine: &Engine,
    ) -> Option<FreePlace> {
        let places: Vec<FreePlace> = rotations
            .par_iter()
            .filter_map(|&r| self.best_at(r, border, placed, engine))
            .collect();
        places
            .into_iter()
            .reduce(|a, b| if b.cost < a.cost { b } else { a })
    }

    /// The convex pieces in a rotation.
    pub fn turned(&self, rotation: f64) -> Vec<Vec<Vec2>> {
        let turn = turn(self.plate, rotation);
        self.pieces.iter().map(|p| turn.apply(p)).collect()
    }

    /// Length and width of the smallest box round a polygon of the panel, over the rotations.
    pub fn least_box(&self, polygon: &[Vec2]) -> [f64; 2] {
        let sizes = self.rotations.iter().map(|&rotation| {
            let [low, high] = bounds(&turn(self.plate, rotation).apply(polygon));
            [high.x - low.x, high.y - low.y]
        });
        let area = |[a, b]: [f64; 2]| a * b;
        let least = sizes.min_by(|&a, &b| area(a).total_cmp(&area(b)));
        let [a, b] = least.unwrap_or_default();
        if self.is_free {
            return [a.max(b), a.min(b)];
        }
        [a, b]
    }

    fn best_at(
        &self,
        rotation: f64,
        border: &Border,
        placed: &[Zone],
        engine: &Engine,
    ) -> Option<FreePlace> {
        let pieces = self.turned(rotation);
        let mut scratch = self.item.shape_cd().as_ref().clone();
        let free = |at| engine.is_free(&self.item, rotation, at, &mut scratch);
        let (cost, translation, reach) = cheapest(border, placed, &pieces, free)?;
        Some(FreePlace {
            rotation,
            translation,
            cost,
            reach,
        })
    }
}

fn turn(plate: usize, rotation: f64) -> Placement {
    Placement {
        plate,
        rotation,
        translation: Vec2::zeros(),
    }
}

/// The rotations to try: every side of the convex hull along every side of a sheet, or the ones
/// that are allowed.
fn angles(polygon: &[Vec2], rotations: &Rotations) -> Vec<f64> {
    if let Rotations::Degrees(list) = rotations {
        return list.iter().map(|d| d.to_radians()).collect();
    }
    let hull = convex_hull(polygon);
    let mut angles: Vec<f64> = sides(&hull)
        .flat_map(|[a, b]| {
            let d = b - a;
            let flush = -d.y.atan2(d.x);
            (0..4).map(move |k| (flush + FRAC_PI_2 * f64::from(k)).rem_euclid(TAU))
        })
        .collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|a, b| *a - *b < SAME_ANGLE);
    angles
}
