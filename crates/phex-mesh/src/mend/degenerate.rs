//! Faces without area: poles where a row of vertices lies in one point, triangles with a corner on
//! their opposite side.

use super::{FaceSide, Mended, sides};
use crate::disjoint_sets::DisjointSets;
use crate::{PolygonSoup, Vec3, polygon};

/// Takes faces without area out, so that what is beside them closes: corners of a face that lie in
/// one point become one vertex; the corner of a triangle that lies on its opposite side becomes a
/// corner of the face beyond. `None` where there is no such face.
///
/// `rounding` is the largest height that counts as none. Vertices exist and coordinates are finite.
pub(crate) fn without_degenerate_faces(soup: &PolygonSoup, rounding: f64) -> Option<Mended> {
    let is_flat = |face: &Vec<u32>| has_no_area(&soup.positions, face, rounding);
    let repeats = |face: &Vec<u32>| polygon::sides(face).any(|[v, w]| v == w);
    if !soup.faces.iter().any(|f| is_flat(f) || repeats(f)) {
        return None;
    }
    let mut mended = Mended::unchanged(soup);
    let mut sets = DisjointSets::new(soup.positions.len());
    for face in &soup.faces {
        for [v, next] in polygon::sides(face) {
            if (soup.positions[v as usize] - soup.positions[next as usize]).norm() <= rounding {
                sets.join(v, next);
            }
        }
    }
    mended.join_vertices(&mut sets);
    // A triangle that lies on another one is taken out after it.
    while takes_flat_triangles(&mut mended, rounding) {}
    Some(mended)
}

fn has_no_area(positions: &[Vec3], face: &[u32], rounding: f64) -> bool {
    match *face {
        [a, b, c] => least_height([a, b, c].map(|v| positions[v as usize])) <= rounding,
        _ => false,
    }
}

/// Takes out the triangles without area whose neighbour over the longest side has some. Whether
/// there were any.
fn takes_flat_triangles(mended: &mut Mended, rounding: f64) -> bool {
    let positions = &mended.soup.positions;
    let is_flat: Vec<bool> = (mended.soup.faces.iter())
        .map(|face| has_no_area(positions, face, rounding))
        .collect();
    if !is_flat.contains(&true) {
        return false;
    }
    let sides = sides(&mended.soup.faces);
    let users = |a: u32, b: u32| -> &[FaceSide] {
        let ends = [a.min(b), a.max(b)];
        let first = sides.partition_point(|s| s.ends < ends);
        let count = sides[first..].partition_point(|s| s.ends == ends);
        &sides[first..first + count]
    };
    // Sides get at most one corner in a pass.
    let mut insertions: Vec<(u32, u32, u32)> = Vec::new();
    let mut keep = vec![true; is_flat.len()];
    for f in (0..is_flat.len()).filter(|&f| is_flat[f]) {
        let [middle, a, b] = middle_first(positions, &mended.soup.faces[f]);
        let beyond: Vec<&FaceSide> = (users(a, b).iter())
            .filter(|s| s.face as usize != f)
            .collect();
        if beyond.iter().any(|s| is_flat[s.face as usize]) {
            continue;
        }
        keep[f] = false;
        let holds = |v: u32| users(v, middle).len() > 1;
        if let ([side], true) = (&beyond[..], holds(a) || holds(b)) {
            insertions.push((side.face, side.corner, middle));
        }
    }
    insertions.sort_unstable();
    for &(face, corner, v) in insertions.iter().rev() {
        mended.soup.faces[face as usize].insert(corner as usize + 1, v);
    }
    mended.keep_faces(&keep);
    keep.contains(&false)
}

/// The corner of a triangle that is opposite to the longest side, and the others.
fn middle_first(positions: &[Vec3], face: &[u32]) -> [u32; 3] {
    let at = |i: usize| positions[face[i % 3] as usize];
    let opposite = |i: usize| (at(i + 1) - at(i + 2)).norm();
    let first = (0..3).fold(0, |k, i| if opposite(i) > opposite(k) { i } else { k });
    [0, 1, 2].map(|i| face[(first + i) % 3])
}

/// Least height of a triangle.
pub(crate) fn least_height([a, b, c]: [Vec3; 3]) -> f64 {
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    if longest > 0.0 {
        (b - a).cross(&(c - a)).norm() / longest
    } else {
        0.0
    }
}
