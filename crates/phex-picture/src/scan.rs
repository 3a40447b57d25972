//! Samples inside polygons.

use phex_mesh::Vec2;
use phex_mesh::polygon::sides;
use std::ops::Range;

/// Calls `fill(row, columns)` for the samples whose centre lies inside a polygon by the even-odd
/// rule.
pub fn scan_polygon(
    outline: &[Vec2],
    rows: Range<usize>,
    width: usize,
    mut fill: impl FnMut(usize, Range<usize>),
) {
    let (low, high) = outline.iter().fold((f64::MAX, f64::MIN), |(lo, hi), p| {
        (lo.min(p.y), hi.max(p.y))
    });
    let first = column(low, rows.end).max(rows.start);
    let last = column(high, rows.end);
    let mut crossings = Vec::with_capacity(outline.len());
    for row in first..last {
        row_crossings(outline, row as f64 + 0.5, &mut crossings);
        for span in crossings.chunks_exact(2) {
            let columns = column(span[0], width)..column(span[1], width);
            if !columns.is_empty() {
                fill(row, columns);
            }
        }
    }
}

fn row_crossings(outline: &[Vec2], y: f64, crossings: &mut Vec<f64>) {
    crossings.clear();
    for [a, b] in sides(outline) {
        if (a.y <= y) != (b.y <= y) {
            // From the lower end, so that two neighbouring panels find the same column.
            let (a, b) = if a.y < b.y { (a, b) } else { (b, a) };
            crossings.push(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
        }
    }
    crossings.sort_by(f64::total_cmp);
}

/// First sample whose centre lies at or beyond a coordinate, at most `limit`.
pub fn column(x: f64, limit: usize) -> usize {
    (x - 0.5).ceil().clamp(0.0, limit as f64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(outline: &[(f64, f64)]) -> Vec<(usize, usize)> {
        let outline: Vec<Vec2> = outline.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        let mut cells = Vec::new();
        scan_polygon(&outline, 0..10, 10, |row, columns| {
            cells.extend(columns.map(|x| (x, row)))
        });
        cells
    }

    #[test]
    fn neighbouring_polygons_share_no_sample_and_leave_no_gap() {
        let left = filled(&[(0.0, 0.0), (4.3, 0.0), (6.1, 10.0), (0.0, 10.0)]);
        let right = filled(&[(6.1, 10.0), (4.3, 0.0), (10.0, 0.0), (10.0, 10.0)]);
        assert_eq!(left.len() + right.len(), 100);
        assert!(left.iter().all(|cell| !right.contains(cell)));
    }

    #[test]
    fn notch_of_a_concave_polygon_is_left_free() {
        let cells = filled(&[
            (0.0, 0.0),
            (5.0, 6.0),
            (10.0, 0.0),
            (10.0, 10.0),
            (0.0, 10.0),
        ]);
        assert!(
            !cells.contains(&(5, 2))
                && cells.contains(&(1, 4))
                && cells.contains(&(8, 4))
                && cells.contains(&(5, 8))
        );
    }

    #[test]
    fn polygons_outside_the_picture_are_cut() {
        assert_eq!(
            filled(&[(-5.0, -5.0), (20.0, -5.0), (20.0, 3.0), (-5.0, 3.0)]).len(),
            30
        );
        assert!(filled(&[(20.0, 0.0), (30.0, 0.0), (30.0, 9.0)]).is_empty());
    }
}
