//! Areas of faces: what a face pays for being smaller or larger than it is to be.
//!
//! Energy `w/2 (a - A)^2 / a` for a face of area `A = n . sum x_i x x_(i+1) / 2` that is to have
//! `a`; its plane turns as in [`super::barrier`]. The Hessian is the Gauss-Newton part in the fixed
//! plane. Without it nothing holds areas, and panels slide along the surface until the largest
//! inner ones have three times the area of the smallest.
//!
//! Faces at the boundary are cut by it and wish for no area, unless they are to grow.

use super::barrier::add_turning;
use super::panels::{Corner, FaceFrame, FaceShapes, Panels, add_block};
use super::simple::area;
use crate::layout::{Layout, WishedArea};
use phex_mesh::{Topology, Vec2, Vec3};

/// What a face is to have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct AreaWish {
    /// Area, in the square of the mesh's unit.
    pub area: f64,
    /// Weight; 0 where any area will do.
    pub weight: f64,
}

impl AreaWish {
    /// What the face lacks; negative where it has too much, 0 where it wants nothing.
    fn lacking(&self, corners: &[Corner]) -> f64 {
        if self.weight == 0.0 {
            return 0.0;
        }
        self.area - area(corners)
    }

    /// Energy of a face.
    pub fn energy(&self, corners: &[Corner]) -> f64 {
        match self.lacking(corners) {
            0.0 => 0.0,
            lacking => 0.5 * self.weight * lacking * lacking / self.area,
        }
    }

    /// Adds gradient and Hessian block of a face.
    pub fn add(
        &self,
        frame: &FaceFrame,
        corners: &[Corner],
        gradient: &mut [Vec3],
        block: &mut [f64],
    ) {
        let lacking = self.lacking(corners);
        if lacking == 0.0 {
            return;
        }
        let (force, curved) = (-self.weight * lacking / self.area, self.weight / self.area);
        let rows = rows(frame, corners);
        for (i, row) in rows.iter().enumerate() {
            gradient[i] += row * force;
            for (j, other) in rows[..=i].iter().enumerate() {
                add_block(block, i, j, &(row * other.transpose() * curved));
            }
        }
        add_turning(frame, corners, tilt(corners) * force, gradient);
    }
}

/// No wishes.
pub(super) fn any(faces: usize) -> Vec<AreaWish> {
    vec![AreaWish::default(); faces]
}

/// Wishes of the inner faces of a layout that lies at `x`: in the proportions that it asks for, and
/// as much in all as they have.
pub(super) fn of_layout(layout: &Layout, panels: &Panels, x: &[f64], weight: f64) -> Vec<AreaWish> {
    let topology = layout.mesh.topology();
    let shape = FaceShapes::at(panels, x);
    let inner = |f: &usize| is_inner(topology, *f) && layout.face_wish.as_slice()[*f].share > 0.0;
    let wish = |f: usize| layout.face_wish.as_slice()[f];
    let faces = || (0..panels.n_faces()).filter(inner);
    let has: f64 = faces().map(|f| area(shape.face(panels, f)).abs()).sum();
    let scale = has / faces().map(|f| wish(f).area).sum::<f64>();
    let mut wishes = any(panels.n_faces());
    for f in faces() {
        let WishedArea { area, share } = wish(f);
        wishes[f] = AreaWish {
            area: scale * area,
            weight: weight * share,
        };
    }
    wishes
}

/// Wishes of the inner faces of a mesh to keep the areas that they have at `x`.
pub(super) fn as_they_are(
    topology: &Topology,
    panels: &Panels,
    x: &[f64],
    weight: f64,
) -> Vec<AreaWish> {
    let shape = FaceShapes::at(panels, x);
    let wish = |f: usize| match area(shape.face(panels, f)) {
        area if area > 0.0 && is_inner(topology, f) => AreaWish { area, weight },
        _ => AreaWish::default(),
    };
    (0..panels.n_faces()).map(wish).collect()
}

fn is_inner(topology: &Topology, f: usize) -> bool {
    !topology.is_boundary_face(phex_mesh::FaceId::new(f as u32))
}

/// Derivatives of the area by the corners, in the plane.
fn rows(frame: &FaceFrame, corners: &[Corner]) -> Vec<Vec3> {
    let (k, axes) = (corners.len(), frame.plane.axes);
    let row = |i: usize| {
        let across = corners[(i + 1) % k].flat - corners[(i + k - 1) % k].flat;
        (axes[0] * across.y - axes[1] * across.x) * 0.5
    };
    (0..k).map(row).collect()
}

/// Derivative of the area by the plane's normal, along the axes.
fn tilt(corners: &[Corner]) -> Vec2 {
    let k = corners.len();
    let of_side = |i: usize| {
        let [a, b] = [&corners[i], &corners[(i + 1) % k]];
        Vec2::new(
            a.flat.y * b.height - a.height * b.flat.y,
            a.height * b.flat.x - a.flat.x * b.height,
        )
    };
    (0..k).map(of_side).sum::<Vec2>() * 0.5
}
