//! Faces cut into triangles, for the formats that know nothing else.

use super::error::WriteCause;
use crate::ear_clip::ear_clip_corners;
use crate::{PolygonSoup, Vec3};

/// Triangles of one face, as vertex numbers wound like it.
pub(super) fn of_face(soup: &PolygonSoup, face: usize) -> Result<Vec<[u32; 3]>, WriteCause> {
    let corners = &soup.faces[face];
    let points: Vec<Vec3> = corners
        .iter()
        .map(|&v| soup.positions[v as usize])
        .collect();
    let ears = ear_clip_corners(&points).map_err(|_| WriteCause::NotSimple { face })?;
    Ok(ears
        .into_iter()
        .map(|ear| ear.map(|i| corners[i as usize]))
        .collect())
}

/// A position in single precision.
pub(super) fn single(
    soup: &PolygonSoup,
    vertex: u32,
    origin: Vec3,
) -> Result<[f32; 3], WriteCause> {
    let p = soup.positions[vertex as usize] - origin;
    let single = [p.x as f32, p.y as f32, p.z as f32];
    if single.iter().all(|x| x.is_finite()) {
        Ok(single)
    } else {
        let vertex = vertex as usize;
        Err(WriteCause::TooLarge { vertex })
    }
}
