//! The panels that are on no sheet yet, from one end of the mesh to the other.

use crate::plate::Plate;

/// The panels that are on no sheet yet.
#[derive(Clone)]
pub struct Left {
    is_left: Vec<bool>,
    /// All panels, from one end of the mesh to the other.
    order: Vec<usize>,
}

impl Left {
    /// All panels.
    pub fn new(plates: &[Plate]) -> Self {
        let order = breadth_first(plates, 0);
        let end = order.last().copied().unwrap_or(0);
        Self {
            is_left: vec![true; plates.len()],
            order: breadth_first(plates, end),
        }
    }

    /// Those that are left, in order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.order.iter().copied().filter(|&k| self.is_left[k])
    }

    /// The next one.
    pub fn first(&self) -> Option<usize> {
        self.iter().next()
    }

    /// Whether a panel is left.
    pub fn holds(&self, plate: usize) -> bool {
        self.is_left[plate]
    }

    /// A panel goes on a sheet.
    pub fn take(&mut self, plate: usize) {
        self.is_left[plate] = false;
    }
}

/// All panels by their distance from one of them in steps over edges; further parts of the mesh
/// follow.
fn breadth_first(plates: &[Plate], start: usize) -> Vec<usize> {
    let mut seen = vec![false; plates.len()];
    let mut order = Vec::with_capacity(plates.len());
    for root in std::iter::once(start).chain(0..plates.len()) {
        let mut at = order.len();
        if !std::mem::replace(&mut seen[root], true) {
            order.push(root);
        }
        while at < order.len() {
            for next in plates[order[at]].sides.iter().filter_map(|s| s.neighbour) {
                if !std::mem::replace(&mut seen[next.index()], true) {
                    order.push(next.index());
                }
            }
            at += 1;
        }
    }
    order
}
