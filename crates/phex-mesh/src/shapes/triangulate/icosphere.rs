//! Domains from pole to pole: a subdivided icosahedron on the sphere of directions, so that no
//! vertex is special at the poles.

use super::jitter::{Jitter, safe_edges};
use super::{ParameterMesh, TriangulationOptions};
use crate::Vec3;
use crate::shapes::ellipsoid::tangent_frame;
use crate::shapes::parametric::ParametricSurface;
use std::collections::HashMap;

/// Corners of an icosahedron are the cyclic permutations of `(0, +-1, +-golden ratio)`.
const GOLDEN: f64 = 1.618_033_988_749_895;

const FACES: [[usize; 3]; 20] = [
    [0, 1, 4],
    [0, 6, 1],
    [0, 4, 8],
    [0, 9, 6],
    [0, 8, 9],
    [1, 10, 4],
    [1, 6, 11],
    [1, 11, 10],
    [2, 5, 3],
    [2, 3, 7],
    [2, 8, 5],
    [2, 7, 9],
    [2, 9, 8],
    [3, 5, 10],
    [3, 11, 7],
    [3, 10, 11],
    [4, 5, 8],
    [4, 10, 5],
    [6, 9, 7],
    [6, 7, 11],
];

pub(super) fn mesh<S: ParametricSurface + ?Sized>(
    surface: &S,
    options: &TriangulationOptions,
) -> ParameterMesh {
    let frequency = (options.triangles as f64 / 20.0).sqrt().round().max(1.0) as u32;
    let (mut directions, triangles) = subdivided_icosahedron(frequency);
    move_directions(&mut directions, &triangles, Jitter::new(options));
    let parameters = directions
        .iter()
        .map(|&d| surface.parameters_toward(d))
        .collect();
    ParameterMesh {
        parameters,
        triangles,
    }
}

fn corners() -> [Vec3; 12] {
    let mut corners = [Vec3::zeros(); 12];
    for (i, corner) in corners.iter_mut().enumerate() {
        let sign = |bit: usize| if i & bit == 0 { 1.0 } else { -1.0 };
        let axis = i / 4;
        corner[(axis + 1) % 3] = sign(1);
        corner[(axis + 2) % 3] = sign(2) * GOLDEN;
    }
    corners
}

/// Unit directions and triangles with `frequency` edges along each edge of the icosahedron.
fn subdivided_icosahedron(frequency: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut builder = Builder {
        corners: corners(),
        numbers: HashMap::new(),
        directions: Vec::new(),
    };
    let mut triangles = Vec::with_capacity(20 * (frequency * frequency) as usize);
    for face in FACES {
        let mut vertex = |i: u32, j: u32| builder.vertex(face, [frequency - i - j, i, j]);
        for j in 0..frequency {
            for i in 0..frequency - j {
                triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 1 < frequency {
                    triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
    }
    (builder.directions, triangles)
}

struct Builder {
    corners: [Vec3; 12],
    /// Vertex numbers by the weights of the (up to three) corners that the vertex lies between.
    numbers: HashMap<[(usize, u32); 3], u32>,
    directions: Vec<Vec3>,
}

impl Builder {
    fn vertex(&mut self, face: [usize; 3], weights: [u32; 3]) -> u32 {
        let mut key = [0, 1, 2].map(|k| {
            if weights[k] == 0 {
                (0, 0)
            } else {
                (face[k], weights[k])
            }
        });
        key.sort_unstable();
        *self.numbers.entry(key).or_insert_with(|| {
            let sum: Vec3 = key
                .iter()
                .map(|&(c, w)| self.corners[c] * f64::from(w))
                .sum();
            self.directions.push(sum.normalize());
            self.directions.len() as u32 - 1
        })
    }
}

fn move_directions(directions: &mut [Vec3], triangles: &[[u32; 3]], mut jitter: Jitter) {
    if jitter.is_none() {
        return;
    }
    let edges = safe_edges(directions, triangles, |a, b| (a - b).norm());
    for (direction, edge) in directions.iter_mut().zip(edges) {
        let [s, t] = tangent_frame(*direction);
        let step = jitter.step(edge);
        *direction = (*direction + s * step.x + t * step.y).normalize();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn icosahedron_is_regular_and_outward() {
        let corners = corners();
        for [a, b, c] in FACES.map(|f| f.map(|i| corners[i])) {
            for edge in [a - b, b - c, c - a] {
                assert!((edge.norm() - 2.0).abs() < 1e-14);
            }
            assert!((b - a).cross(&(c - a)).dot(&(a + b + c)) > 0.0);
        }
    }

    #[test]
    fn subdivision_shares_vertices() {
        for frequency in [1, 2, 5] {
            let (directions, triangles) = subdivided_icosahedron(frequency);
            assert_eq!(triangles.len(), 20 * (frequency * frequency) as usize);
            assert_eq!(directions.len(), 10 * (frequency * frequency) as usize + 2);
        }
    }
}
