//! Thick panels, and each of them laid flat.
//!
//! A panel is seen from outside, its upper face (on the side of the normals) towards the viewer.
//! Its frame has y along the steepest direction upwards in its plane (global y where the panel is
//! level), so that text along x is upright on the building.

use crate::outline;
use phex::offset::PanelSolid;
use phex_mesh::polygon::{interior_angles, sides, signed_area};
use phex_mesh::{EdgeId, FaceId, FacePlane, HexMesh, Vec2, Vec3};

/// Cosine of the slope below which a panel counts as level.
const LEVEL: f64 = 1e-6;

/// A panel laid flat, in millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// Its face.
    pub face: FaceId,
    /// Corners of the upper face, counter-clockwise.
    pub top: Vec<Vec2>,
    /// Corners of the lower face in the same order, seen through the panel.
    pub bottom: Vec<Vec2>,
    /// The smallest simple polygon of the same sides that holds both.
    pub outline: Vec<Vec2>,
    /// Its sides; side `i` goes from corner `i` to the next.
    pub sides: Vec<PlateSide>,
    /// Distance of the two faces.
    pub thickness: f64,
}

/// One side of a panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateSide {
    /// The mesh's edge.
    pub edge: EdgeId,
    /// The panel on the other side.
    pub neighbour: Option<FaceId>,
    /// How far the saw is tilted from the perpendicular, in radians; positive where the lower face
    /// is smaller there.
    pub mitre: f64,
}

impl Plate {
    /// Lays a solid flat. `mesh` is the mesh that the solids were made from, `millimetres` those of
    /// a model unit.
    pub fn new(mesh: &HexMesh, solid: &PanelSolid, millimetres: f64) -> Self {
        let frame = PlateFrame::of(&solid.top);
        let flat = |corners: &[Vec3]| -> Vec<Vec2> {
            corners
                .iter()
                .map(|&p| frame.project(p) * millimetres)
                .collect()
        };
        let (top, bottom) = (flat(&solid.top), flat(&solid.bottom));
        let depth = |p: &Vec3| (frame.origin - p).dot(&frame.normal);
        let thickness =
            millimetres * solid.bottom.iter().map(depth).sum::<f64>() / solid.bottom.len() as f64;
        let shifts = shifts(&top, &bottom);
        let topology = mesh.topology();
        let side = |(h, shift): (_, &[f64; 2])| PlateSide {
            edge: topology.edge(h),
            neighbour: topology.across(h),
            mitre: f64::atan2(-0.5 * (shift[0] + shift[1]), thickness),
        };
        let sides = topology
            .face_half_edges(solid.face)
            .zip(&shifts)
            .map(side)
            .collect();
        let wider: Vec<f64> = shifts.iter().map(|s| s[0].max(s[1]).max(0.0)).collect();
        Self {
            face: solid.face,
            outline: outline::enclosing(&top, &bottom, &wider),
            top,
            bottom,
            sides,
            thickness,
        }
    }

    /// Area of the upper face, in mm².
    pub fn area(&self) -> f64 {
        signed_area(&self.top)
    }

    /// How far the lower face reaches beyond the sides of the upper one, in mm, or 0.
    pub fn beyond(&self) -> f64 {
        let shifts = shifts(&self.top, &self.bottom);
        shifts.into_iter().flatten().fold(0.0, f64::max)
    }

    /// Lengths of the upper face's sides, in mm.
    pub fn lengths(&self) -> Vec<f64> {
        sides(&self.top).map(|[a, b]| (b - a).norm()).collect()
    }

    /// Angles of the upper face, in radians.
    pub fn angles(&self) -> Vec<f64> {
        interior_angles(&self.top).collect()
    }
}

/// How far the lower face reaches beyond each side of the upper one, at the side's two ends.
fn shifts(top: &[Vec2], bottom: &[Vec2]) -> Vec<[f64; 2]> {
    let ends = sides(top).zip(sides(bottom));
    ends.map(|([a, b], low)| {
        let out = outline::outward(a, b);
        low.map(|p| (p - a).dot(&out))
    })
    .collect()
}

/// Origin, axes and normal of a panel's plane.
struct PlateFrame {
    origin: Vec3,
    axes: [Vec3; 2],
    normal: Vec3,
}

impl PlateFrame {
    fn of(corners: &[Vec3]) -> Self {
        let FacePlane { centre, normal, .. } = FacePlane::fit(corners);
        let along = |d: Vec3| d - normal * d.dot(&normal);
        let steepest = along(Vec3::z());
        let up = if steepest.norm() > LEVEL {
            steepest
        } else {
            along(Vec3::y())
        };
        let y = up.normalize();
        Self {
            origin: centre,
            axes: [y.cross(&normal), y],
            normal,
        }
    }

    fn project(&self, p: Vec3) -> Vec2 {
        let d = p - self.origin;
        Vec2::new(d.dot(&self.axes[0]), d.dot(&self.axes[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lower_face_reaches_beyond_by_its_farthest_side() {
        let rectangle = |x: f64, y: f64| {
            [[-x, -y], [x, -y], [x, y], [-x, y]]
                .map(|[x, y]| Vec2::new(x, y))
                .to_vec()
        };
        let plate = |bottom: Vec<Vec2>| Plate {
            face: FaceId::new(0),
            top: rectangle(10.0, 10.0),
            outline: bottom.clone(),
            bottom,
            sides: Vec::new(),
            thickness: 5.0,
        };
        assert_eq!(plate(rectangle(12.0, 7.0)).beyond(), 2.0);
        assert_eq!(plate(rectangle(8.0, 7.0)).beyond(), 0.0);
    }
}
