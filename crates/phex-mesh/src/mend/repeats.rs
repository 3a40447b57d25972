//! Faces that are there twice, as after pasting an object where it was, or in sheets with a face on
//! either side.

use super::Mended;
use crate::{PolygonSoup, Vec3};

/// Takes out faces whose corners lie in the same places as those of an earlier one, whichever way
/// round they run; `None` where there is no such face. Vertices exist.
pub(crate) fn without_repeated_faces(soup: &PolygonSoup) -> Option<Mended> {
    let place = |v: &u32| soup.positions[*v as usize];
    let hash = |face: &Vec<u32>| {
        face.iter()
            .fold(0_u64, |sum, v| sum.wrapping_add(mixed(place(v))))
    };
    let mut order: Vec<(u64, u32)> = (soup.faces.iter().map(hash)).zip(0..).collect();
    order.sort_unstable();
    let corners = |f: u32| {
        let mut corners: Vec<[u64; 3]> = (soup.faces[f as usize].iter())
            .map(|v| bits(place(v)))
            .collect();
        corners.sort_unstable();
        corners
    };
    let mut keep = vec![true; soup.faces.len()];
    for same_hash in order
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() > 1)
    {
        let mut faces: Vec<_> = same_hash.iter().map(|(_, f)| (corners(*f), *f)).collect();
        faces.sort_unstable();
        for pair in faces.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            keep[pair[1].1 as usize] = false;
        }
    }
    if !keep.contains(&false) {
        return None;
    }
    let mut mended = Mended::unchanged(soup);
    mended.keep_faces(&keep);
    mended.repeated_faces = std::mem::take(&mut mended.dropped_faces);
    Some(mended)
}

/// The bits of a place; zero has one sign.
fn bits(p: Vec3) -> [u64; 3] {
    [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())
}

/// A number that differs for almost any two places.
fn mixed(p: Vec3) -> u64 {
    bits(p).into_iter().fold(0x9e37_79b9_7f4a_7c15, |hash, x| {
        let turned = (hash ^ x).wrapping_mul(0xff51_afd7_ed55_8ccd);
        turned ^ (turned >> 32)
    })
}
