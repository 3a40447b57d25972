//! What is tried at a defect, mild changes first.

use super::draft::{DirectedEdge, Draft};
use super::patch::Patch;

/// Panels of a defect that are merged or split at the most.
const WORST: usize = 2;
/// Splits of a panel that are tried, and merges of one with its neighbours.
const SPLITS: usize = 2;
const MERGES: usize = 4;

/// Changes that are tried at a place, those with the most regular panels, besides chamfers.
const MOST: usize = 8;

/// The drafts that are tried, the most regular ones first.
/// `needs_more` tells that panels are too large, `wide` that mild changes have failed.
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
        (true, false) => halves()
            .chain(finer(patch, 1))
            .chain(same())
            .chain(merges())
            .collect(),
        (false, false) => (same()
            .chain(merges())
            .chain(turns(draft, worst))
            .chain(halves()))
        .collect(),
        (true, true) => (finer(patch, 1).into_iter())
            .chain(finer(patch, 2))
            .chain(finer(patch, 3))
            .chain(turns(draft, worst))
            .collect(),
        (false, true) => (finer(patch, 1).into_iter())
            .chain(anew(patch))
            .chain(finer(patch, 2))
            .collect(),
    };
    let mut calmed = distinct(all.into_iter().map(Draft::calmed));
    calmed.sort_by_key(Draft::irregularities);
    calmed.truncate(MOST);
    calmed
}

/// Drafts without those whose panels have the same corners as those of an earlier one.
pub(super) fn distinct(drafts: impl Iterator<Item = Draft>) -> Vec<Draft> {
    let mut kept: Vec<Draft> = Vec::new();
    for draft in drafts {
        if kept.iter().all(|other| other.faces != draft.faces) {
            kept.push(draft);
        }
    }
    kept
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

/// The panels within some rings of the defect split, one after the other.
fn finer(patch: &Patch, rings: usize) -> Option<Draft> {
    let mut faces = patch.core.clone();
    for _ in 1..rings {
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

/// A panel of the defect merged with a neighbour, and a neighbour of these split.
fn anew(patch: &Patch) -> Vec<Draft> {
    let f = patch.core[0];
    let merged = merges(&patch.draft, f).into_iter().map(Draft::calmed);
    let split = |draft: Draft| {
        let beside = draft.neighbours(f).into_iter();
        let mut large: Vec<usize> = beside.map(|(_, g)| g).collect();
        large.sort_by_key(|g| std::cmp::Reverse(draft.faces[*g].len()));
        let halves = large
            .iter()
            .take(2)
            .filter_map(|g| draft.halves(*g).into_iter().next());
        halves.collect::<Vec<Draft>>()
    };
    merged.flat_map(split).collect()
}
