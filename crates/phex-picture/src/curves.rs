//! Curves over the panels.

use super::camera::{Camera, Seen};
use super::raster::LinearImage;
use crate::srgb::linear;
use phex_mesh::{Vec2, Vec3};

/// Width of a curve over the picture's height.
const WIDTH_REL: f64 = 0.0033;
/// How far behind a panel a curve may lie and still be seen, in radii of the model: curves run on
/// the surface, panels beside it.
const BEHIND: f64 = 0.02;

/// Draws polylines in one colour, where no panel hides them.
pub(super) fn draw(sheet: &mut LinearImage, camera: &Camera, curves: &[Vec<Vec3>]) {
    let colour = linear([0.80, 0.13, 0.16]);
    let radius = (0.5 * WIDTH_REL * sheet.height as f64).max(0.6);
    for curve in curves {
        let seen: Vec<Seen> = curve
            .iter()
            .map(|p| camera.see(camera.normalised(*p)))
            .collect();
        // Neighbouring segments share pixels: each pixel of a curve is painted once, with its
        // largest share.
        let mut shares = std::collections::BTreeMap::new();
        for ends in seen.windows(2) {
            cover(sheet, [ends[0], ends[1]], radius, &mut shares);
        }
        for ((y, x), share) in shares {
            sheet.blend(x, y, colour, share);
        }
    }
}

/// Collects the share of each visible pixel that a segment covers.
fn cover(
    sheet: &LinearImage,
    [a, b]: [Seen; 2],
    radius: f64,
    shares: &mut std::collections::BTreeMap<(usize, usize), f64>,
) {
    let range = |p: f64, q: f64, limit: usize| {
        let low = (p.min(q) - radius - 1.0).clamp(0.0, limit as f64) as usize;
        low..(p.max(q) + radius + 1.0).clamp(0.0, limit as f64) as usize
    };
    let along = Vec2::new(b.x - a.x, b.y - a.y);
    for y in range(a.y, b.y, sheet.height) {
        for x in range(a.x, b.x, sheet.width) {
            let (u, v) = (x as f64 + 0.5, y as f64 + 0.5);
            let offset = Vec2::new(u - a.x, v - a.y);
            let t = (offset.dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
            let share = (radius + 0.5 - (offset - along * t).norm()).clamp(0.0, 1.0);
            let nearness = a.nearness + (b.nearness - a.nearness) * t;
            if share > 0.0 && is_visible(sheet, u, v, nearness) {
                let old = shares.entry((y, x)).or_insert(0.0);
                *old = old.max(share);
            }
        }
    }
}

fn is_visible(sheet: &LinearImage, x: f64, y: f64, nearness: f64) -> bool {
    let panel = sheet.panel_at(x, y);
    panel.is_none_or(|(_, panel)| 1.0 / nearness <= 1.0 / panel + BEHIND)
}
