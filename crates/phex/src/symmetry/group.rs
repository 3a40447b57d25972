//! Groups of mirror planes: reflections in two planes through an axis, and in one across it.

use super::choice::MOST_TURNS;
use crate::directions::MirrorPlane;
use crate::optimise::in_plane;
use nalgebra::Matrix3;
use phex_mesh::Vec3;
use std::f64::consts::{PI, TAU};

/// Distance of entries of orthogonal matrices below which they are the same map.
const SAME_MAP: f64 = 1e-6;

/// A group of reflections, in a frame whose `z` axis is its axis and whose plane `y = 0` is one of
/// its mirror planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Group {
    /// Rotations about the axis by multiples of a turn over this number, at least 1. Mirror planes
    /// through the axis are half as far apart.
    pub rotations: u32,
    /// Whether the plane `z = 0` is a mirror plane, too.
    pub level: bool,
}

impl Group {
    /// Number of its elements.
    pub fn order(self) -> u32 {
        2 * self.rotations * (1 + u32::from(self.level))
    }

    /// Its name in Schoenflies' notation.
    pub fn name(self) -> String {
        match (self.rotations, self.level) {
            (1, false) => "Cs".into(),
            (1, true) => "C2v".into(),
            (n, false) => format!("C{n}v"),
            (n, true) => format!("D{n}h"),
        }
    }

    /// Its elements: the identity first, then with the reflection in `y = 0` where the number is
    /// odd, rotated turn by turn, and at last all of them reflected in `z = 0`.
    pub(crate) fn elements(self) -> Vec<Matrix3<f64>> {
        let levels = [1.0, -1.0];
        let levels = &levels[..1 + usize::from(self.level)];
        let turns = 0..self.rotations;
        let flips = [1.0, -1.0];
        (levels.iter())
            .flat_map(|z| turns.clone().map(move |k| (k, z)))
            .flat_map(|(k, z)| flips.map(|y| (k, y, z)))
            .map(|(k, y, z)| {
                turn(k, self.rotations) * Matrix3::from_diagonal(&Vec3::new(1.0, y, *z))
            })
            .collect()
    }

    /// Inward unit normals of the mirror planes round the fundamental domain.
    pub(crate) fn walls(self) -> Vec<Vec3> {
        let mut walls = vec![Vec3::y()];
        if self.rotations > 1 {
            let half = half_turn(self.rotations);
            walls.push(Vec3::new(half.y, -half.x, 0.0));
        }
        if self.level {
            walls.push(Vec3::z());
        }
        walls
    }

    /// The walls as planes that a lattice is symmetric about.
    pub(crate) fn mirrors(self) -> Vec<MirrorPlane> {
        let plane = |n: &Vec3| MirrorPlane {
            point: [0.0; 3],
            normal: (*n).into(),
        };
        self.walls().iter().map(plane).collect()
    }
}

/// Rotation about `z` by `k` turns over `n`, exact for quarters.
pub(crate) fn turn(k: u32, n: u32) -> Matrix3<f64> {
    let (c, s) = match (4 * k) % n {
        0 => [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][(4 * k / n % 4) as usize],
        _ => {
            let angle = TAU * f64::from(k) / f64::from(n);
            (angle.cos(), angle.sin())
        }
    };
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// The direction of the second wall, half of a rotation away from `x`.
fn half_turn(n: u32) -> Vec3 {
    match n {
        2 => Vec3::y(),
        _ => {
            let angle = PI / f64::from(n);
            Vec3::new(angle.cos(), angle.sin(), 0.0)
        }
    }
}

/// The reflection in the plane through the origin with a unit normal.
pub(crate) fn reflection(normal: Vec3) -> Matrix3<f64> {
    match normal.iter().position(|c| c.abs() == 1.0) {
        Some(axis) => {
            let mut signs = Vec3::repeat(1.0);
            signs[axis] = -1.0;
            Matrix3::from_diagonal(&signs)
        }
        None => Matrix3::identity() - normal * normal.transpose() * 2.0,
    }
}

/// The number of an element among those of a group.
pub(crate) fn number_of(elements: &[Matrix3<f64>], map: &Matrix3<f64>) -> Option<usize> {
    let levels = match elements.last()?[(2, 2)] < 0.0 {
        true => 2,
        false => 1,
    };
    let turns = elements.len() / (2 * levels);
    let angle = map[(1, 0)].atan2(map[(0, 0)]).rem_euclid(TAU);
    let turn = (angle / TAU * turns as f64).round() as usize % turns;
    let is_flipped = map[(0, 0)] * map[(1, 1)] < map[(0, 1)] * map[(1, 0)];
    let level = usize::from(map[(2, 2)] < 0.0);
    let number = 2 * (level * turns + turn) + usize::from(is_flipped);
    let is_it = |e: &&Matrix3<f64>| (*e - map).amax() < SAME_MAP;
    elements.get(number).filter(is_it).map(|_| number)
}

/// The bits of those planes that `holds` says so of.
pub(crate) fn bits_of(normals: &[Vec3], holds: impl Fn(&Vec3) -> bool) -> u32 {
    let held = normals.iter().enumerate().filter(|(_, n)| holds(n));
    held.fold(0, |bits, (k, _)| bits | (1 << k))
}

/// The normals of the planes that `bits` names.
pub(crate) fn named(normals: &[Vec3], bits: u32) -> Vec<Vec3> {
    let all = normals.iter().enumerate();
    let named = all.filter(|(k, _)| bits & (1 << k) != 0);
    named.map(|(_, n)| *n).collect()
}

/// The point nearest to `p` in those planes through the origin that `bits` names.
pub(crate) fn in_walls(normals: &[Vec3], bits: u32, mut p: Vec3) -> Vec3 {
    let held = named(normals, bits);
    match held[..] {
        [a, b] => {
            let axis = a.cross(&b).normalize();
            p = axis * axis.dot(&p);
        }
        [_, _, _, ..] => p = Vec3::zeros(),
        _ => {}
    }
    (held.into_iter()).fold(p, |p, normal| in_plane(p, Vec3::zeros(), normal))
}

/// Brings a point into the fundamental domain: the point there, and the map that takes it back.
pub(crate) fn folded(walls: &[Vec3], mut p: Vec3) -> (Vec3, Matrix3<f64>) {
    let mut back = Matrix3::identity();
    for _ in 0..MOST_REFLECTIONS {
        let Some(normal) = walls.iter().find(|n| n.dot(&p) < 0.0) else {
            break;
        };
        let map = reflection(*normal);
        p = map * p;
        back *= map;
    }
    (p, back)
}

/// Reflections that bring any point into the domain: one for each half of a rotation on the way
/// there, and the one in the plane across the axis.
const MOST_REFLECTIONS: usize = MOST_TURNS as usize + 2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_form_a_group_that_its_walls_generate() {
        for (rotations, level) in [(1, false), (1, true), (2, true), (5, false), (6, true)] {
            let group = Group { rotations, level };
            let elements = group.elements();
            assert_eq!(elements.len() as u32, group.order());
            for a in &elements {
                for b in &elements {
                    let product = number_of(&elements, &(a * b)).unwrap();
                    assert!((elements[product] - a * b).amax() < 1e-12);
                }
            }
            let p = Vec3::new(0.3, 0.011, 0.2);
            for e in &elements {
                let (q, back) = folded(&group.walls(), e * p);
                assert!(group.walls().iter().all(|n| n.dot(&q) >= 0.0));
                assert!((back * q - e * p).norm() < 1e-12, "{group:?}");
                assert!((q - folded(&group.walls(), p).0).norm() < 1e-12);
                assert!(number_of(&elements, &back).is_some());
            }
        }
    }

    #[test]
    fn points_are_folded_by_the_largest_group_too() {
        let group = Group {
            rotations: MOST_TURNS,
            level: true,
        };
        let elements = group.elements();
        for p in [Vec3::new(-0.3, 1e-4, -0.2), Vec3::new(0.02, -1.0, 0.1)] {
            let (q, back) = folded(&group.walls(), p);
            assert!(group.walls().iter().all(|n| n.dot(&q) >= 0.0), "{p}");
            assert!(number_of(&elements, &back).is_some(), "{p}");
        }
    }
}
