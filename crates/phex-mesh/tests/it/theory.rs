//! Which hexagons are simple: the statements on the Dupin-dual face of a lattice of touching
//! points, on random cases.
//!
//! Touching points `p_i` on the surface `2 z = q(x, y)` with `q = k1 x^2 + k2 y^2`. The tangent
//! plane at `p` meets the one at the origin in the line `II(p, x) = q(p) / 2`, so the face at the
//! origin has the vertices where the lines of consecutive neighbours meet: the circumcentres, in
//! the metric `q`, of the triangles (origin, p_i, p_i+1).

use phex_mesh::Vec2;
use phex_mesh::polygon::{corner_triples, interior_angles, is_simple, orientation, signed_area};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_3, PI, TAU};

const CASES: usize = 20_000;

/// The second fundamental form `k1 x^2 + k2 y^2`.
#[derive(Clone, Copy, Debug)]
struct Form {
    k1: f64,
    k2: f64,
}

impl Form {
    fn ii(self, v: Vec2, w: Vec2) -> f64 {
        self.k1 * v.x * w.x + self.k2 * v.y * w.y
    }

    fn q(self, v: Vec2) -> f64 {
        self.ii(v, v)
    }

    /// Where the tangent planes at the origin, `p` and `r` meet.
    fn meet(self, p: Vec2, r: Vec2) -> Vec2 {
        // II(p, x) = q(p) / 2 and II(r, x) = q(r) / 2, solved for y = (k1 x_1, k2 x_2) by Cramer's
        // rule.
        let (a, b, det) = (0.5 * self.q(p), 0.5 * self.q(r), p.perp(&r));
        Vec2::new(
            (a * r.y - b * p.y) / (det * self.k1),
            (b * p.x - a * r.x) / (det * self.k2),
        )
    }

    /// The face at the origin, for neighbours in counter-clockwise order.
    fn face(self, neighbours: &[Vec2]) -> Vec<Vec2> {
        let n = neighbours.len();
        (0..n)
            .map(|i| self.meet(neighbours[i], neighbours[(i + 1) % n]))
            .collect()
    }
}

/// The six neighbours of the origin in the lattice of `a` and `b`, which turn to the left.
fn lattice_neighbours(a: Vec2, b: Vec2) -> [Vec2; 6] {
    [a, b, b - a, -a, -b, a - b]
}

fn polar(radius: f64, angle: f64) -> Vec2 {
    Vec2::new(angle.cos(), angle.sin()) * radius
}

/// A form with `|k1| <= |k2| = 1` and two lattice vectors that turn to the left, stretched to the
/// form's own scale.
fn random_lattice(rng: &mut ChaCha8Rng) -> (Form, Vec2, Vec2) {
    let form = Form {
        k1: rng.random_range(-1.0..1.0),
        k2: 1.0,
    };
    let mut vector = || {
        let v = polar(rng.random_range(0.2f64..2.0), rng.random_range(0.0..TAU));
        Vec2::new(v.x / form.k1.abs().sqrt(), v.y)
    };
    let (a, b) = (vector(), vector());
    if a.perp(&b) > 0.0 {
        (form, a, b)
    } else {
        (form, a, -b)
    }
}

/// Calls `check` with many random lattices.
fn for_random_lattices(seed: u64, mut check: impl FnMut(Form, Vec2, Vec2)) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..CASES {
        let (form, a, b) = random_lattice(&mut rng);
        check(form, a, b);
    }
}

/// How far the lattice is on the simple side of the criterion of its sign of `K`; positive if
/// simple.
fn margin(form: Form, a: Vec2, b: Vec2) -> f64 {
    let q = [form.q(a), form.q(b - a), form.q(b)];
    let (low, high) = (
        q.iter().copied().fold(f64::MAX, f64::min),
        q.iter().copied().fold(f64::MIN, f64::max),
    );
    if form.k1 < 0.0 {
        // Edges on both sides of the asymptotic cone.
        (high).min(-low)
    } else {
        // The largest is at most the sum of the others: no obtuse angle.
        q.iter().sum::<f64>() - 2.0 * high
    }
}

fn reflex_corners(polygon: &[Vec2]) -> Vec<usize> {
    let triples = corner_triples(polygon).enumerate();
    triples
        .filter(|(_, [a, b, c])| orientation(*a, *b, *c) < 0.0)
        .map(|(i, _)| i)
        .collect()
}

#[test]
fn face_lies_in_all_tangent_planes_that_meet_there() {
    for_random_lattices(1, |form, a, b| {
        let x = form.meet(a, b);
        for p in [a, b] {
            // Height over the tangent plane at p, of the point x in the tangent plane at the
            // origin.
            let scale = form.k1.abs() * (p.x * x.x).abs() + (p.y * x.y).abs() + p.norm_squared();
            assert!((form.ii(p, x) - 0.5 * form.q(p)).abs() < 1e-12 * scale);
        }
    });
}

#[test]
fn lattice_face_is_simple_if_and_only_if_the_criterion_holds() {
    // Cases by sign of K and by answer.
    let mut counts = [[0; 2]; 2];
    for_random_lattices(2, |form, a, b| {
        let margin = margin(form, a, b);
        if margin.abs() < 1e-9 {
            return; // Rounding decides.
        }
        let simple = is_simple(&form.face(&lattice_neighbours(a, b)));
        assert_eq!(simple, margin > 0.0, "{form:?} {a:?} {b:?}");
        counts[usize::from(form.k1 > 0.0)][usize::from(simple)] += 1;
    });
    assert!(
        counts.as_flattened().iter().all(|&n| n > CASES / 40),
        "every case occurs: {counts:?}"
    );
}

#[test]
fn simple_face_is_convex_where_k_is_positive_and_has_two_opposite_reflex_corners_where_negative() {
    for_random_lattices(3, |form, a, b| {
        let face = form.face(&lattice_neighbours(a, b));
        if !is_simple(&face) || margin(form, a, b).abs() < 1e-9 {
            return;
        }
        let reflex = reflex_corners(&face);
        if form.k1 > 0.0 {
            assert!(reflex.is_empty(), "{reflex:?}");
            assert!(interior_angles(&face).all(|angle| angle < PI + 1e-9));
        } else {
            assert_eq!(reflex.len(), 2, "{form:?} {a:?} {b:?}");
            assert_eq!(reflex[1] - reflex[0], 3);
        }
    });
}

#[test]
fn regular_lattice_in_the_absolute_metric_is_simple_at_every_rotation() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..CASES {
        let form = Form {
            k1: rng.random_range(-1.0..1.0),
            k2: 1.0,
        };
        let angle = rng.random_range(0.0..TAU);
        let neighbours = (0..6).map(|i| {
            let v = polar(1.0, angle + f64::from(i) * FRAC_PI_3);
            Vec2::new(v.x / form.k1.abs().sqrt(), v.y)
        });
        let neighbours: Vec<Vec2> = neighbours.collect();
        if margin(form, neighbours[0], neighbours[1]) > 1e-9 {
            assert!(is_simple(&form.face(&neighbours)), "{form:?} {angle}");
        } else {
            // Only where an edge is an asymptotic direction, and the face a quad.
            assert!(form.k1 < 0.0 && neighbours.iter().any(|&v| form.q(v).abs() < 1e-8));
        }
    }
}

/// The face of an equilateral lattice, turned by `angle` from the direction of smaller curvature,
/// where the smaller curvature in the lattice's metric is `rho`.
fn stretched_face(rho: f64, angle: f64) -> Vec<Vec2> {
    let form = Form { k1: rho, k2: 1.0 };
    form.face(&lattice_neighbours(
        polar(1.0, angle),
        polar(1.0, angle + FRAC_PI_3),
    ))
}

#[test]
fn every_rotation_is_simple_down_to_a_third() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..CASES {
        let rho = rng.random_range(1.0 / 3.0 + 1e-6..1.0);
        let angle = rng.random_range(0.0..TAU);
        assert!(is_simple(&stretched_face(rho, angle)), "{rho} {angle}");
        assert!(is_simple(&stretched_face(-rho, angle)), "{rho} {angle}");
    }
    // And no farther: the worst rotation is 30 degrees.
    assert!(!is_simple(&stretched_face(
        1.0 / 3.0 - 1e-6,
        FRAC_PI_3 / 2.0
    )));
    assert!(!is_simple(&stretched_face(
        -1.0 / 3.0 + 1e-6,
        FRAC_PI_3 / 2.0
    )));
}

#[test]
fn rows_must_follow_the_flat_direction_near_parabolic_curves() {
    for rho in [0.01, 0.02, 0.05f64] {
        // Both bounds are the leading order in rho.
        let elliptic = rho / 3f64.sqrt();
        assert!(is_simple(&stretched_face(rho, 0.9 * elliptic)));
        assert!(!is_simple(&stretched_face(rho, 1.2 * elliptic)));
        let hyperbolic = rho.sqrt().atan();
        assert!(is_simple(&stretched_face(-rho, 0.999 * hyperbolic)));
        assert!(!is_simple(&stretched_face(-rho, 1.001 * hyperbolic)));
    }
}

#[test]
fn valid_star_of_n_neighbours_has_n_minus_4_reflex_corners_where_k_is_negative() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let form = Form { k1: -1.0, k2: 1.0 };
    let mut valid = [0; 9];
    for _ in 0..CASES {
        let (n, start) = (rng.random_range(3..9usize), rng.random_range(0.0..TAU));
        let mut neighbour = |i: usize| {
            let jitter = rng.random_range(-0.3..0.3);
            polar(
                rng.random_range(0.7..1.3),
                start + TAU * (i as f64 + jitter) / n as f64,
            )
        };
        let neighbours: Vec<Vec2> = (0..n).map(&mut neighbour).collect();
        let face = form.face(&neighbours);
        let surrounded = (0..n).all(|i| neighbours[i].perp(&neighbours[(i + 1) % n]) > 0.05);
        // A face that runs clockwise is flipped.
        if surrounded && is_simple(&face) && signed_area(&face) > 0.0 {
            valid[n] += 1;
            assert_eq!(reflex_corners(&face).len(), n - 4, "{neighbours:?}");
        }
    }
    assert_eq!(valid[3], 0, "never a triangle");
    assert!(
        valid[4..].iter().all(|&count| count > CASES / 10),
        "{valid:?}"
    );
}

/// The brick of the conjugate network with row step `a`, row height `b`.
fn brick_neighbours(a: f64, b: f64) -> [Vec2; 6] {
    lattice_neighbours(Vec2::new(a, 0.0), Vec2::new(0.5 * a, b))
}

/// `k1 = q_uu` of either sign and `k2 = q_vv = +-1`, row step and row height.
fn random_brick(rng: &mut ChaCha8Rng) -> (Form, f64, f64) {
    let k2 = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let form = Form {
        k1: rng.random_range(-4.0..4.0),
        k2,
    };
    (form, rng.random_range(0.2..2.0), rng.random_range(0.2..2.0))
}

#[test]
fn brick_has_the_kink_of_the_formula() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..CASES {
        let (form, a, b) = random_brick(&mut rng);
        let kink = a * a * form.k1 / (8.0 * b * form.k2);
        let (side, tip) = (0.5 * b - kink, 0.5 * b + kink);
        let expected = [
            [0.5 * a, side],
            [0.0, tip],
            [-0.5 * a, side],
            [-0.5 * a, -side],
            [0.0, -tip],
            [0.5 * a, -side],
        ];
        for (x, e) in form.face(&brick_neighbours(a, b)).iter().zip(expected) {
            assert!(
                (x - Vec2::from(e)).norm() < 1e-9 * (1.0 + kink.abs()),
                "{form:?} {a} {b}"
            );
        }
    }
}

#[test]
fn brick_is_simple_if_and_only_if_the_sampling_is_appropriate() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut counts = [[0; 2]; 2];
    for _ in 0..2 * CASES {
        let (form, a, b) = random_brick(&mut rng);
        let margin = 4.0 * b * b * form.k2.abs() - a * a * form.k1.abs();
        if margin.abs() < 1e-9 {
            continue;
        }
        let face = form.face(&brick_neighbours(a, b));
        assert_eq!(is_simple(&face), margin > 0.0, "{form:?} {a} {b}");
        counts[usize::from(form.k1 * form.k2 > 0.0)][usize::from(margin > 0.0)] += 1;
        if margin > 0.0 {
            let concave = !reflex_corners(&face).is_empty();
            assert_eq!(
                concave,
                form.k1 * form.k2 < 0.0,
                "the kink's sign decides on convexity"
            );
        }
    }
    assert!(
        counts.as_flattened().iter().all(|&n| n > CASES / 10),
        "every case occurs: {counts:?}"
    );
}

#[test]
fn rows_along_the_smaller_curvature_are_simple_from_half_a_step_up() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for _ in 0..CASES {
        let form = Form {
            k1: rng.random_range(-1.0..1.0),
            k2: 1.0,
        };
        let a = rng.random_range(0.2..2.0);
        let b = a * rng.random_range(0.501..3.0);
        assert!(
            is_simple(&form.face(&brick_neighbours(a, b))),
            "{form:?} {a} {b}"
        );
    }
}

#[test]
fn flat_direction_gives_a_rectangle_with_two_corners_of_180_degrees() {
    let form = Form { k1: 1e-14, k2: 1.0 };
    let face = form.face(&brick_neighbours(1.0, 0.7));
    let angles: Vec<f64> = interior_angles(&face).collect();
    let expected = [0.5, 1.0, 0.5, 0.5, 1.0, 0.5].map(|t| t * PI);
    assert!(
        angles
            .iter()
            .zip(expected)
            .all(|(a, e)| (a - e).abs() < 1e-6),
        "{angles:?}"
    );
    assert!(is_simple(&face));
}
