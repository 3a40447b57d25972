//! The part of a surface on the inner side of planes through the origin, its new boundary in them.

use super::group::in_walls;
use phex_mesh::{PerFace, TriangleSurface, Vec3};
use std::collections::BTreeMap;

/// Share of its shortest edge within which a vertex is moved into a plane, so that no slivers are
/// cut off.
const SNAP: f64 = 0.2;

/// Area of pieces over that of the largest one up to which they are crumbs, as planes cut them off
/// where they pass along a sharp rim.
const CRUMBS: f64 = 1e-3;

/// Triangles that are cut plane by plane.
struct Pieces {
    positions: Vec<Vec3>,
    /// Planes that hold each vertex, by their bits.
    planes: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

/// The part of a surface on the inner side of all planes, given by their unit normals.
///
/// # Errors
/// A sentence, if it is no manifold or not in one piece, crumbs aside.
pub(crate) fn cut(surface: &TriangleSurface, normals: &[Vec3]) -> Result<TriangleSurface, String> {
    let mut pieces = Pieces {
        positions: surface.positions().as_slice().to_vec(),
        planes: vec![0; surface.positions().len()],
        triangles: surface.triangles().collect(),
    };
    for k in 0..normals.len() {
        pieces.snap(normals, k);
        pieces.clip(normals, k);
    }
    let part = pieces.surface()?;
    let (piece, count) = part.topology().components();
    if count == 1 {
        return Ok(part);
    }
    pieces.triangles = largest(&part, &piece, &pieces.triangles, count)?;
    pieces.surface()
}

/// The triangles of the largest piece of a part, where the others are crumbs.
fn largest(
    part: &TriangleSurface,
    piece: &PerFace<u32>,
    triangles: &[[u32; 3]],
    count: usize,
) -> Result<Vec<[u32; 3]>, String> {
    let mut area = vec![0.0; count];
    for (f, k) in piece.enumerate() {
        area[*k as usize] += part.area_vector(f).norm();
    }
    let most = (0..count).max_by(|a, b| area[*a].total_cmp(&area[*b]));
    let most = most.filter(|k| area.iter().sum::<f64>() <= (1.0 + CRUMBS) * area[*k]);
    let most = most.ok_or("the part between its mirror planes is not in one piece")?;
    let of_it = piece.iter().map(|k| *k as usize == most);
    let kept = triangles.iter().zip(of_it).filter(|(_, kept)| *kept);
    Ok(kept.map(|(t, _)| *t).collect())
}

impl Pieces {
    /// Moves vertices near plane `k` into it.
    fn snap(&mut self, normals: &[Vec3], k: usize) {
        let mut shortest = vec![f64::INFINITY; self.positions.len()];
        for t in &self.triangles {
            for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|e| e.map(|v| v as usize))
            {
                let length = (self.positions[a] - self.positions[b]).norm();
                shortest[a] = shortest[a].min(length);
                shortest[b] = shortest[b].min(length);
            }
        }
        for (v, shortest) in shortest.into_iter().enumerate() {
            let both = self.planes[v] | (1 << k);
            let to = in_walls(normals, both, self.positions[v]);
            if (to - self.positions[v]).norm() <= SNAP * shortest {
                (self.positions[v], self.planes[v]) = (to, both);
            }
        }
    }

    /// Cuts off what lies beyond plane `k`.
    fn clip(&mut self, normals: &[Vec3], k: usize) {
        let height = |p: &Self, v: u32| match p.planes[v as usize] & (1 << k) {
            0 => normals[k].dot(&p.positions[v as usize]),
            _ => 0.0,
        };
        let mut on_edge: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut kept = Vec::new();
        for t in std::mem::take(&mut self.triangles) {
            let h = t.map(|v| height(self, v));
            if h.iter().all(|h| *h <= 0.0) {
                continue;
            }
            let mut ring: Vec<u32> = Vec::new();
            for i in 0..3 {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                let (from, to) = (h[i], h[(i + 1) % 3]);
                if from >= 0.0 {
                    ring.push(a);
                }
                if from * to < 0.0 {
                    let key = [a.min(b), a.max(b)];
                    let new = on_edge.get(&key).copied().unwrap_or_else(|| {
                        let [p, q] = key.map(|v| self.positions[v as usize]);
                        let share =
                            height(self, key[0]) / (height(self, key[0]) - height(self, key[1]));
                        let [x, y] = key.map(|v| self.planes[v as usize]);
                        let planes = (x & y) | (1 << k);
                        let place = in_walls(normals, planes, p + (q - p) * share);
                        self.positions.push(place);
                        self.planes.push(planes);
                        self.positions.len() as u32 - 1
                    });
                    on_edge.insert(key, new);
                    ring.push(new);
                }
            }
            match ring[..] {
                [a, b, c] => kept.push([a, b, c]),
                [a, b, c, d] => {
                    let far = |x: u32, y: u32| {
                        (self.positions[x as usize] - self.positions[y as usize]).norm()
                    };
                    match far(a, c) <= far(b, d) {
                        true => kept.extend([[a, b, c], [a, c, d]]),
                        false => kept.extend([[a, b, d], [b, c, d]]),
                    }
                }
                _ => {}
            }
        }
        self.triangles = kept;
    }

    fn surface(&self) -> Result<TriangleSurface, String> {
        let mut number = BTreeMap::new();
        let mut positions = Vec::new();
        let triangles: Vec<[u32; 3]> = (self.triangles.iter())
            .map(|t| {
                t.map(|v| {
                    *number.entry(v).or_insert_with(|| {
                        positions.push(self.positions[v as usize]);
                        positions.len() as u32 - 1
                    })
                })
            })
            .collect();
        TriangleSurface::new(positions, &triangles).map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat U, one of whose arms is a triangle that reaches a height beyond `y = 0`, the other
    /// one a strip of width 1 up to 60.
    fn two_arms(height: f64) -> TriangleSurface {
        let places = [
            [0.0, -1.0],
            [3.0, -1.0],
            [3.0, -0.5],
            [2.0, -0.5],
            [1.0, -0.5],
            [0.0, -0.5],
            [1.0, 60.0],
            [0.0, 60.0],
            [2.5, height],
        ];
        let base = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let arms = [[5, 4, 6], [5, 6, 7], [3, 2, 8]];
        let places = places.iter().map(|[x, y]| Vec3::new(*x, *y, 0.0)).collect();
        TriangleSurface::new(places, &[&base[..], &arms[..]].concat()).unwrap()
    }

    #[test]
    fn crumbs_are_left_out_and_parts_in_two_pieces_refused() {
        let part = cut(&two_arms(0.2), &[Vec3::y()]).unwrap();
        assert_eq!(part.topology().components().1, 1);
        assert!((part.area() - 60.0).abs() < 1e-9, "{}", part.area());
        let refused = cut(&two_arms(5.0), &[Vec3::y()]);
        let reason = refused.err().unwrap();
        assert!(reason.contains("not in one piece"), "{reason}");
    }
}
