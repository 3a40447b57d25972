//! Faces as lists of vertex numbers: numbering them anew, turning their edges.

use crate::id_map::IdMap;
use std::hash::Hash;

/// The keys of lists in the order in which they are first met, and the lists with their places in
/// that order instead.
///
/// ```
/// let (corners, faces) = phex_mesh::numbered([[7, 2, 9], [9, 2, 5]]);
/// assert_eq!(corners, [7, 2, 9, 5]);
/// assert_eq!(faces, [[0, 1, 2], [2, 1, 3]]);
/// ```
pub fn numbered<K: Copy + Eq + Hash, L: IntoIterator<Item = K>>(
    lists: impl IntoIterator<Item = L>,
) -> (Vec<K>, Vec<Vec<u32>>) {
    let (mut number, mut keys) = (IdMap::default(), Vec::new());
    let mut place = |key: K| {
        *number.entry(key).or_insert_with(|| {
            keys.push(key);
            keys.len() as u32 - 1
        })
    };
    let lists = lists.into_iter();
    let places = lists.map(|l| l.into_iter().map(&mut place).collect());
    let places = places.collect();
    (keys, places)
}

/// Turns an edge between vertices of degree 3 (a T1 step, as in foams), which runs from `u` to `v`
/// in the face on its left: afterwards `u` belongs to the left face and `v` to the right one, and
/// both to the faces at the ends, those of `u` and of `v`.
pub fn turn_edge(
    faces: &mut [Vec<u32>],
    [u, v]: [u32; 2],
    [left, right]: [usize; 2],
    at_ends: [Option<usize>; 2],
) {
    faces[left].retain(|w| *w != v);
    faces[right].retain(|w| *w != u);
    for (end, old, new) in [(at_ends[0], u, v), (at_ends[1], v, u)] {
        if let Some(f) = end {
            insert_before(&mut faces[f], old, new);
        }
    }
}

/// Puts a vertex before another one of a face; does nothing where that is no corner.
pub fn insert_before(face: &mut Vec<u32>, old: u32, new: u32) {
    if let Some(i) = face.iter().position(|w| *w == old) {
        face.insert(i, new);
    }
}
