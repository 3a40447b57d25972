//! Surfaces of the ledger that no file holds: written out as formulas, so that anybody has the
//! same.

use super::implicit::{self, Point};
use crate::figures::Obj;
use std::f64::consts::{PI, TAU};

/// Free-form patch over the unit square whose radius of curvature, .03 at the least, is below the
/// length of a panel.
pub fn wild() -> Obj {
    grid(110, |x, y| {
        let long = 0.10 * (3.1 * x + 0.4).sin() * (2.3 * y + 1.1).cos();
        let short = 0.022 * (17.0 * x + 6.0 * y).sin() * (13.0 * y - 5.0 * x + 0.7).cos();
        let bump = 0.06 * (-((x - 0.7).powi(2) + (y - 0.35).powi(2)) / 0.004).exp();
        long + short + bump
    })
}

/// A dome measured with an error of a tenth of an edge: every vertex is off by that much, up or
/// down.
pub fn noisy_scan() -> Obj {
    const SIDE: usize = 70;
    let dome = grid(SIDE, |x, y| {
        0.9 * (x - x * x) + 0.7 * (y - y * y) + 0.15 * (2.0 * x * y).sin()
    });
    let mut state = 1_u64;
    dome.mapped(|[x, y, z]| {
        // The constants of Knuth's linear congruential generator; its upper bits are good.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let uniform = (state >> 11) as f64 / (1_u64 << 53) as f64;
        [x, y, z + 0.2 / SIDE as f64 * (uniform - 0.5)]
    })
}

/// A vaulted plate with twenty round holes of three sizes.
pub fn plate_with_holes() -> Obj {
    const SIDE: usize = 120;
    let hole = |k: usize| {
        let (i, j) = (k % 5, k / 5);
        let centre = [0.1 + 0.2 * i as f64, 0.125 + 0.25 * j as f64];
        (centre, [0.035, 0.05, 0.065][(i + 2 * j) % 3])
    };
    let plate = grid(SIDE, |_, _| 0.0);
    let cell = 1.0 / SIDE as f64;
    // Vertices within half a cell of a circle go onto it, so that its rim is round.
    let round = plate.mapped(|[x, y, z]| {
        let near = (0..20).find_map(|k| {
            let ([a, b], radius) = hole(k);
            let (dx, dy) = (x - a, y - b);
            let distance = dx.hypot(dy);
            let onto = radius / distance;
            ((distance - radius).abs() < 0.55 * cell).then_some([a + onto * dx, b + onto * dy, z])
        });
        near.unwrap_or([x, y, z])
    });
    let solid = round.part(|c| {
        (0..20).all(|k| {
            let ([a, b], radius) = hole(k);
            (c[0] - a).hypot(c[1] - b) > radius
        })
    });
    solid.mapped(|[x, y, _]| [1.5 * x, y, 0.5 * (x - x * x) + 0.3 * (y - y * y)])
}

/// A shell over a plan with corners of 37, 60, 90 and 120 degrees of turn, and one that points
/// inwards.
pub fn shell_with_corners() -> Obj {
    // Corners stand on the rings' rays, a multiple of 60 / RINGS degrees each.
    const RINGS: usize = 36;
    let plan: [(usize, f64); 7] = [
        (0, 1.0),
        (30, 0.8),
        (58, 0.95),
        (84, 0.62),
        (112, 1.05),
        (150, 0.72),
        (186, 0.78),
    ];
    let full = 6 * RINGS;
    let at = |k: usize| {
        let turn = TAU * plan[k].0 as f64 / full as f64;
        [plan[k].1 * turn.cos(), plan[k].1 * turn.sin()]
    };
    let rim = |t: f64| {
        let place = t * full as f64;
        let after = (0..plan.len()).find(|&k| plan[k].0 as f64 > place + 1e-9);
        let b = after.unwrap_or(0);
        let a = (b + plan.len() - 1) % plan.len();
        let end = if b == 0 { full } else { plan[b].0 };
        let s = (place - plan[a].0 as f64) / (end - plan[a].0) as f64;
        let (a, b) = (at(a), at(b));
        [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
    };
    disc(RINGS).mapped(|[r, t, _]| {
        let [x, y] = rim(t).map(|x| r * x);
        let height = 0.35 - 0.25 * x * x - 0.12 * y * y + 0.1 * x * y;
        [x, y, height]
    })
}

/// A body with two thin ears, each about a fortieth of it thick.
pub fn eared_body() -> Obj {
    let ear = |p: Point, side: f64| {
        let q = [
            (p[0] - side * 0.42) / 0.28,
            p[1] / 0.05,
            (p[2] - 0.75) / 0.42,
        ];
        0.05 * (norm(q) - 1.0)
    };
    let body = |p: Point| {
        let belly = 0.62 * (norm([p[0] / 0.75, p[1] / 0.55, (p[2] + 0.05) / 0.62]) - 1.0);
        union(union(belly, ear(p, 1.0), 0.04), ear(p, -1.0), 0.04)
    };
    implicit::mesh(body, 1.3, 96)
}

/// A block with filleted edges and two rings that run into it.
pub fn block_with_rings() -> Obj {
    let block = |p: Point| {
        let out = [0.6, 0.4, 0.25].iter().zip(p);
        let out: Vec<f64> = out.map(|(half, x)| (x.abs() - half).max(0.0)).collect();
        norm([out[0], out[1], out[2]]) - 0.12
    };
    let ring = |p: Point, x: f64, z: f64| {
        let around = (p[0] - x).hypot(p[2] - z) - 0.26;
        around.hypot(p[1]) - 0.09
    };
    let both = |p: Point| {
        let first = union(block(p), ring(p, -0.35, 0.45), 0.08);
        union(first, ring(p, 0.85, 0.1), 0.08)
    };
    // With 90 cells a side a face of the block would lie in a plane of the grid.
    implicit::mesh(both, 1.35, 88)
}

/// Two tori that run into each other: genus 2.
pub fn double_torus() -> Obj {
    let torus = |p: Point, x: f64| ((p[0] - x).hypot(p[1]) - 0.45).hypot(p[2]) - 0.2;
    implicit::mesh(|p| union(torus(p, -0.48), torus(p, 0.48), 0.15), 1.3, 72)
}

/// Two round ends and a waist between them, 3.4 times as long as wide.
pub fn dumbbell() -> Obj {
    let ball = |p: Point, x: f64| norm([p[0] - x, p[1], p[2]]) - 0.36;
    let waist = |p: Point| {
        let along = (p[0].abs() - 0.6).max(0.0);
        along.hypot(p[1].hypot(p[2])) - 0.15
    };
    let all = |p: Point| union(union(ball(p, -0.75), ball(p, 0.75), 0.1), waist(p), 0.12);
    implicit::mesh(all, 1.25, 64)
}

/// A convex body of superelliptic sections, with six nearly flat parts.
pub fn blob() -> Obj {
    let power = |x: f64| x.abs().powf(3.5);
    let level = |p: Point| power(p[0]) + power(p[1] / 0.9) + power(p[2] / 0.7);
    implicit::mesh(|p| level(p).powf(1.0 / 3.5) - 1.0, 1.2, 40)
}

/// An ellipsoid of axes 3 : 1 : 1.
pub fn long_ellipsoid() -> Obj {
    implicit::mesh(|p| norm([p[0] / 3.0, p[1], p[2]]) - 1.0, 3.2, 76)
}

/// A closed tube about a trefoil knot.
pub fn trefoil() -> Obj {
    let axis = |t: f64| {
        [
            t.sin() + 2.0 * (2.0 * t).sin(),
            t.cos() - 2.0 * (2.0 * t).cos(),
            -(3.0 * t).sin(),
        ]
    };
    tube(240, 24, axis, |_| 0.55)
}

/// A ring whose girth rises and falls five times.
pub fn bumpy_ring() -> Obj {
    tube(
        200,
        28,
        |t| [2.0 * t.cos(), 2.0 * t.sin(), 0.0],
        |t| 0.5 + 0.12 * (5.0 * t).cos(),
    )
}

/// Triangles over the unit square, `n` cells a side, with alternating diagonals.
fn grid(n: usize, height: impl Fn(f64, f64) -> f64) -> Obj {
    let at = |k: usize| k as f64 / n as f64;
    let nodes = (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
    let points = nodes.map(|(i, j)| [at(i), at(j), height(at(i), at(j))]);
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let faces = cells.flat_map(|(i, j)| {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| i * (n + 1) + j);
        match (i + j) % 2 {
            0 => [vec![a, b, c], vec![a, c, d]],
            _ => [vec![a, b, d], vec![b, c, d]],
        }
    });
    Obj {
        points: points.collect(),
        faces: faces.collect(),
    }
}

/// Rings of 6, 12, 18, ... vertices about a point, in polar coordinates: share of the radius, share
/// of the turn, 0.
fn disc(rings: usize) -> Obj {
    let mut disc = Obj {
        points: vec![[0.0; 3]],
        faces: Vec::new(),
    };
    let number = |ring: usize, k: usize| match ring {
        0 => 0,
        _ => 1 + 3 * ring * (ring - 1) + k % (6 * ring),
    };
    for ring in 1..=rings {
        let share = |k: usize| k as f64 / (6 * ring) as f64;
        let r = ring as f64 / rings as f64;
        disc.points
            .extend((0..6 * ring).map(|k| [r, share(k), 0.0]));
        for side in 0..6 {
            for k in 0..ring {
                let (outer, inner) = (side * ring + k, side * (ring - 1) + k);
                let here = number(ring - 1, inner);
                disc.faces
                    .push(vec![here, number(ring, outer), number(ring, outer + 1)]);
                if k + 1 < ring {
                    disc.faces.push(vec![
                        here,
                        number(ring, outer + 1),
                        number(ring - 1, inner + 1),
                    ]);
                }
            }
        }
    }
    disc
}

/// A closed tube about a closed curve, `along` times `around` vertices; frames come from the
/// curve's second derivative.
fn tube(
    along: usize,
    around: usize,
    axis: impl Fn(f64) -> Point,
    girth: impl Fn(f64) -> f64,
) -> Obj {
    let h = 1e-3;
    let ring = |i: usize| {
        let t = TAU * i as f64 / along as f64;
        let (a, b, c) = (axis(t - h), axis(t), axis(t + h));
        let tangent = unit(std::array::from_fn(|k| c[k] - a[k]));
        let bend: Point = std::array::from_fn(|k| a[k] - 2.0 * b[k] + c[k]);
        let along = (0..3).map(|k| bend[k] * tangent[k]).sum::<f64>();
        let u = unit(std::array::from_fn(|k| bend[k] - along * tangent[k]));
        let v = cross(tangent, u);
        let radius = girth(t);
        (0..around).map(move |j| {
            let turn =
                TAU * j as f64 / around as f64 + if i % 2 == 1 { PI / around as f64 } else { 0.0 };
            let (cos, sin) = (radius * turn.cos(), radius * turn.sin());
            std::array::from_fn(|k| b[k] + cos * u[k] + sin * v[k])
        })
    };
    let number = |i: usize, j: usize| i % along * around + j % around;
    let cells = (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
    let faces = cells.flat_map(|(i, j)| match i % 2 {
        0 => [
            vec![number(i, j), number(i, j + 1), number(i + 1, j)],
            vec![number(i, j + 1), number(i + 1, j + 1), number(i + 1, j)],
        ],
        _ => [
            vec![number(i, j), number(i, j + 1), number(i + 1, j + 1)],
            vec![number(i, j), number(i + 1, j + 1), number(i + 1, j)],
        ],
    });
    let mut tube = Obj {
        points: (0..along).flat_map(ring).collect(),
        faces: faces.collect(),
    };
    // Outwards is where the tube's normal leaves its axis.
    if !is_outward(&tube, axis(0.0)) {
        tube.faces.iter_mut().for_each(|f| f.reverse());
    }
    tube
}

fn is_outward(tube: &Obj, axis: Point) -> bool {
    let face = &tube.faces[0];
    let [a, b, c] = [0, 1, 2].map(|k| tube.points[face[k]]);
    let minus = |p: Point, q: Point| -> Point { std::array::from_fn(|k| p[k] - q[k]) };
    let normal = cross(minus(b, a), minus(c, a));
    (0..3).map(|k| normal[k] * (a[k] - axis[k])).sum::<f64>() > 0.0
}

/// The smaller of two distances, rounded off where they differ by less than `fillet`.
fn union(a: f64, b: f64, fillet: f64) -> f64 {
    let overlap = (fillet - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * fillet)
}

fn norm(p: Point) -> f64 {
    p.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn unit(p: Point) -> Point {
    let length = norm(p);
    p.map(|x| x / length)
}

fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn half_edges(mesh: &Obj) -> HashSet<(usize, usize)> {
        let of = |f: &Vec<usize>| {
            (0..f.len())
                .map(|k| (f[k], f[(k + 1) % f.len()]))
                .collect::<Vec<_>>()
        };
        mesh.faces.iter().flat_map(of).collect()
    }

    /// Vertices in use less edges plus faces, and whether no edge is run through twice the same
    /// way.
    fn euler(mesh: &Obj) -> (i64, bool) {
        let half_edges = half_edges(mesh);
        let edges: HashSet<_> = half_edges
            .iter()
            .map(|&(a, b)| (a.min(b), a.max(b)))
            .collect();
        let used: HashSet<usize> = mesh.faces.iter().flatten().copied().collect();
        let corners: usize = mesh.faces.iter().map(Vec::len).sum();
        let euler = used.len() as i64 - edges.len() as i64 + mesh.faces.len() as i64;
        (euler, corners == half_edges.len())
    }

    fn shortest_over_longest(mesh: &Obj) -> f64 {
        let length = |(a, b): (usize, usize)| {
            let (a, b) = (mesh.points[a], mesh.points[b]);
            norm(std::array::from_fn(|k| a[k] - b[k]))
        };
        let lengths: Vec<f64> = half_edges(mesh).into_iter().map(length).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        lengths.into_iter().fold(f64::INFINITY, f64::min) / longest
    }

    #[test]
    fn every_surface_is_oriented_and_of_its_genus() {
        let expected = [
            (wild(), 1),
            (noisy_scan(), 1),
            (plate_with_holes(), 1 - 20),
            (shell_with_corners(), 1),
            (eared_body(), 2),
            (block_with_rings(), -2),
            (double_torus(), -2),
            (dumbbell(), 2),
            (blob(), 2),
            (long_ellipsoid(), 2),
            (trefoil(), 0),
            (bumpy_ring(), 0),
        ];
        for (k, (mesh, chi)) in expected.iter().enumerate() {
            assert_eq!(euler(mesh), (*chi, true), "surface {k}");
            assert!(shortest_over_longest(mesh) > 1e-3, "surface {k}");
        }
    }
}
