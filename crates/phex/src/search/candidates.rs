//! What is tried at a defect, mild changes first.

use super::draft::{DirectedEdge, Draft};
use super::patch::Patch;

/// Panels of a defect that are merged or split at the most.
const WORST: usize = 2;
/// Splits of a panel that are tried, and merges of one with its neighbours.
const SPLITS: usize = 2;
const MERGES: usize = 4;

/// Drafts that are tried at a place, those with the most regular panels.
const MOST: usize = 8;
/// Rings of panels that are split where mild changes have failed.
const SPLIT_RINGS: usize = 3;

/// The drafts that are tried, the most regular first, and mild changes before others.
/// `needs_more` tells that panels are too large, `wide` that mild changes have failed: then more
/// panels are all that is left to try.
pub(super) fn candidates(patch: &Patch, needs_more: bool, wide: bool) -> Vec<Draft> {
    let draft = &patch.draft;
    let worst = &patch.core[..patch.core.len().min(WORST)];
    let halves = || {
        worst
            .iter()
            .flat_map(|f| draft.halves(*f).into_iter().take(SPLITS))
    };
    let merges = || worst.iter().flat_map(|f| merges(draft, *f));
    let same = || std::iter::once(draft.clone());
    let all: Vec<Draft> = match (needs_more, wide) {
        (true, false) => halves().chain(same()).chain(merges()).collect(),
        (false, false) => (same()
            .chain(merges())
            .chain(turns(draft, worst))
            .chain(halves()))
        .collect(),
        (true, true) => (finer(patch).into_iter())
            .chain(turns(draft, worst))
            .collect(),
        (false, true) => Vec::new(),
    };
    let mut calmed: Vec<Draft> = Vec::new();
    for draft in all {
        let draft = draft.calmed();
        if calmed.iter().all(|other| other.faces != draft.faces) {
            calmed.push(draft);
        }
    }
    calmed.sort_by_key(Draft::irregularities);
    calmed.truncate(MOST);
    calmed
}

/// A panel merged with one of its neighbours, those with the fewest corners first.
fn merges(draft: &Draft, f: usize) -> Vec<Draft> {
    let mut sides: Vec<(usize, DirectedEdge)> = (draft.neighbours(f).into_iter())
        .map(|(side, g)| (draft.faces[g].len(), side))
        .collect();
    sides.sort_unstable();
    let merged = sides.iter().filter_map(|(_, side)| draft.merged(*side));
    merged.take(MERGES).collect()
}

/// Each side of panels turned.
fn turns(draft: &Draft, faces: &[usize]) -> Vec<Draft> {
    let sides = faces.iter().flat_map(|f| draft.neighbours(*f));
    sides.filter_map(|(side, _)| draft.turned(side)).collect()
}

/// The panels within [`SPLIT_RINGS`] of the defect split, one after the other.
fn finer(patch: &Patch) -> Option<Draft> {
    let mut faces = patch.core.clone();
    for _ in 1..SPLIT_RINGS {
        let around: Vec<usize> = (faces.iter())
            .flat_map(|f| patch.draft.neighbours(*f))
            .map(|(_, g)| g)
            .collect();
        faces.extend(around);
        faces.sort_unstable();
        faces.dedup();
    }
    let mut draft = patch.draft.clone();
    for f in &faces {
        if let Some(next) = draft.halves(*f).into_iter().next() {
            draft = next.calmed();
        }
    }
    (draft.faces.len() > patch.draft.faces.len()).then_some(draft)
}
