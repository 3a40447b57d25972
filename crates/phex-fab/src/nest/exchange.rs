//! A sheet made fuller: panels are added to it, and exchanged for larger ones of those that are
//! still left, as long as all can be pushed apart.

use super::body::Body;
use super::separate::Crowd;
use super::{Border, Placement, SheetLayout};
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::HashSet;

/// Changes that are tried side by side; a fixed number, so that the result does not depend on that
/// of threads.
const BATCH: u64 = 8;
/// Share of a sheet that panels never fill.
const FULL: f64 = 0.95;
/// Panels on a sheet up to which it gets all rounds; a try takes longer in proportion to their
/// number.
const USUAL: usize = 20;
/// Large panels first: they find no place later.
const VALUE: f64 = 1.3;

/// What does not change.
pub struct Exchange<'a> {
    /// All panels.
    pub bodies: &'a [Body],
    /// The sheet.
    pub border: &'a Border,
    /// Batches of changes that are tried for a sheet of few panels.
    pub effort: u64,
    /// Overlap that does not matter, in mm.
    pub tolerance: f64,
}

/// Panels that leave a sheet and panels that come.
struct PlateSwap {
    out: Vec<usize>,
    new: Vec<usize>,
}

impl Exchange<'_> {
    /// The sheet with more on it. `left` are the panels that are on no sheet; `number` is the
    /// sheet's, the seed.
    pub fn fill(&self, mut sheet: SheetLayout, mut left: Vec<usize>, number: u64) -> SheetLayout {
        for round in 0..self.rounds(sheet.len()) {
            if left.is_empty() {
                break;
            }
            let tries: Vec<Option<(f64, SheetLayout)>> = (0..BATCH)
                .into_par_iter()
                .map(|k| {
                    let mut random = ChaCha8Rng::seed_from_u64(number);
                    random.set_stream(round * BATCH + k);
                    self.attempt(&sheet, &left, &mut random)
                })
                .collect();
            let best = tries
                .into_iter()
                .flatten()
                .reduce(|a, b| if b.0 > a.0 { b } else { a });
            if let Some((_, better)) = best {
                left.extend(sheet.iter().map(|p| p.plate));
                left.sort_unstable();
                let lies: HashSet<usize> = better.iter().map(|p| p.plate).collect();
                left.retain(|k| !lies.contains(k));
                sheet = better;
            }
        }
        sheet
    }

    /// Batches of changes that are tried for a sheet with so many panels.
    pub fn rounds(&self, panels: usize) -> u64 {
        (self.effort * USUAL as u64).div_ceil(panels.max(USUAL) as u64)
    }

    fn value(&self, plates: &[usize]) -> f64 {
        plates
            .iter()
            .map(|&k| self.bodies[k].area.powf(VALUE))
            .sum()
    }

    fn area(&self, plates: &[usize]) -> f64 {
        plates.iter().map(|&k| self.bodies[k].area).sum()
    }

    /// A change that succeeded, with what was gained.
    fn attempt(
        &self,
        sheet: &SheetLayout,
        left: &[usize],
        random: &mut ChaCha8Rng,
    ) -> Option<(f64, SheetLayout)> {
        let change = self.change(sheet, left, random)?;
        let mut crowd = Crowd::new(self.border, self.tolerance);
        let staying: Vec<&Placement> = sheet
            .iter()
            .filter(|p| !change.out.contains(&p.plate))
            .collect();
        for p in &staying {
            let body = &self.bodies[p.plate];
            crowd.push(body, body.placed(p));
        }
        for &k in &change.new {
            crowd.add(&self.bodies[k], random);
        }
        if !crowd.separate(random) {
            return None;
        }
        let plates = staying
            .iter()
            .map(|p| p.plate)
            .chain(change.new.iter().copied());
        let layout = plates
            .zip(&crowd.posed)
            .map(|(k, posed)| self.bodies[k].placement(k, posed));
        Some((
            self.value(&change.new) - self.value(&change.out),
            layout.collect(),
        ))
    }

    /// A random change with a gain for which there is area.
    fn change(
        &self,
        sheet: &SheetLayout,
        left: &[usize],
        random: &mut ChaCha8Rng,
    ) -> Option<PlateSwap> {
        let on: Vec<usize> = sheet.iter().map(|p| p.plate).collect();
        let size = (self.border.high - self.border.low).product();
        let room = FULL * size - self.area(&on);
        for _ in 0..30 {
            let leaving = [0, 0, 1, 1, 1, 2][random.random_range(0..6)];
            let coming = [1, 1, 1, 2, 2][random.random_range(0..5)];
            let out: Vec<usize> = on.choose_multiple(random, leaving).copied().collect();
            let new: Vec<usize> = left.choose_multiple(random, coming).copied().collect();
            let more = self.area(&new) - self.area(&out);
            if more < room && self.value(&new) > self.value(&out) {
                return Some(PlateSwap { out, new });
            }
        }
        None
    }
}
