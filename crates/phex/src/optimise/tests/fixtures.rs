//! Analytic surfaces with exact closest points, and panellings of them.

use crate::layout::{Layout, VertexKind};
use crate::optimise::{Target, TargetPoint};
use phex_mesh::{BoundaryPoint, HexMesh, PerFace, Vec3, VertexId};
use std::f64::consts::TAU;

/// Surfaces to optimise on.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Radii 1 and 0.4, times the factor.
    Torus(f64),
    /// `z = 0.3 sin x + 0.2 sin y`.
    Wave,
    /// `z = 0.3 (x^3 - 3 x y^2)`.
    MonkeySaddle,
    /// Semi-axes.
    Ellipsoid(Vec3),
    /// The square `|x|, |y| <= 1` of the plane, with its outline.
    Square,
}

impl Shape {
    pub fn height(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Wave => 0.3 * x.sin() + 0.2 * y.sin(),
            Self::MonkeySaddle => 0.3 * (x * x * x - 3.0 * x * y * y),
            _ => 0.0,
        }
    }

    /// First and second derivatives of the height: `[x, y, xx, xy, yy]`.
    fn slopes(self, x: f64, y: f64) -> [f64; 5] {
        match self {
            Self::Wave => [
                0.3 * x.cos(),
                0.2 * y.cos(),
                -0.3 * x.sin(),
                0.0,
                -0.2 * y.sin(),
            ],
            Self::MonkeySaddle => [
                0.9 * (x * x - y * y),
                -1.8 * x * y,
                1.8 * x,
                -1.8 * y,
                -1.8 * x,
            ],
            _ => [0.0; 5],
        }
    }

    fn foot(self, p: Vec3) -> TargetPoint {
        match self {
            Self::Torus(scale) => {
                let ring = Vec3::new(p.x, p.y, 0.0).normalize() * scale;
                let normal = (p - ring).normalize();
                TargetPoint {
                    position: ring + normal * (0.4 * scale),
                    normal,
                }
            }
            Self::Ellipsoid(axes) => ellipsoid_foot(axes, p),
            Self::Square => TargetPoint {
                position: Vec3::new(p.x.clamp(-1.0, 1.0), p.y.clamp(-1.0, 1.0), 0.0),
                normal: Vec3::z(),
            },
            Self::Wave | Self::MonkeySaddle => self.graph_foot(p),
        }
    }

    /// Newton's method for the closest point of a graph.
    fn graph_foot(self, p: Vec3) -> TargetPoint {
        let (mut x, mut y) = (p.x, p.y);
        for _ in 0..20 {
            let (dz, s) = (self.height(x, y) - p.z, self.slopes(x, y));
            let g = [x - p.x + dz * s[0], y - p.y + dz * s[1]];
            let (a, b, d) = (
                1.0 + s[0] * s[0] + dz * s[2],
                s[0] * s[1] + dz * s[3],
                1.0 + s[1] * s[1] + dz * s[4],
            );
            let det = a * d - b * b;
            x -= (d * g[0] - b * g[1]) / det;
            y -= (a * g[1] - b * g[0]) / det;
        }
        let s = self.slopes(x, y);
        TargetPoint {
            position: Vec3::new(x, y, self.height(x, y)),
            normal: Vec3::new(-s[0], -s[1], 1.0).normalize(),
        }
    }
}

/// Closest point of an ellipsoid: `x_i = a_i^2 p_i / (a_i^2 + t)` with `t` by bisection.
fn ellipsoid_foot(axes: Vec3, p: Vec3) -> TargetPoint {
    let squares = axes.component_mul(&axes);
    let point = |t: f64| {
        squares
            .component_mul(&p)
            .component_div(&squares.add_scalar(t))
    };
    let excess = |t: f64| point(t).component_div(&axes).norm_squared() - 1.0;
    let (mut low, mut high) = (-0.99 * squares.min(), 10.0 * p.norm() * axes.max());
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let position = point(0.5 * (low + high));
    TargetPoint {
        position,
        normal: position.component_div(&squares).normalize(),
    }
}

impl Target for Shape {
    fn closest_points(&self, points: &[Vec3], _near: &[TargetPoint]) -> Vec<TargetPoint> {
        points.iter().map(|&p| self.foot(p)).collect()
    }

    fn closest_on_boundary(&self, points: &[Vec3]) -> Option<Vec<BoundaryPoint>> {
        let outline = |p: &Vec3| {
            let sides = [(Vec3::x(), Vec3::y()), (Vec3::y(), Vec3::x())];
            let on_side = sides.iter().flat_map(|(across, along)| {
                [-1.0, 1.0].map(|s| BoundaryPoint {
                    position: across * s + along * p.dot(along).clamp(-1.0, 1.0),
                    tangent: *along,
                })
            });
            let distance = |q: &BoundaryPoint| (q.position - p).norm();
            on_side
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .unwrap()
        };
        matches!(self, Self::Square).then(|| points.iter().map(outline).collect())
    }
}

/// Vertex grid and faces of a brick wall; `wrap` closes it both ways. Vertex `(i, j)` is number
/// `j * columns + i`.
pub fn brick_faces(columns: usize, rows: usize, wrap: bool) -> Vec<Vec<u32>> {
    let at = |i: usize, j: usize| {
        let lines = if wrap { rows } else { rows + 1 };
        ((j % lines) * columns + i % columns) as u32
    };
    let mut faces = Vec::new();
    for j in 0..rows {
        let mut i = j % 2;
        while if wrap { i < columns } else { i + 2 < columns } {
            let lower = [at(i, j), at(i + 1, j), at(i + 2, j)];
            let upper = [at(i + 2, j + 1), at(i + 1, j + 1), at(i, j + 1)];
            faces.push([lower, upper].concat());
            i += 2;
        }
    }
    faces
}

/// A mesh of the used ones of some points.
pub fn mesh(points: &[Vec3], faces: &[Vec<u32>]) -> HexMesh {
    let mut number = vec![u32::MAX; points.len()];
    let mut used = Vec::new();
    let renumbered: Vec<Vec<u32>> = faces
        .iter()
        .map(|f| {
            f.iter()
                .map(|&v| {
                    let n = &mut number[v as usize];
                    if *n == u32::MAX {
                        *n = used.len() as u32;
                        used.push(points[v as usize]);
                    }
                    *n
                })
                .collect()
        })
        .collect();
    HexMesh::new(used, &renumbered).unwrap()
}

/// A brick wall on a surface.
pub fn brick_wall(shape: Shape, columns: usize, rows: usize) -> HexMesh {
    let torus = matches!(shape, Shape::Torus(_));
    let lines = if torus { rows } else { rows + 1 };
    let grid = (0..lines).flat_map(|j| (0..columns).map(move |i| (i as f64, j as f64)));
    let place = |(i, j): (f64, f64)| match shape {
        Shape::Torus(scale) => {
            let (u, v) = (TAU * i / columns as f64, TAU * j / rows as f64);
            let r = 1.0 + 0.4 * v.cos();
            Vec3::new(r * u.cos(), r * u.sin(), 0.4 * v.sin()) * scale
        }
        _ => {
            let x = 2.0 * i / (columns - 1) as f64 - 1.0;
            let y = 2.0 * j / rows as f64 - 1.0;
            let extent = if matches!(shape, Shape::Wave) {
                2.0
            } else {
                0.9
            };
            let (x, y) = (extent * x, extent * y);
            Vec3::new(x, y, shape.height(x, y))
        }
    };
    mesh(
        &grid.map(place).collect::<Vec<_>>(),
        &brick_faces(columns, rows, torus),
    )
}

/// The layout record of a mesh on a surface.
pub fn layout(mesh: HexMesh, target: &dyn Target) -> Layout {
    let feet = target.closest_points(mesh.centres().as_slice(), &[]);
    let lengths = PerFace::filled(feet.len(), 1.7 * mesh.mean_edge());
    let kinds = VertexKind::of_mesh(&mesh);
    let feet = feet.iter().map(|q| (q.position, q.normal));
    Layout::new(mesh, kinds, feet, lengths)
}

/// An exactly planar mesh of regular hexagons in plan on `z = x^2 + y^2`: faces lie in tangent
/// planes.
pub fn planar_paraboloid(columns: usize, rows: usize) -> HexMesh {
    let edge = 0.05;
    let grid = (0..=rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let place = |(i, j): (usize, usize)| {
        let kink = if (i + j) % 2 == 0 { 0.25 } else { -0.25 };
        let x = edge * 0.75f64.sqrt() * (i as f64 - 0.5 * columns as f64);
        let y = edge * (1.5 * (j as f64 - 0.5 * rows as f64) + kink);
        Vec3::new(x, y, x * x + y * y - edge * edge)
    };
    mesh(
        &grid.map(place).collect::<Vec<_>>(),
        &brick_faces(columns, rows, false),
    )
}

/// An exactly planar mesh of concave hexagons on `z = c / 2 (x^2 - y^2)`, in tangent planes at the
/// points of a lattice with mean edge about 1: the meets of three planes are circumcentres in the
/// metric `dx^2 - dy^2`.
pub fn planar_saddle(columns: usize, rows: usize, curvature: f64) -> HexMesh {
    let (a, b): (f64, f64) = (1.7, 1.5);
    let kink = a * a / (8.0 * b);
    let grid = (0..=rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let place = |(i, j): (usize, usize)| {
        let x = 0.5 * a * (i as f64 - 0.5 * columns as f64);
        let up = if (i + j) % 2 == 0 { -kink } else { kink };
        let y = b * (j as f64 - 0.5 * rows as f64) + up;
        let power = (0.5 * b - kink).powi(2);
        Vec3::new(x, y, 0.5 * curvature * (x * x - y * y + power))
    };
    mesh(
        &grid.map(place).collect::<Vec<_>>(),
        &brick_faces(columns, rows, false),
    )
}

/// Turns an inner edge between two neighbours: its faces lose a corner each, those at its ends gain
/// one.
pub fn turn_edge(mesh: &HexMesh, a: u32, b: u32) -> HexMesh {
    let mut faces = mesh.topology().face_lists();
    let next = |f: &[u32], v: u32| f[(f.iter().position(|&w| w == v).unwrap() + 1) % f.len()];
    let runs = |f: &[u32], v: u32, w: u32| f.contains(&v) && next(f, v) == w;
    let left = faces.iter().position(|f| runs(f, a, b)).unwrap();
    let right = faces.iter().position(|f| runs(f, b, a)).unwrap();
    let (after_a, after_b) = (next(&faces[right], a), next(&faces[left], b));
    let at_ends = [(a, after_a, b), (b, after_b, a)].map(|(v, before, other)| {
        let mut faces = faces.iter();
        faces.position(|f| runs(f, before, v) && !f.contains(&other))
    });
    phex_mesh::turn_edge(&mut faces, [a, b], [left, right], at_ends);
    let mut points = mesh.positions.as_slice().to_vec();
    let (p, q) = (points[a as usize], points[b as usize]);
    let side = |f: usize| {
        let corners = faces[f].iter().map(|&v| mesh.positions[VertexId::new(v)]);
        (corners.sum::<Vec3>() / faces[f].len() as f64 - (p + q) * 0.5).normalize()
    };
    let reach = 0.4 * (p - q).norm();
    points[a as usize] = (p + q) * 0.5 + side(left) * reach;
    points[b as usize] = (p + q) * 0.5 + side(right) * reach;
    HexMesh::new(points, &faces).unwrap()
}

/// Deterministic noise in [-1, 1].
pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// The same mesh with every vertex moved by up to `amount` mean edges in each coordinate.
pub fn jittered(mesh: &HexMesh, amount: f64, seed: u64) -> HexMesh {
    let (mut next, size) = (noise(seed), amount * mesh.mean_edge());
    let moved = |p: &Vec3| p + Vec3::new(next(), next(), next()) * size;
    mesh.with_positions(mesh.positions.map(moved))
}
