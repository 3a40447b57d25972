//! The smallest sheet on which every panel has a place by itself.

use super::engine::Margins;
use super::shape::PlateShape;
use phex_mesh::bounds;
use std::collections::BinaryHeap;

/// Relative slack for what single precision loses on a larger sheet than the one that was asked
/// for.
const SLACK: f64 = 1e-5;

/// Length and width, in whole mm, of the sheet of least area on which every panel fits in one of
/// its rotations.
pub fn smallest_sheet(shapes: &[PlateShape], margins: Margins) -> [f64; 2] {
    let mut boxes: Vec<([u64; 2], usize)> = Vec::new();
    for (k, shape) in shapes.iter().enumerate() {
        boxes.extend(shape_boxes(shape, margins).map(|size| (size, k)));
    }
    boxes.sort_unstable();
    smallest(&boxes, shapes.len()).map(|side| side as f64)
}

/// What a panel covers in each of its rotations, with the spacing round it.
fn shape_boxes(shape: &PlateShape, margins: Margins) -> impl Iterator<Item = [u64; 2]> + '_ {
    shape.rotations.iter().map(move |&rotation| {
        let [low, high] = bounds(&shape.turned(rotation).concat());
        let whole = |side: f64| ((1.0 + SLACK) * (side + 2.0 * margins.half_spacing)).ceil() as u64;
        [whole(high.x - low.x), whole(high.y - low.y)]
    })
}

/// The sheet of least area that holds one of the boxes of each of `n` panels; boxes by growing
/// length. A sheet is no wider than long.
fn smallest(boxes: &[([u64; 2], usize)], n: usize) -> [u64; 2] {
    // The least width of each panel among the boxes up to a length. The widest of these is on top
    // of the heap, above which stand widths that are out of date.
    let mut widths = vec![u64::MAX; n];
    let mut heap: BinaryHeap<(u64, usize)> = (0..n).map(|k| (u64::MAX, k)).collect();
    let mut best = [u64::MAX; 2];
    let area = |[a, b]: [u64; 2]| u128::from(a) * u128::from(b);
    for &([length, width], k) in boxes {
        if width < widths[k] {
            widths[k] = width;
            heap.push((width, k));
        }
        while heap.peek().is_some_and(|&(width, k)| widths[k] != width) {
            heap.pop();
        }
        let widest = heap.peek().map_or(0, |top| top.0);
        let sheet = [length.max(widest), widest];
        if area(sheet) < area(best) {
            best = sheet;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_panel_takes_the_rotation_that_makes_the_common_sheet_small() {
        let sheet = |boxes: &[([u64; 2], usize)], n| {
            let mut sorted = boxes.to_vec();
            sorted.sort_unstable();
            smallest(&sorted, n)
        };
        assert_eq!(sheet(&[([5, 3], 0), ([3, 5], 0)], 1), [5, 3]);
        // The second fits on its side beside the first one's width.
        let both = [([9, 4], 0), ([4, 9], 0), ([5, 6], 1), ([8, 4], 1)];
        assert_eq!(sheet(&both, 2), [9, 4]);
        // Only upright: the sheet is a square, since its longer side is its length.
        assert_eq!(sheet(&[([3, 7], 0)], 1), [7, 7]);
        assert_eq!(sheet(&[([3, 7], 0), ([8, 2], 1)], 2), [8, 7]);
    }
}
