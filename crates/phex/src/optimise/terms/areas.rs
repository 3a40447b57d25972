//! Areas of faces: what a face pays for being smaller or larger than it is to be.
//!
//! Energy `w/2 (a - A)^2 / a` for a face of area `A = n . sum x_i x x_(i+1) / 2` that is to have
//! `a`; its plane turns as in [`super::barrier`]. The Hessian is the Gauss-Newton part in the fixed
//! plane. Without it nothing holds areas, and panels slide along the surface until the largest
//! inner ones have three times the area of the smallest.
//!
//! Faces at the boundary, which cuts the lattice anywhere, want the same area as the others with
//! less weight: what the lattice has too much or too little there is shared by the rows behind.

use super::barrier::add_turning;
use crate::layout::{Layout, PanelWish};
use crate::optimise::panels::{Corner, FaceFrame, FaceShapes, Panels, add_outer};
use crate::optimise::simple::area;
use phex_mesh::{Topology, Vec2, Vec3};

/// What a face is to have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::optimise) struct AreaWish {
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
        let pulls = gradient.iter_mut().zip(&rows);
        pulls.for_each(|(g, row)| *g += row * force);
        add_outer(block, &rows, curved);
        add_turning(frame, corners, tilt(corners) * force, gradient);
    }
}

/// Weight of the area of a face at the boundary over that of an inner one. Without it the largest
/// of them have three times the mean area; with 1 the rows behind give way too far.
const RIM_SHARE: f64 = 0.3;

/// No wishes.
pub(in crate::optimise) fn any(faces: usize) -> Vec<AreaWish> {
    vec![AreaWish::default(); faces]
}

/// Wishes of the faces of a layout that lies at `x`: in the proportions that it asks for, and as
/// much in all as they have.
pub(in crate::optimise) fn of_layout(
    layout: &Layout,
    panels: &Panels,
    x: &[f64],
    weight: f64,
) -> Vec<AreaWish> {
    let topology = layout.mesh.topology();
    let shape = FaceShapes::at(panels, x);
    let wish = |f: usize| layout.face_wish.as_slice()[f];
    let faces = || (0..panels.n_faces()).filter(|f| wish(*f).share > 0.0);
    let has: f64 = faces().map(|f| area(shape.face(panels, f)).abs()).sum();
    let scale = has / faces().map(|f| wish(f).area).sum::<f64>();
    let mut wishes = any(panels.n_faces());
    for f in faces() {
        let PanelWish { area, share, .. } = wish(f);
        wishes[f] = AreaWish {
            area: scale * area,
            weight: weight * share * share_of(topology, f),
        };
    }
    wishes
}

/// Wishes of the faces of a mesh to keep the areas that they have at `x`.
pub(in crate::optimise) fn as_they_are(
    topology: &Topology,
    panels: &Panels,
    x: &[f64],
    weight: f64,
) -> Vec<AreaWish> {
    let shape = FaceShapes::at(panels, x);
    let wish = |f: usize| match area(shape.face(panels, f)) {
        area if area > 0.0 => AreaWish {
            area,
            weight: weight * share_of(topology, f),
        },
        _ => AreaWish::default(),
    };
    (0..panels.n_faces()).map(wish).collect()
}

/// How much the area of a face counts where it lies.
fn share_of(topology: &Topology, f: usize) -> f64 {
    match topology.is_boundary_face(phex_mesh::FaceId::new(f as u32)) {
        true => RIM_SHARE,
        false => 1.0,
    }
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
