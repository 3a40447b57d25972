//! The legend: a swatch, the number and the name of each panel kind that occurs.

use super::palette::{PanelKind, linear};
use super::raster::Sheet;
use super::strokes::{segments, text_width};
use phex_mesh::{PerFace, Vec2};

/// Distance of two lines of the legend over the picture's height.
const LINE_REL: f64 = 0.027;
/// Unit of the alphabet over the distance of two lines.
const UNIT_REL: f64 = 0.07;

/// Draws the legend in the corner where it hides least of the model, at best the lower left.
pub fn draw(sheet: &mut Sheet, kinds: &PerFace<PanelKind>) {
    let lines: Vec<(PanelKind, String)> = rows(kinds)
        .into_iter()
        .map(|(kind, count)| (kind, format!("{count} {}", kind.label())))
        .collect();
    let step = LINE_REL * sheet.height as f64;
    let mut line = free_corner(sheet, &lines, step) + Vec2::new(0.5, 0.5) * step;
    for (kind, label) in &lines {
        hexagon(sheet, line, 0.36 * step, *kind);
        text(
            sheet,
            line + Vec2::new(0.8, 0.21) * step,
            UNIT_REL * step,
            label,
        );
        line.y += step;
    }
}

/// Upper left end of the legend in the corner of the picture where least of it is covered by panels.
fn free_corner(sheet: &Sheet, lines: &[(PanelKind, String)], step: f64) -> Vec2 {
    let widest = lines
        .iter()
        .map(|(_, label)| text_width(label))
        .fold(0.0, f64::max);
    let size = Vec2::new(1.3 + UNIT_REL * widest, lines.len() as f64) * step;
    let far = Vec2::new(sheet.width as f64, sheet.height as f64) - size - Vec2::repeat(step);
    let corners = [(step, far.y), (far.x, far.y), (step, step), (far.x, step)];
    let covered = |corner: &Vec2| {
        let hidden = pixels_around([*corner, corner + size], 0.0);
        hidden
            .filter(|&(x, y)| sheet.panel_at(x as f64, y as f64).is_some())
            .count()
    };
    let corners = corners.map(|(x, y)| Vec2::new(x, y));
    corners.into_iter().min_by_key(covered).unwrap_or_default()
}

fn rows(kinds: &PerFace<PanelKind>) -> Vec<(PanelKind, usize)> {
    let count = |kind| kinds.iter().filter(|&&k| k == kind).count();
    PanelKind::ALL
        .into_iter()
        .map(|kind| (kind, count(kind)))
        .filter(|&(_, n)| n > 0)
        .collect()
}

fn hexagon(sheet: &mut Sheet, centre: Vec2, radius: f64, kind: PanelKind) {
    let ink = linear([0.25, 0.25, 0.28]);
    for (x, y) in pixels_around([centre; 2], radius + 1.0) {
        let offset = Vec2::new(x as f64 + 0.5, y as f64 + 0.5) - centre;
        let outside = hexagon_distance(offset, radius);
        sheet.blend(x, y, kind.colour(), (0.5 - outside).clamp(0.0, 1.0));
        sheet.blend(x, y, ink, (1.0 - outside.abs()).clamp(0.0, 1.0) * 0.8);
    }
}

/// Signed distance to the border of a hexagon that stands on a corner, negative inside.
fn hexagon_distance(p: Vec2, radius: f64) -> f64 {
    let half_sqrt3 = 0.75_f64.sqrt();
    p.x.abs().max(p.x.abs() / 2.0 + p.y.abs() * half_sqrt3) - radius * half_sqrt3
}

/// Writes text with its baseline at `start`, `unit` pixels per unit of the alphabet.
fn text(sheet: &mut Sheet, start: Vec2, unit: f64, text: &str) {
    let ink = linear([0.22, 0.22, 0.25]);
    let radius = (0.32 * unit).max(0.5);
    let place = |p: Vec2| start + Vec2::new(p.x, -p.y) * unit;
    let lines: Vec<[Vec2; 2]> = segments(text)
        .into_iter()
        .map(|ends| ends.map(place))
        .collect();
    let Some((low, high)) = bounds(&lines) else {
        return;
    };
    // Every pixel once, by its nearest stroke: crossings must not be darker.
    for (x, y) in pixels_around([low, high], radius + 1.0) {
        let p = Vec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let distance = lines
            .iter()
            .map(|l| segment_distance(p, l))
            .fold(f64::MAX, f64::min);
        sheet.blend(x, y, ink, (radius + 0.5 - distance).clamp(0.0, 1.0));
    }
}

fn bounds(lines: &[[Vec2; 2]]) -> Option<(Vec2, Vec2)> {
    let points = lines.as_flattened();
    let first = *points.first()?;
    Some(
        points
            .iter()
            .fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p))),
    )
}

fn segment_distance(p: Vec2, [a, b]: &[Vec2; 2]) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
    (p - a - along * t).norm()
}

/// Pixels within `margin` of the box between two points.
fn pixels_around([low, high]: [Vec2; 2], margin: f64) -> impl Iterator<Item = (usize, usize)> {
    let columns = (low.x - margin).max(0.0) as usize..(high.x + margin).ceil().max(0.0) as usize;
    let rows = (low.y - margin).max(0.0) as usize..(high.y + margin).ceil().max(0.0) as usize;
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_kinds_that_occur_are_listed() {
        let kinds = PerFace::from_vec(vec![
            PanelKind::Heptagon,
            PanelKind::ConvexHexagon,
            PanelKind::Heptagon,
        ]);
        assert_eq!(
            rows(&kinds),
            vec![(PanelKind::ConvexHexagon, 1), (PanelKind::Heptagon, 2)]
        );
    }

    #[test]
    fn hexagon_has_corners_above_and_sides_left() {
        assert!(hexagon_distance(Vec2::new(0.0, 0.0), 1.0) < 0.0);
        assert!(hexagon_distance(Vec2::new(0.0, 1.0), 1.0).abs() < 1e-12);
        assert!(hexagon_distance(Vec2::new(0.75_f64.sqrt(), 0.0), 1.0).abs() < 1e-12);
    }
}
