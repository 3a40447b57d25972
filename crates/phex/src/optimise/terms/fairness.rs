//! Fairness: a panel is drawn to be its neighbour moved along, and to be centrally symmetric.
//!
//! Where hexagons `f` and `g` meet in an edge `q w`, the edge of `g` that ends in `q` and the edge
//! of `f` that ends in `w` are opposite in a regular pattern, and so are those that begin there.
//! Each such pair with vectors `a`, `b` (one of them turned round) pays
//!
//! ```text
//! w/4 |T (a / s - s b)|^2,    s^4 = A_g / A_f
//! ```
//!
//! `T` projects along the mean normal of both panels, which stays as it is at the start: that they
//! turn with the surface costs nothing. `A` are the areas that panels are to have: where sizes are
//! to change, so are edges. Panels that are no hexagons, or lie at the boundary, are no examples
//! for others and take none.
//!
//! One hexagon moved along is centrally symmetric, convex or concave, as every Dupin hexagon is.
//! For a panel with `2m` corners that is wanted without regard to its neighbours, too, which are
//! no example where the curvature changes its sign:
//!
//! ```text
//! w/2 sum_a |x_a + x_(a+m) - M|^2,    M the mean of the m sums
//! ```
//!
//! A pair ties vertices that have no panel in common and would fill the Hessian, which has the part
//! of each edge alone: the like edge counts as at rest. Gradients are exact. Where the minimum
//! itself is sought, pairs are [frozen](Fairness::freeze): with the middle `m` of `u = a / s` and
//! `v = s b` at some positions
//!
//! ```text
//! |u - v|^2 <= 2 |u - m|^2 + 2 |v - m|^2
//! ```
//!
//! with equal value and gradient there, and the Hessian of the right side is exact.

use super::areas::AreaWish;
use crate::optimise::panels::{Corner, FaceShapes, Panels, add_block, add_difference, point};
use nalgebra::Matrix3;
use phex_mesh::Vec3;

/// Weight of likeness over that of central symmetry: with 1 areas differ by a twentieth more on
/// average, with 1/4 half of what sharp angles gain is lost.
const LIKENESS: f64 = 0.5;

/// The opposite of an edge in the hexagon beyond one of its ends.
#[derive(Clone, Debug)]
struct LikeEdge {
    /// The ends between which it runs as the edge does.
    ends: [u32; 2],
    /// `s`.
    scale: f64,
    /// Unit normal along which nothing is to pay.
    normal: Vec3,
    /// Part of the pair's energy that is counted here: half, and all where the other panel rests.
    part: f64,
    /// `m`, where it is frozen.
    middle: Option<Vec3>,
}

impl LikeEdge {
    fn tangential(&self, vector: Vec3) -> Vec3 {
        vector - self.normal * self.normal.dot(&vector)
    }

    /// The like edge, as long as in a panel of the size between both.
    fn vector(&self, x: &[f64]) -> Vec3 {
        let [from, to] = self.ends.map(|v| point(x, v as usize));
        (to - from) * self.scale
    }

    /// `T (u - v)`, or `2 T (u - m)`.
    fn lack(&self, edge: Vec3, x: &[f64]) -> Vec3 {
        let own = edge / self.scale;
        self.tangential(match self.middle {
            Some(middle) => (own - middle) * 2.0,
            None => own - self.vector(x),
        })
    }
}

/// Like edges of all edges, from which the energy comes.
#[derive(Clone, Debug)]
pub(in crate::optimise) struct Fairness {
    /// At a corner, for the edge from it to the next: beyond its end, and beyond its beginning.
    likes: Vec<[Option<LikeEdge>; 2]>,
}

impl Fairness {
    /// Of panels that lie at `shape` and are to have `areas`.
    pub fn new(panels: &Panels, shape: &FaceShapes, areas: &[AreaWish]) -> Self {
        let takes_part = |f| {
            let mut corners = panels.corners(f);
            let goes_on =
                |c| panels.twin(c).is_some() || panels.ends(c).iter().any(|v| panels.is_image(*v));
            panels.valence(f) == 6 && corners.all(goes_on)
        };
        let takes_part: Vec<bool> = (0..panels.n_faces()).map(takes_part).collect();
        // The edge beyond the one at corner `across`, one before or after its twin.
        let like = |across: usize, beside: fn(&Panels, usize) -> usize| {
            let twin = panels.twin(across)?;
            let [g, f] = [across, twin].map(|c| panels.face_of(c as u32));
            if !(takes_part[g] && takes_part[f]) {
                return None;
            }
            let [a, b] = panels.ends(beside(panels, twin));
            let ratio = areas[g].area / areas[f].area;
            let is_known = ratio.is_finite() && ratio > 0.0;
            let normals = [f, g].map(|f| shape.normal(f));
            Some(LikeEdge {
                ends: [b, a],
                scale: if is_known { ratio.sqrt().sqrt() } else { 1.0 },
                normal: (normals[0] + normals[1]).try_normalize(1e-3)?,
                part: if panels.rests(f) { 1.0 } else { 0.5 },
                middle: None,
            })
        };
        let both = |c: usize| {
            [
                like(panels.next(c), Panels::previous),
                like(panels.previous(c), Panels::next),
            ]
        };
        Self {
            likes: (0..panels.n_corners()).map(both).collect(),
        }
    }

    /// Keeps the middles between edges and their like ones as they are at `x`.
    pub fn freeze(&mut self, panels: &Panels, x: &[f64]) {
        for (c, likes) in self.likes.iter_mut().enumerate() {
            let [from, to] = panels.ends(c).map(|v| point(x, v as usize));
            for like in likes.iter_mut().flatten() {
                like.middle = Some(((to - from) / like.scale + like.vector(x)) * 0.5);
            }
        }
    }

    /// Corners between which an edge of a face runs, its like edge, and what it lacks.
    fn lacks<'a>(
        &'a self,
        panels: &Panels,
        x: &'a [f64],
        face: usize,
        corners: &'a [Corner],
    ) -> impl Iterator<Item = ([usize; 2], &'a LikeEdge, Vec3)> + 'a {
        let likes = self.likes[panels.corners(face)].iter().enumerate();
        likes.flat_map(move |(i, likes)| {
            let j = (i + 1) % corners.len();
            let edge = corners[j].position - corners[i].position;
            let lack = move |like: &'a LikeEdge| ([i, j], like, like.lack(edge, x));
            likes.iter().flatten().map(lack)
        })
    }

    /// Energy of a face.
    pub fn energy(
        &self,
        panels: &Panels,
        x: &[f64],
        face: usize,
        corners: &[Corner],
        weight: f64,
    ) -> f64 {
        let lacks = self.lacks(panels, x, face, corners);
        let squares = lacks.map(|(_, like, lack)| like.part * lack.norm_squared());
        let unlike = LIKENESS * squares.sum::<f64>();
        let skew: f64 = halves(corners)
            .map(|a| skew(corners, a).norm_squared())
            .sum();
        0.5 * weight * (unlike + skew)
    }

    /// Adds gradient and Hessian block of a face.
    pub fn add(
        &self,
        (panels, x): (&Panels, &[f64]),
        face: usize,
        corners: &[Corner],
        weight: f64,
        gradient: &mut [Vec3],
        block: &mut [f64],
    ) {
        for ([i, j], like, lack) in self.lacks(panels, x, face, corners) {
            let weight = LIKENESS * weight;
            let pull = lack * (weight / like.scale);
            gradient[j] += pull;
            gradient[i] -= pull;
            let across = Matrix3::identity() - like.normal * like.normal.transpose();
            // Exact where middles are frozen; elsewhere the like edge is taken as at rest.
            let much = if like.middle.is_some() { 2.0 } else { 1.0 };
            let curved: Matrix3<f64> = across * (much * weight / like.scale.powi(2));
            add_difference(block, [i, j], &curved);
        }
        add_skew(corners, weight, gradient, block);
    }
}

/// Corners of the first half of a panel with an even number of them; none of others.
fn halves(corners: &[Corner]) -> std::ops::Range<usize> {
    match corners.len() % 2 {
        0 => 0..corners.len() / 2,
        _ => 0..0,
    }
}

/// `x_a + x_(a+m) - M`.
fn skew(corners: &[Corner], a: usize) -> Vec3 {
    let m = corners.len() / 2;
    let mean = corners.iter().map(|c| c.position).sum::<Vec3>() / m as f64;
    corners[a].position + corners[a + m].position - mean
}

/// Adds gradient and Hessian block of the central symmetry of a face, both exact.
fn add_skew(corners: &[Corner], weight: f64, gradient: &mut [Vec3], block: &mut [f64]) {
    let m = halves(corners).len();
    if m == 0 {
        return;
    }
    let other = -weight / m as f64;
    for (i, force) in gradient.iter_mut().enumerate() {
        *force += skew(corners, i % m) * weight;
        for j in 0..=i {
            let own = if i % m == j % m { weight } else { 0.0 };
            add_block(block, i, j, &Matrix3::from_diagonal_element(own + other));
        }
    }
}
