//! Panels with a hole of the surface inside: parted by a cut through the hole.
//!
//! A panel is a polygon, so a hole that no edge crosses can't be clipped out of it. A straight cut
//! in the panel's plane through the middle of the hole, from edge to edge, makes two planar panels
//! of it, and the new edge crosses the hole. Where the cut ends, the neighbour gets a vertex on its
//! edge: three panels meet there, as everywhere.

use super::follow::is_simple;
use super::{Domain, TrimError, Trimmed, compact};
use phex_mesh::{FaceId, FacePlane, HexMesh, PerFace, Vec2, Vec3, polygon};

/// Directions of cuts that are tried.
const DIRECTIONS: usize = 24;
/// Share of an edge, at each end, in which no cut ends.
const MARGIN: f64 = 0.15;

/// Parts panels until no hole lies within one.
pub(super) fn parted(mesh: &HexMesh, domain: &Domain<'_>) -> Result<Trimmed, TrimError> {
    let mut parting = Parting {
        positions: mesh.positions.as_slice().to_vec(),
        faces: mesh.topology().face_lists(),
        parent: mesh.topology().faces().collect(),
    };
    let place = |v: &_| domain.original.positions()[*v];
    let mut any = false;
    for hole in domain.original.boundary_loops() {
        let hole: Vec<Vec3> = hole.iter().map(place).collect();
        any |= parting.part_round(&hole);
    }
    Ok(Trimmed {
        mesh: match any {
            true => compact(&parting.positions, &parting.faces)?,
            false => mesh.clone(),
        },
        parent: PerFace::from_vec(parting.parent),
    })
}

/// Where a cut meets an outline: the edge after a corner, and how far along it.
#[derive(Clone, Copy)]
struct End {
    corner: usize,
    along: f64,
    distance: f64,
}

struct Parting {
    positions: Vec<Vec3>,
    faces: Vec<Vec<u32>>,
    parent: Vec<FaceId>,
}

impl Parting {
    /// Parts the panel that holds all of a hole, if there is one; whether that was done.
    fn part_round(&mut self, hole: &[Vec3]) -> bool {
        let Some((f, plane)) = self.holder(hole) else {
            return false;
        };
        let outline = self.outline(f, &plane);
        let points: Vec<Vec2> = hole.iter().map(|p| plane.project(*p)).collect();
        let middle = points.iter().sum::<Vec2>() / points.len() as f64;
        let cuts = (0..DIRECTIONS).filter_map(|k| {
            let (s, c) = (std::f64::consts::PI * k as f64 / DIRECTIONS as f64).sin_cos();
            let way = Vec2::new(c, s);
            Some([
                ahead(&outline, middle, way)?,
                ahead(&outline, middle, -way)?,
            ])
        });
        let length = |cut: &[End; 2]| cut[0].distance + cut[1].distance;
        let mut cuts: Vec<[End; 2]> = cuts.filter(|c| c[0].corner != c[1].corner).collect();
        cuts.sort_by(|a, b| length(a).total_cmp(&length(b)));
        cuts.into_iter().any(|cut| self.cut(f, cut, &plane))
    }

    fn outline(&self, f: usize, plane: &FacePlane) -> Vec<Vec2> {
        let place = |v: &u32| plane.project(self.positions[*v as usize]);
        self.faces[f].iter().map(place).collect()
    }

    /// The panel, with its plane, that a hole lies in and does not leave.
    fn holder(&self, hole: &[Vec3]) -> Option<(usize, FacePlane)> {
        let middle = hole.iter().sum::<Vec3>() / hole.len() as f64;
        let holds = |f: usize| {
            let corners: Vec<Vec3> = self.faces[f]
                .iter()
                .map(|v| self.positions[*v as usize])
                .collect();
            let centre = corners.iter().sum::<Vec3>() / corners.len() as f64;
            let radius = corners.iter().map(|p| (p - centre).norm());
            if (middle - centre).norm() > radius.fold(0.0, f64::max) {
                return None;
            }
            let plane = FacePlane::fit(&corners);
            let outline: Vec<Vec2> = corners.iter().map(|p| plane.project(*p)).collect();
            let inside = hole
                .iter()
                .all(|p| polygon::contains(&outline, plane.project(*p)));
            inside.then_some((plane.height(middle).abs(), f, plane))
        };
        let holders = (0..self.faces.len()).filter_map(holds);
        let nearest = holders.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        nearest.map(|(_, f, plane)| (f, plane))
    }

    /// Cuts a panel in two, where both parts are simple.
    fn cut(&mut self, f: usize, ends: [End; 2], plane: &FacePlane) -> bool {
        let face = self.faces[f].clone();
        let n = face.len();
        let corner = |i: usize| face[i % n];
        let at = |e: &End| {
            let (a, b) = (corner(e.corner), corner(e.corner + 1));
            let [p, q] = [a, b].map(|v| self.positions[v as usize]);
            p + (q - p) * e.along
        };
        let places = ends.map(|e| at(&e));
        let first = self.positions.len() as u32;
        let new = [first, first + 1];
        let half = |from: usize, to: usize| {
            let count = (ends[to].corner + n - ends[from].corner) % n;
            let own = (1..=count).map(|k| corner(ends[from].corner + k));
            let around = std::iter::once(new[from]).chain(own);
            around.chain([new[to]]).collect::<Vec<u32>>()
        };
        let halves = [half(0, 1), half(1, 0)];
        self.positions.extend(places);
        let simple = |h: &Vec<u32>| is_simple(h, &self.positions, plane);
        if !halves.iter().all(simple) {
            self.positions.truncate(first as usize);
            return false;
        }
        for (end, v) in ends.iter().zip(new) {
            let (a, b) = (corner(end.corner), corner(end.corner + 1));
            self.insert_between(b, a, v);
        }
        let [one, other] = halves;
        self.faces[f] = one;
        self.faces.push(other);
        self.parent.push(self.parent[f]);
        true
    }

    /// Puts a vertex on the edge from `a` to `b` of the face that has it.
    fn insert_between(&mut self, a: u32, b: u32, v: u32) {
        for face in &mut self.faces {
            let n = face.len();
            if let Some(i) = (0..n).find(|&i| face[i] == a && face[(i + 1) % n] == b) {
                face.insert(i + 1, v);
                return;
            }
        }
    }
}

/// The nearest place on an outline from `from` in a direction, if it is not close to a corner.
fn ahead(outline: &[Vec2], from: Vec2, way: Vec2) -> Option<End> {
    let n = outline.len();
    let hit = |corner: usize| {
        let (a, b) = (outline[corner], outline[(corner + 1) % n]);
        let side = b - a;
        let across = way.perp(&side);
        let along = (a - from).perp(&way) / across;
        let distance = (a - from).perp(&side) / across;
        let meets = (0.0..=1.0).contains(&along) && distance > 0.0;
        meets.then_some(End {
            corner,
            along,
            distance,
        })
    };
    let nearest = (0..n)
        .filter_map(hit)
        .min_by(|a, b| a.distance.total_cmp(&b.distance));
    nearest.filter(|e| (MARGIN..=1.0 - MARGIN).contains(&e.along))
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::domain;
    use super::*;
    use crate::smooth_surface::extend;
    use crate::trim::{Boundary, trim};
    use phex_mesh::{FlatFace, TriangleSurface, measure};

    /// A square of side 3 without the square from 1.25 to 1.75.
    fn square() -> TriangleSurface {
        let n = 12;
        let at = |v: u32| Vec3::new(f64::from(v % (n + 1)), f64::from(v / (n + 1)), 0.0) * 0.25;
        let within = |c: &u32| !((5..7).contains(&(c % n)) && (5..7).contains(&(c / n)));
        let cells = (0..n * n).filter(within).map(|c| c % n + (c / n) * (n + 1));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]])
            .collect();
        // The vertex in the middle of the hole belongs to no triangle.
        let middle = 6 * (n + 1) + 6;
        let renumbered = |t: [u32; 3]| t.map(|v| if v > middle { v - 1 } else { v });
        let triangles: Vec<[u32; 3]> = triangles.into_iter().map(renumbered).collect();
        let positions = (0..(n + 1) * (n + 1)).filter(|v| *v != middle).map(at);
        TriangleSurface::new(positions.collect(), &triangles).unwrap()
    }

    #[test]
    fn a_hole_within_a_panel_is_cut_out_of_two() {
        let original = square();
        let extension = extend::extend(&original, 0.0, 3.0).unwrap();
        let domain = domain(&original, &extension);
        let p = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let corners = (0..4).flat_map(|i| [p(f64::from(i), 0.0), p(f64::from(i), 3.0)]);
        let columns: Vec<[u32; 4]> = (0..3)
            .map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1])
            .collect();
        let mesh = HexMesh::new(corners.collect(), &columns).unwrap();
        let trimmed = trim(&mesh, &domain, Boundary::Snap).unwrap();
        let topology = trimmed.mesh.topology();
        assert_eq!(
            (topology.n_faces(), topology.boundary_loops().len()),
            (4, 2)
        );
        assert!((measure(&trimmed.mesh).area - 8.75).abs() < 1e-9);
        assert!(
            FlatFace::all(&trimmed.mesh)
                .iter()
                .all(|f| phex_mesh::polygon::is_simple(&f.polygon))
        );
        let parents: Vec<usize> = trimmed.parent.iter().map(|f| f.index()).collect();
        assert_eq!(parents.iter().filter(|f| **f == 1).count(), 2);
    }
}
