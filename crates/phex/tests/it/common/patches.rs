//! Patches over squares of parameters, with `K` of one sign and normals that come once.

use phex_mesh::{TriangleSurface, Vec3};

type Point = fn(f64, f64) -> [f64; 3];

/// A patch over `|u|, |v| <= size`, of `2 cells^2` triangles.
pub fn patch(cells: u32, size: f64, point: impl Fn(f64, f64) -> [f64; 3]) -> TriangleSurface {
    let at = |k: u32| (2.0 * f64::from(k) / f64::from(cells) - 1.0) * size;
    let nodes = (0..=cells).flat_map(|i| (0..=cells).map(move |j| (i, j)));
    let positions = nodes
        .map(|(i, j)| point(at(i), at(j)).into())
        .collect::<Vec<Vec3>>();
    let row = cells + 1;
    let corners = (0..cells).flat_map(|i| (0..cells).map(move |j| i * row + j));
    let halves = |a| [[a, a + row, a + row + 1], [a, a + row + 1, a + 1]];
    let triangles: Vec<[u32; 3]> = corners.flat_map(halves).collect();
    TriangleSurface::new(positions, &triangles).unwrap()
}

/// Name, half the side of the square of parameters, whether `K < 0`, and the points.
pub const PATCHES: [(&str, f64, bool, Point); 9] = [
    ("elliptic paraboloid", 0.8, false, |u, v| {
        [u, v, -0.5 * (u * u / 1.2 + v * v / 1.8)]
    }),
    ("ellipsoid cap 1.5 : 1.1 : 0.9", 0.55, false, |u, v| {
        [1.5 * u, 1.1 * v, 0.9 * (1.0 - u * u - v * v).sqrt()]
    }),
    ("hyperbolic paraboloid", 0.8, true, |u, v| {
        [u, v, 0.5 * (u * u - v * v)]
    }),
    ("catenoid", 0.9, true, |u, v| {
        [u.cosh() * v.cos(), u.cosh() * v.sin(), u]
    }),
    ("Enneper", 0.6, true, |u, v| {
        let (x, y) = (
            u - u.powi(3) / 3.0 + u * v * v,
            v - v.powi(3) / 3.0 + v * u * u,
        );
        [x, -y, u * u - v * v]
    }),
    ("helicoid", 0.8, true, |u, v| {
        [u.sinh() * v.cos(), u.sinh() * v.sin(), v]
    }),
    ("Scherk", 0.8, true, |u, v| [u, v, (v.cos() / u.cos()).ln()]),
    ("hyperboloid of one sheet", 0.6, true, |u, v| {
        [u.cosh() * v.cos(), u.cosh() * v.sin(), 1.2 * u.sinh()]
    }),
    ("inner part of a torus", 0.9, true, |u, v| {
        // Off the parabolic curves at u = pi / 2.
        let r = 1.0 - 0.4 * u.cos();
        [r * v.cos(), r * v.sin(), -0.4 * u.sin()]
    }),
];
