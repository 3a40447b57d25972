//! What a designer asks of rows and cones: lines that rows run along, and places of cones.

use crate::curvature::Principal;
use phex_mesh::{PerVertex, TriangleSurface, Vec3};
use serde::{Deserialize, Serialize};

/// A prescribed cone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cone {
    /// Where, in the coordinates of the surface; the nearest place on it counts.
    pub position: [f64; 3],
    /// Index in sixths of a turn: 1 makes a pentagon, -1 a heptagon.
    pub index: i32,
}

impl Cone {
    /// The same in other coordinates.
    pub(crate) fn moved(&self, f: impl Fn(Vec3) -> Vec3) -> Self {
        Self {
            position: f(self.position.into()).into(),
            ..*self
        }
    }
}

/// Lines and cones, in the coordinates of the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Guides {
    /// Polylines that rows of panels run along.
    pub lines: Vec<Vec<[f64; 3]>>,
    /// Dihedral angle, degrees, from which on an edge of the given surface is a crease that rows
    /// run along (`None`: no edge is).
    pub crease: Option<f64>,
    /// The cones of the field; empty: where the surface wants them.
    pub cones: Vec<Cone>,
}

/// Weight of the alignment with a line, in that of the compulsory alignment near parabolic curves.
const STRENGTH: f64 = 4.0;
/// Distance, in mean edges of the surface, of the points that lines are sampled at.
const STEP: f64 = 0.5;

impl Guides {
    /// Cones alone.
    pub fn of_cones(cones: Vec<Cone>) -> Self {
        Self {
            cones,
            ..Self::default()
        }
    }

    /// The same in other coordinates.
    pub fn moved(&self, f: impl Fn(Vec3) -> Vec3) -> Self {
        let place = |p: &[f64; 3]| f(Vec3::from(*p)).into();
        let line = |line: &Vec<[f64; 3]>| line.iter().map(place).collect();
        Self {
            lines: self.lines.iter().map(line).collect(),
            crease: self.crease,
            cones: self.cones.iter().map(|cone| cone.moved(&f)).collect(),
        }
    }

    /// The same, with the creases of a surface as lines.
    pub fn with_creases(&self, surface: &TriangleSurface) -> Self {
        let mut guides = self.clone();
        if let Some(degrees) = self.crease {
            guides.lines.extend(creases(surface, degrees.to_radians()));
        }
        guides
    }

    /// Lets rows follow the lines: at the vertices beside them the direction along the line takes
    /// the place of that of the smaller curvature, and the alignment becomes strong.
    pub fn align(
        &self,
        surface: &TriangleSurface,
        principal: &mut PerVertex<Principal>,
        weight: &mut PerVertex<f64>,
        alignment: f64,
    ) {
        let (points, tangents) = self.samples(STEP * surface.mean_edge());
        let feet = surface.closest_points(&points);
        let mut sum = PerVertex::filled(principal.len(), Vec3::zeros());
        for (foot, tangent) in feet.iter().zip(&tangents) {
            for &v in surface.topology().face_vertices(foot.triangle) {
                let n = surface.normals()[v];
                let along = tangent - n * n.dot(tangent);
                // A line has no sense: whichever agrees with what is there already.
                let against = sum[v].dot(&along) < 0.0;
                sum[v] += if against { -along } else { along };
            }
        }
        for (v, along) in sum.enumerate().filter(|(_, s)| s.norm() > 1e-9) {
            let along = along.normalize();
            principal[v].small_direction = along;
            principal[v].large_direction = surface.normals()[v].cross(&along);
            weight[v] = STRENGTH * alignment;
        }
    }

    /// Points along the lines at most `step` apart, with unit tangents.
    fn samples(&self, step: f64) -> (Vec<Vec3>, Vec<Vec3>) {
        let (mut points, mut tangents) = (Vec::new(), Vec::new());
        for ends in self.lines.iter().flat_map(|l| l.windows(2)) {
            let [start, end] = [ends[0], ends[1]].map(Vec3::from);
            let d = end - start;
            let Some(tangent) = d.try_normalize(1e-12) else {
                continue;
            };
            let count = (d.norm() / step).ceil().clamp(1.0, 1e5) as usize;
            for k in 0..=count {
                points.push(start + d * (k as f64 / count as f64));
                tangents.push(tangent);
            }
        }
        (points, tangents)
    }
}

/// Edges across which the normals of a surface's triangles differ by more than `angle` (radians),
/// as lines.
fn creases(surface: &TriangleSurface, angle: f64) -> Vec<Vec<[f64; 3]>> {
    let topology = surface.topology();
    let mut lines = Vec::new();
    for e in topology.edges() {
        let Some(beside) = topology.faces_beside(e) else {
            continue;
        };
        let [a, b] = beside.map(|f| surface.area_vector(f));
        if a.angle(&b) > angle {
            let ends = topology
                .edge_vertices(e)
                .map(|v| surface.positions()[v].into());
            lines.push(ends.to_vec());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that meet at a right angle in the edge from the origin along y.
    fn roof() -> TriangleSurface {
        let positions = [
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [-1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 1.0, -1.0],
        ];
        let triangles = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        TriangleSurface::new(positions.map(Vec3::from).to_vec(), &triangles).unwrap()
    }

    #[test]
    fn the_ridge_of_a_roof_is_a_crease() {
        let guides = Guides {
            crease: Some(30.0),
            ..Default::default()
        };
        let lines = guides.with_creases(&roof()).lines;
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|p| p[0] == 0.0 && p[2] == 0.0));
        let blunt = Guides {
            crease: Some(91.0),
            ..Default::default()
        };
        assert!(blunt.with_creases(&roof()).lines.is_empty());
    }

    #[test]
    fn lines_are_sampled_with_tangents_of_unit_length() {
        let guides = Guides {
            lines: vec![vec![[0.0; 3], [3.0, 0.0, 4.0], [3.0, 0.0, 4.0]]],
            ..Default::default()
        };
        let (points, tangents) = guides.samples(1.0);
        assert_eq!(points.len(), 6);
        assert!(
            tangents
                .iter()
                .all(|t| (t - Vec3::new(0.6, 0.0, 0.8)).norm() < 1e-12)
        );
        assert!((points[5] - Vec3::new(3.0, 0.0, 4.0)).norm() < 1e-12);
    }
}
