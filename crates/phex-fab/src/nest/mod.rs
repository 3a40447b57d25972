//! Panels on sheets, by their true shapes.
//!
//! Neighbours in the mesh fit together on a sheet as they do on the building. So a sheet is filled
//! from a first panel outwards: of the panels next to those that lie on it, each turned such that
//! it is flush with a neighbour, the one that reaches least far along the sheet is put next. When
//! none of them fits, others fill the gaps; when none of those does, the sheet is closed.
//!
//! For each rotation, the places where a panel touches two others, or one and the border, come from
//! the no-fit polygons of convex pieces (Burke et al., "Complete and robust no-fit polygon
//! generation for the irregular stock cutting problem", 2007; here a source of candidates only).
//! The first that [jagua-rs](https://crates.io/crates/jagua-rs) finds free of collisions, by
//! growing cost, is taken.
//!
//! Then the sheet is made fuller by exchanging panels with those that are left, and the last one
//! shorter; both push overlapping panels apart, and jagua-rs has the last word.
//!
//! *Guaranteed*: [`nest`] ends with an independent check in double precision of both faces of all
//! panels. The same for any number of threads: the random choices have fixed seeds.

mod body;
mod candidates;
pub mod check;
mod convex;
mod engine;
mod exchange;
mod grow;
mod left;
mod neighbours;
mod separate;
mod shape;
mod smallest;
mod squeeze;
#[cfg(test)]
mod tests;

use crate::error::{FabError, TooLarge};
use crate::options::{FabOptions, Rotations};
use crate::plate::Plate;
use body::Body;
use engine::{Engine, Margins, Refusal};
use exchange::Exchange;
use grow::Sheet;
use left::Left;
use phex::{Event, Progress};
use phex_mesh::Vec2;
use rayon::prelude::*;
use shape::{FreePlace, PlateShape};
use smallest::smallest_sheet;
use squeeze::squeeze;

/// Where a panel lies on a sheet: `p -> rotation p + translation`, in mm; the sheet's corner is the
/// origin.
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

/// Puts all panels on sheets. `name` gives the name of a panel for messages; `progress` counts the
/// panels that lie.
///
/// # Errors
/// If a panel does not fit on an empty sheet, a shape is refused, or `progress` cancels.
pub fn nest(
    plates: &[Plate],
    options: &FabOptions,
    name: impl Fn(usize) -> String,
    progress: &dyn Progress,
) -> Result<Vec<SheetLayout>, FabError> {
    let margins = Margins::new(options.sheet_mm, options.spacing_mm);
    let refused = |k: usize, cause: String| FabError::Nest {
        panel: name(k),
        cause,
    };
    let with = |rotations: &Rotations| {
        shapes(plates, margins, rotations).map_err(|(k, cause)| refused(k, cause))
    };
    let shapes = with(&options.rotations)?;
    let border = Border::new(options.sheet_mm, margins);
    let empty = Engine::new(&border.corners()).map_err(|cause| refused(0, cause))?;
    let large = too_large(&shapes, &border, &empty);
    if let Some(&first) = large.first() {
        let rotations = options.rotations.clone();
        let free = rotations.limited().map(|_| with(&Rotations::Free));
        let free = free.transpose()?;
        return Err(FabError::TooLarge(Box::new(TooLarge {
            size: shapes[first].least_box(&plates[first].outline),
            panels: large.into_iter().map(&name).collect(),
            sheet: options.sheet_mm,
            spacing: options.spacing_mm,
            rotations,
            smallest: smallest_sheet(&shapes, margins),
            smallest_free: free.map(|shapes| smallest_sheet(&shapes, margins)),
        })));
    }
    let bodies: Vec<Body> = shapes.iter().map(PlateShape::body).collect();
    let exchange = Exchange {
        bodies: &bodies,
        border: &border,
        effort: options.nest_effort.into(),
        tolerance: 0.5 * margins.rounding,
    };
    let stock = Stock {
        plates,
        shapes: &shapes,
        border: &border,
        empty: &empty,
    };
    let mut left = Left::new(plates);
    let mut sheets = Vec::new();
    while let Some(first) = left.first() {
        let Some((grown, others)) = stock.grow(first, &left) else {
            let cause = "there is no place for it on an empty sheet".into();
            return Err(refused(first, cause));
        };
        if progress.is_cancelled() {
            return Err(FabError::Cancelled);
        }
        let number = sheets.len() as u64;
        let fuller = exchange.fill(grown.clone(), others, number);
        let mut layout = stock.sound(fuller, grown);
        if layout.len() == left.iter().count() {
            let shorter = squeeze(layout.clone(), &exchange);
            layout = stock.sound(shorter, layout);
        }
        layout.iter().for_each(|p| left.take(p.plate));
        sheets.push(layout);
        progress.report(&Event::Counted {
            stage: "panels on sheets",
            done: plates.len() - left.iter().count(),
            total: plates.len(),
        });
    }
    check::check(plates, &sheets, options)
        .map_err(|cause| refused(cause.plate, cause.to_string()))?;
    Ok(sheets)
}

fn shapes(
    plates: &[Plate],
    margins: Margins,
    rotations: &Rotations,
) -> Result<Vec<PlateShape>, (usize, Refusal)> {
    let shape =
        |(k, plate)| PlateShape::new(k, plate, margins, rotations).map_err(|cause| (k, cause));
    plates.iter().enumerate().map(shape).collect()
}

/// What sheets are filled from.
struct Stock<'a> {
    plates: &'a [Plate],
    shapes: &'a [PlateShape],
    border: &'a Border,
    empty: &'a Engine,
}

impl Stock<'_> {
    /// The best of the sheets that start with a panel, and what is left.
    fn grow(&self, first: usize, left: &Left) -> Option<(SheetLayout, Vec<usize>)> {
        let starts: Vec<FreePlace> = self.shapes[first].starts(self.border, self.empty);
        let filled = starts.par_iter().map(|&start| {
            let mut sheet = Sheet::new(self.empty, self.plates, left.clone());
            sheet.put(&self.shapes[first], start);
            sheet.fill(self.shapes, self.border);
            sheet
        });
        let filled: Vec<Sheet> = filled.collect();
        let best = filled
            .into_iter()
            .reduce(|a, b| if b.score() > a.score() { b } else { a })?;
        let others = best.left.iter().collect();
        Some((best.layout, others))
    }

    /// A layout, if the collision library agrees that it is free of collisions; else another.
    fn sound(&self, layout: SheetLayout, other: SheetLayout) -> SheetLayout {
        let mut engine = self.empty.clone();
        let mut put = |p: &Placement| {
            let item = &self.shapes[p.plate].item;
            let mut scratch = item.shape_cd().as_ref().clone();
            let free = engine.is_free(item, p.rotation, p.translation, &mut scratch);
            engine.put(item, p.rotation, p.translation);
            free
        };
        if layout.iter().all(&mut put) {
            layout
        } else {
            other
        }
    }
}

/// The panels that do not fit on an empty sheet.
fn too_large(shapes: &[PlateShape], border: &Border, empty: &Engine) -> Vec<usize> {
    let fits = |shape: &PlateShape| {
        shape
            .best_place(&shape.rotations, border, &[], empty)
            .is_some()
    };
    let large = shapes.par_iter().filter(|shape| !fits(shape));
    large.map(|shape| shape.plate).collect()
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
