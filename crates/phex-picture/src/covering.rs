//! Which panels hide which.

use super::PictureOptions;
use super::raster::{BAND, NO_PANEL, PanelRaster};
use super::scan::{column, scan_polygon};
use phex_mesh::{FaceId, Vec2};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Which panels cover each sample, at one sample a pixel.
#[derive(Clone, Debug)]
pub struct Covering {
    width: usize,
    /// The nearest panel of each sample.
    top: Vec<u32>,
    /// Pairs of panels of which the second hides a part of the first.
    pairs: Vec<(FaceId, FaceId)>,
}

/// Relative difference of nearness below which two panels count as touching: neighbours do along
/// their edge.
const TOUCHING: f32 = 1e-5;

impl Covering {
    /// Scans all panels.
    pub fn new(raster: &PanelRaster, options: &PictureOptions) -> Self {
        let (width, height) = (options.width, options.height);
        let bands: Vec<CoveredRows> = (0..height.div_ceil(BAND))
            .into_par_iter()
            .map(|b| b * BAND..((b + 1) * BAND).min(height))
            .map(|rows| covered_band(raster, rows, width))
            .collect();
        let mut counts: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for (pair, n) in bands.iter().flat_map(|band| &band.1) {
            *counts.entry(*pair).or_default() += n;
        }
        let more = |&(a, b): &(u32, u32), n: u32| n > *counts.get(&(b, a)).unwrap_or(&0);
        let kept = counts.iter().filter(|(pair, n)| more(pair, **n));
        Self {
            width,
            pairs: kept
                .map(|((a, b), _)| (FaceId::new(*a), FaceId::new(*b)))
                .collect(),
            top: bands.into_iter().flat_map(|band| band.0).collect(),
        }
    }

    /// Pairs of panels of which the second hides a part of the first.
    pub fn pairs(&self) -> &[(FaceId, FaceId)] {
        &self.pairs
    }

    /// The panels that are nearest on some sample, in order.
    pub fn seen(&self) -> impl Iterator<Item = FaceId> + use<> {
        let seen: BTreeSet<u32> = self.top.iter().copied().collect();
        seen.into_iter().filter(|&p| p != NO_PANEL).map(FaceId::new)
    }

    /// Number of samples within a box that panels cover.
    pub fn seen_within(&self, low: Vec2, high: Vec2) -> usize {
        let height = self.top.len() / self.width.max(1);
        let rows = column(low.y, height)..column(high.y, height);
        let columns = column(low.x, self.width)..column(high.x, self.width);
        let row = |y: usize| &self.top[y * self.width..][columns.clone()];
        rows.flat_map(row).filter(|p| **p != NO_PANEL).count()
    }

    /// Number of the nearest panel of each sample.
    #[cfg(test)]
    pub fn top(&self) -> &[u32] {
        &self.top
    }
}

/// The nearest panel of each sample, and how often each pair of panels lies right behind one
/// another.
type CoveredRows = (Vec<u32>, BTreeMap<(u32, u32), u32>);

/// Nearest panels of some rows, and how often each panel lies right behind another.
fn covered_band(raster: &PanelRaster, rows: Range<usize>, width: usize) -> CoveredRows {
    let mut layers: Vec<(u32, f32, u32)> = Vec::new();
    for (number, panel) in raster.panels.iter().enumerate() {
        scan_polygon(&panel.outline, rows.clone(), width, |row, columns| {
            for x in columns {
                let at = ((row - rows.start) * width + x) as u32;
                let nearness = panel.nearness_at(x as f64 + 0.5, row as f64 + 0.5);
                layers.push((at, nearness, number as u32));
            }
        });
    }
    // Of panels at the same distance the first is on top, as in the picture of pixels.
    layers.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(b.2.cmp(&a.2)));
    let mut top = vec![NO_PANEL; rows.len() * width];
    let mut pairs = BTreeMap::new();
    for &(at, _, panel) in &layers {
        top[at as usize] = panel;
    }
    for two in layers.windows(2) {
        let ((at, back, far), (next, front, near)) = (two[0], two[1]);
        if at == next && front - back > TOUCHING * front {
            *pairs.entry((far, near)).or_default() += 1;
        }
    }
    (top, pairs)
}
