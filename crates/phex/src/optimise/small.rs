//! Small panels at the boundary: what they pay for area that they lack.
//!
//! Penalty `w/2 max(0, a - A)^2 / a` for a face of area `A = n . sum x_i x x_(i+1) / 2` that is to have `a`; its plane turns as in
//! [`super::barrier`]. The Hessian is the Gauss-Newton part in the fixed plane.

use super::barrier::add_turning;
use super::panels::{Corner, FaceFrame, add_block};
use super::simple::area;
use phex_mesh::{Vec2, Vec3};

/// The penalty of all faces that are to have an area.
pub(super) struct AreaTerm {
    pub weight: f64,
    /// Area of each face, 0 for any.
    pub wanted: Vec<f64>,
}

impl AreaTerm {
    /// Energy of a face.
    pub fn energy(&self, f: usize, corners: &[Corner]) -> f64 {
        let wanted = self.wanted[f];
        let lacking = (wanted - area(corners)).max(0.0);
        if lacking == 0.0 {
            return 0.0;
        }
        0.5 * self.weight * lacking * lacking / wanted
    }

    /// Adds gradient and Hessian block of a face.
    pub fn add(
        &self,
        f: usize,
        frame: &FaceFrame,
        corners: &[Corner],
        gradient: &mut [Vec3],
        block: &mut [f64],
    ) {
        let wanted = self.wanted[f];
        let lacking = (wanted - area(corners)).max(0.0);
        if lacking == 0.0 {
            return;
        }
        let (force, curved) = (-self.weight * lacking / wanted, self.weight / wanted);
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
