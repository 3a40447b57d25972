//! The independent check of sheets, in double precision, on the panels themselves.

use super::{Placement, SheetLayout};
use crate::options::FabOptions;
use crate::plate::Plate;
use phex_mesh::polygon::{contains, point_segment_distance, segments_touch, sides};
use phex_mesh::{Vec2, bounds};
use std::fmt;

/// What is wrong with a panel on a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct NestingFault {
    /// Number of the panel.
    pub plate: usize,
    /// What it is.
    pub cause: String,
}

impl fmt::Display for NestingFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.cause)
    }
}

/// Checks that every panel is on exactly one sheet, and that both of its faces keep their distance
/// from the border and from both faces of the other panels.
///
/// # Errors
/// The first fault.
pub fn check(
    plates: &[Plate],
    sheets: &[SheetLayout],
    options: &FabOptions,
) -> Result<(), NestingFault> {
    let mut times = vec![0; plates.len()];
    sheets.iter().flatten().for_each(|p| times[p.plate] += 1);
    if let Some(plate) = times.iter().position(|&t| t != 1) {
        let cause = format!("it lies on {} sheets", times[plate]);
        return Err(NestingFault { plate, cause });
    }
    sheets
        .iter()
        .try_for_each(|sheet| check_sheet(plates, sheet, options))
}

fn check_sheet(
    plates: &[Plate],
    sheet: &SheetLayout,
    options: &FabOptions,
) -> Result<(), NestingFault> {
    let spacing = options.spacing_mm;
    let faces = |p: &Placement| {
        [
            p.apply(&plates[p.plate].top),
            p.apply(&plates[p.plate].bottom),
        ]
    };
    let placed: Vec<[Vec<Vec2>; 2]> = sheet.iter().map(faces).collect();
    for (i, (p, a)) in sheet.iter().zip(&placed).enumerate() {
        let [low, high] = bounds(&a.concat());
        let [width, height] = options.sheet_mm;
        if low.x.min(low.y).min(width - high.x).min(height - high.y) < spacing {
            return Err(NestingFault {
                plate: p.plate,
                cause: "it is too close to the sheet's border".into(),
            });
        }
        for (q, b) in sheet[..i].iter().zip(&placed) {
            let near = a.iter().any(|f| b.iter().any(|g| closer(f, g, spacing)));
            if near {
                let cause = format!("it is too close to panel number {}", q.plate);
                return Err(NestingFault {
                    plate: p.plate,
                    cause,
                });
            }
        }
    }
    Ok(())
}

/// Whether two polygons are closer than a distance, or overlap.
fn closer(a: &[Vec2], b: &[Vec2], distance: f64) -> bool {
    let ([al, ah], [bl, bh]) = (bounds(a), bounds(b));
    let apart = (bl - ah).sup(&(al - bh)).max();
    if apart >= distance {
        return false;
    }
    let near = |p: &Vec2, [c, d]: [Vec2; 2]| point_segment_distance(*p, c, d) < distance;
    let touch = sides(a).any(|[p, q]| sides(b).any(|[r, s]| segments_touch(p, q, r, s)));
    touch
        || a.iter().any(|p| sides(b).any(|s| near(p, s)))
        || b.iter().any(|p| sides(a).any(|s| near(p, s)))
        || contains(a, b[0])
        || contains(b, a[0])
}
