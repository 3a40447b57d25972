//! Vertices that are held: at a point, in a plane, on a curve, or softly by an anchor of their own.
//!
//! A held vertex moves only within the tangent space `T` of what holds it: gradients become `T g`,
//! Hessians `T H T + (I - T)`, constraint rows `J T`, so steps never leave that space; a point
//! after a step is brought back exactly.
//!
//! | held | `T` |
//! |---|---|
//! | at a point | `0` |
//! | on a line | `d d^T` |
//! | in a plane | `I - n n^T` |
//! | on a curve, or the boundary | `t t^T` |

use super::images;
use super::panels::{Image, Panels, add_block, point, put};
use nalgebra::Matrix3;
use phex_mesh::{BoundaryCurve, Vec3};
use phex_numeric::Assembly;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// What holds a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Hold {
    /// It does not move.
    At(Vec3),
    /// It stays on the line through a point with a unit direction.
    OnLine { point: Vec3, direction: Vec3 },
    /// It stays in the plane through a point with a unit normal.
    InPlane { point: Vec3, normal: Vec3 },
    /// It slides on the curves.
    OnCurve,
    /// It slides on the boundary of the surface.
    OnRim,
}

/// A pull of a vertex towards a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Anchored {
    pub point: Vec3,
    /// Over the weight of the closeness of vertices.
    pub weight: f64,
}

/// All held vertices of a mesh.
#[derive(Clone, Default)]
pub(super) struct Holds {
    pub held: BTreeMap<u32, Hold>,
    pub anchors: BTreeMap<u32, Anchored>,
    pub curves: Option<BoundaryCurve>,
    pub rim: Option<BoundaryCurve>,
    /// Vertices that are images of others; they go where these go.
    pub images: BTreeMap<u32, Image>,
}

impl Holds {
    /// Whether a vertex does not move at all.
    pub(crate) fn fixes(&self, vertex: u32) -> bool {
        matches!(self.held.get(&vertex), Some(Hold::At(_)))
    }

    /// Lets vertices go that slide on lines, curves or in planes.
    pub fn release(&mut self, loose: &BTreeSet<u32>) {
        let slides = |hold: &Hold| !matches!(hold, Hold::At(_));
        self.held
            .retain(|v, hold| !(loose.contains(v) && slides(hold)));
    }

    /// The held vertices, in order, with the tangent spaces `T` at `x`.
    pub(crate) fn freedoms<'a>(
        &'a self,
        x: &'a [f64],
    ) -> impl Iterator<Item = (u32, Matrix3<f64>)> + 'a {
        let freedom = |(&v, hold): (&u32, &Hold)| (v, self.freedom(hold, point(x, v as usize)));
        self.held.iter().map(freedom)
    }

    fn freedom(&self, hold: &Hold, p: Vec3) -> Matrix3<f64> {
        match hold {
            Hold::At(_) => Matrix3::zeros(),
            Hold::OnLine { direction, .. } => direction * direction.transpose(),
            Hold::InPlane { normal, .. } => Matrix3::identity() - normal * normal.transpose(),
            Hold::OnCurve => along(self.curves.as_ref(), p),
            Hold::OnRim => along(self.rim.as_ref(), p),
        }
    }

    /// What holds those vertices that have other numbers in a part of the mesh.
    pub fn part(&self, local: impl Fn(&u32) -> Option<u32>) -> Self {
        let held = self.held.iter().filter_map(|(v, h)| Some((local(v)?, *h)));
        let anchors = self.anchors.iter();
        Self {
            held: held.collect(),
            anchors: anchors.filter_map(|(v, a)| Some((local(v)?, *a))).collect(),
            curves: self.curves.clone(),
            rim: self.rim.clone(),
            images: (self.images.iter())
                .filter_map(|(v, i)| {
                    let (v, source) = (local(v)?, local(&i.source)?);
                    Some((v, Image { source, ..*i }))
                })
                .collect(),
        }
    }

    /// Where a vertex at `p` is brought to.
    fn place(&self, hold: &Hold, p: Vec3) -> Vec3 {
        match hold {
            Hold::At(q) => *q,
            Hold::OnLine { point, direction } => point + direction * direction.dot(&(p - point)),
            Hold::InPlane { point, normal } => in_plane(p, *point, *normal),
            Hold::OnCurve => on(self.curves.as_ref(), p),
            Hold::OnRim => on(self.rim.as_ref(), p),
        }
    }

    /// Places of the held vertices, in order, for those that are at `x`.
    pub fn places<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = (u32, Vec3)> + 'a {
        let place = |(&v, hold): (&u32, &Hold)| (v, self.place(hold, point(x, v as usize)));
        self.held.iter().map(place)
    }

    /// Brings every held vertex back.
    pub fn retract(&self, x: &mut [f64]) {
        for (&v, hold) in &self.held {
            let place = self.place(hold, point(x, v as usize));
            put(x, v as usize, &place);
        }
        images::retract(&self.images, x);
    }

    /// A step with the images taken along.
    pub(crate) fn whole_step<'a>(&self, step: &'a [f64]) -> Cow<'a, [f64]> {
        let mut step = Cow::Borrowed(step);
        if !self.images.is_empty() {
            images::retract(&self.images, step.to_mut());
        }
        step
    }

    /// Takes the directions in which held vertices can't move out of a gradient and the blocks of a
    /// Hessian, one for every face and then one for every vertex; `weight` stands in their place.
    pub(crate) fn restrict(
        &self,
        panels: &Panels,
        assembly: &Assembly,
        weight: f64,
        x: &[f64],
        gradient: &mut [f64],
        blocks: &mut [f64],
    ) {
        images::fold(&self.images, panels, assembly, weight, gradient, blocks);
        for (v, freedom) in self.freedoms(x) {
            let v = v as usize;
            let g = freedom * point(gradient, v);
            put(gradient, v, &g);
            for &c in panels.corners_at(v) {
                let f = panels.face_of(c);
                if panels.rests(f) {
                    continue;
                }
                let i = c as usize - panels.corners(f).start;
                let block = &mut blocks[assembly.block(f)];
                restrict_block(block, i, panels.valence(f), &freedom);
            }
            let block = &mut blocks[assembly.block(panels.n_faces() + v)];
            restrict_block(block, 0, 1, &freedom);
            add_block(block, 0, 0, &((Matrix3::identity() - freedom) * weight));
        }
    }
}

/// The tangent space of curves at their point closest to `p`.
fn along(curves: Option<&BoundaryCurve>, p: Vec3) -> Matrix3<f64> {
    curves.map_or_else(Matrix3::identity, |c| {
        let tangent = c.closest_point(p).tangent;
        tangent * tangent.transpose()
    })
}

fn on(curves: Option<&BoundaryCurve>, p: Vec3) -> Vec3 {
    curves.map_or(p, |c| c.closest_point(p).position)
}

/// Diagonals within which a vertex lies in a plane, or at a place, that it was put in.
pub(crate) const PUT_THERE: f64 = 1e-9;

/// The closest point of a plane; exact in the coordinate of an axis-parallel normal.
pub(crate) fn in_plane(p: Vec3, point: Vec3, normal: Vec3) -> Vec3 {
    match normal.iter().position(|c| c.abs() == 1.0) {
        Some(axis) => {
            let mut q = p;
            q[axis] = point[axis];
            q
        }
        None => p - normal * normal.dot(&(p - point)),
    }
}

/// `T B` on the rows of corner `i` of a face's packed block, and `B T` on its columns, for a face
/// of `k` corners.
fn restrict_block(block: &mut [f64], i: usize, k: usize, freedom: &Matrix3<f64>) {
    let entry = |r: usize, c: usize| phex_numeric::assembly::packed(r.max(c), r.min(c));
    for j in 0..k {
        let mut part = Matrix3::from_fn(|a, b| block[entry(3 * i + a, 3 * j + b)]);
        part = freedom * part;
        if i == j {
            part *= freedom;
        }
        for a in 0..3 {
            for b in 0..3 {
                block[entry(3 * i + a, 3 * j + b)] = part[(a, b)];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_keep_their_vertices_to_the_last_bit_along_an_axis() {
        let ground = Vec3::new(0.1, 0.2, 0.1 + 0.2);
        let p = in_plane(Vec3::new(3.3, -0.7, 9.1), ground, Vec3::z());
        assert_eq!(p, Vec3::new(3.3, -0.7, 0.1 + 0.2));
        let normal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let q = in_plane(p, ground, normal);
        assert!(normal.dot(&(q - ground)).abs() < 1e-15);
        assert!(normal.cross(&(q - p)).norm() < 1e-15);
    }

    #[test]
    fn a_restricted_block_is_the_product_with_the_tangent_spaces() {
        let (k, held) = (3, 1);
        let n = 3 * k;
        let full = nalgebra::DMatrix::from_fn(n, n, |r, c| ((r * c + r + c) as f64).sin());
        let mut block = vec![0.0; n * (n + 1) / 2];
        for r in 0..n {
            for c in 0..=r {
                block[phex_numeric::assembly::packed(r, c)] = full[(r, c)];
            }
        }
        let normal = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        let freedom = Matrix3::identity() - normal * normal.transpose();
        restrict_block(&mut block, held, k, &freedom);
        let mut t = nalgebra::DMatrix::identity(n, n);
        t.view_mut((3 * held, 3 * held), (3, 3)).copy_from(&freedom);
        let expected = &t * full * &t;
        for r in 0..n {
            for c in 0..=r {
                let found = block[phex_numeric::assembly::packed(r, c)];
                assert!((found - expected[(r, c)]).abs() < 1e-14);
            }
        }
    }
}
