//! The last sheet made shorter, so that a larger piece of it goes back to stock: its panels are
//! moved closer together along the sheet, and pushed apart again.

use super::body::Posed;
use super::exchange::Exchange;
use super::separate::Crowd;
use super::{Placement, SheetLayout};
use phex_mesh::Vec2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Largest and least share of the length that is taken away at once.
const STEPS: [f64; 2] = [0.05, 0.002];
/// Starts for a length.
const STARTS: u64 = 4;

/// Panels on a shorter part of the sheet.
pub fn squeeze(mut sheet: SheetLayout, exchange: &Exchange) -> SheetLayout {
    let mut step = STEPS[0];
    for round in 0..exchange.rounds(sheet.len()) {
        let shorter = (0..STARTS).into_par_iter().find_map_first(|k| {
            let mut random = ChaCha8Rng::seed_from_u64(round);
            random.set_stream(k);
            attempt(&sheet, exchange, step, &mut random)
        });
        match shorter {
            Some(shorter) => sheet = shorter,
            None => step *= 0.5,
        }
        if step < STEPS[1] {
            break;
        }
    }
    sheet
}

/// All panels on a part of the sheet that is shorter by a share.
fn attempt(
    sheet: &SheetLayout,
    exchange: &Exchange,
    step: f64,
    random: &mut ChaCha8Rng,
) -> Option<SheetLayout> {
    let start = exchange.border.low.x;
    let body = |p: &Placement| &exchange.bodies[p.plate];
    let posed: Vec<Posed> = sheet.iter().map(|p| body(p).placed(p)).collect();
    let corners = posed.iter().flat_map(Posed::corners);
    let length = corners.map(|p| p.x - start).fold(0.0, f64::max);
    let mut crowd = Crowd::new(exchange.border, exchange.tolerance);
    crowd.shorten(length * (1.0 - step));
    for (p, posed) in sheet.iter().zip(&posed) {
        let x = start + (posed.centre.x - start) * (1.0 - step);
        let closer = body(p).posed(Vec2::new(x, posed.centre.y), posed.angle);
        crowd.push(body(p), closer);
    }
    if !crowd.separate(random) {
        return None;
    }
    let places = sheet.iter().zip(&crowd.posed);
    Some(
        places
            .map(|(p, posed)| body(p).placement(p.plate, posed))
            .collect(),
    )
}
