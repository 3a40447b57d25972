//! Surfaces with known answers, and the stages in a row at one level of refinement.
#![allow(dead_code)] // Each test file uses some of these.

use nalgebra::Rotation3;
use phex::curvature::{Curvature, curvature};
use phex::directions::{DirectionOptions, Directions, directions};
use phex::layout::Seed;
use phex::layout::{
    CellSurface, Layout, LayoutError, LayoutOptions, Placed, panelling, place_seeds,
};
use phex::smooth_surface::{Affinity, SmoothTarget, smooth_target};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{HexMesh, Topology, TriangleSurface, Vec3, VertexId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, HashSet};

/// A built-in shape with its default parameters as about `triangles` regular triangles.
pub fn shape(name: &str, triangles: usize) -> TriangleSurface {
    shape_with(name, &[], triangles)
}

/// A built-in shape as about `triangles` regular triangles.
pub fn shape_with(name: &str, parameters: &[(&str, f64)], triangles: usize) -> TriangleSurface {
    let options = TriangulationOptions {
        triangles,
        ..Default::default()
    };
    triangulate(&Shape::from_name(name, parameters).unwrap(), &options).unwrap()
}

/// The vertex lists of a surface's triangles.
pub fn triangles(surface: &TriangleSurface) -> Vec<[u32; 3]> {
    surface.triangles().collect()
}

/// The same triangles with every position mapped.
pub fn mapped(surface: &TriangleSurface, map: impl Fn(Vec3) -> Vec3) -> TriangleSurface {
    surface.mapped(|p| map(*p))
}

/// The same surface with diagonal 1, centred.
pub fn normalised(surface: &TriangleSurface) -> TriangleSurface {
    let affinity = Affinity::normalising(surface);
    mapped(surface, |p| affinity.normalise(p))
}

/// A rotation that keeps no axis.
pub fn rotation() -> Rotation3<f64> {
    Rotation3::from_euler_angles(0.7, -0.4, 1.9)
}

/// Every position moved at random by at most `size` along each axis.
pub fn noisy(surface: &TriangleSurface, size: f64) -> TriangleSurface {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut shift = || random.random_range(-size..size);
    let positions = surface.positions().iter();
    let moved = positions.map(|p| p + Vec3::new(shift(), shift(), shift()));
    TriangleSurface::new(moved.collect(), &triangles(surface)).unwrap()
}

/// Two surfaces side by side as one with two components.
pub fn two_components() -> TriangleSurface {
    let one = shape("sphere", 320);
    let n = one.positions().len() as u32;
    let shift = Vec3::new(5.0, 0.0, 0.0);
    let other = one.positions().iter().map(|p| p + shift);
    let positions = one.positions().iter().copied().chain(other).collect();
    let first = triangles(&one);
    let second = first.iter().map(|t| t.map(|v| v + n));
    let all: Vec<[u32; 3]> = first.iter().copied().chain(second).collect();
    TriangleSurface::new(positions, &all).unwrap()
}

/// The square of side 2 with two round holes of a radius.
pub fn punched_plane(radius: f64) -> TriangleSurface {
    let plane = shape("plane", 4000);
    let holes = [Vec3::new(-0.4, -0.3, 0.0), Vec3::new(0.45, 0.35, 0.0)];
    let inside = |v: VertexId| {
        let near = |h: &Vec3| (plane.positions()[v] - h).norm() < radius;
        holes.iter().any(near)
    };
    let topology = plane.topology();
    let kept = topology
        .faces()
        .filter(|&f| !topology.face_vertices(f).iter().any(|&v| inside(v)));
    let lists: Vec<[u32; 3]> = kept.map(|f| plane.triangle(f)).collect();
    without_unused(plane.positions().as_slice(), &lists)
}

/// A slab of unit cubes with two shafts: genus 2.
pub fn genus_two() -> TriangleSurface {
    const SIZE: [i32; 3] = [5, 3, 1];
    let solid = |c: [i32; 3]| {
        let shaft = c[1] == 1 && (c[0] == 1 || c[0] == 3);
        (0..3).all(|k| (0..SIZE[k]).contains(&c[k])) && !shaft
    };
    let mut points: Vec<[i32; 3]> = Vec::new();
    let mut lists = Vec::new();
    for cell in (0..15).map(|i| [i % 5, i / 5, 0]) {
        for (axis, side) in [0, 1, 2].into_iter().flat_map(|a| [(a, 0), (a, 1)]) {
            let mut beyond = cell;
            beyond[axis] += 2 * side - 1;
            if !solid(cell) || solid(beyond) {
                continue;
            }
            let square = outer_square(cell, axis, side).map(|p| number(&mut points, p));
            lists.push([square[0], square[1], square[2]]);
            lists.push([square[0], square[2], square[3]]);
        }
    }
    let positions = points.iter().map(|p| p.map(f64::from).into()).collect();
    TriangleSurface::new(positions, &lists).unwrap()
}

/// Corners of one side of a unit cube, counter-clockwise seen from outside.
fn outer_square(cell: [i32; 3], axis: usize, side: i32) -> [[i32; 3]; 4] {
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |da: i32, db: i32| {
        let mut p = cell;
        p[axis] += side;
        p[a] += da;
        p[b] += db;
        p
    };
    let mut square = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
    if side == 0 {
        square.reverse();
    }
    square
}

fn number(points: &mut Vec<[i32; 3]>, p: [i32; 3]) -> u32 {
    let known = points.iter().position(|q| *q == p);
    known.unwrap_or_else(|| {
        points.push(p);
        points.len() - 1
    }) as u32
}

/// A surface of the vertices that its triangles use.
fn without_unused(positions: &[Vec3], lists: &[[u32; 3]]) -> TriangleSurface {
    let mut index = BTreeMap::new();
    let mut kept = Vec::new();
    let lists: Vec<[u32; 3]> = lists
        .iter()
        .map(|t| {
            t.map(|v| {
                *index.entry(v).or_insert_with(|| {
                    kept.push(positions[v as usize]);
                    kept.len() as u32 - 1
                })
            })
        })
        .collect();
    TriangleSurface::new(kept, &lists).unwrap()
}

/// Euler characteristic and number of boundary loops.
pub fn figures(topology: &Topology) -> (i64, usize) {
    (
        topology.euler_characteristic(),
        topology.boundary_loops().len(),
    )
}

/// Number of faces of each valence.
pub fn valences(mesh: &HexMesh) -> BTreeMap<usize, usize> {
    let topology = mesh.topology();
    let mut count = BTreeMap::new();
    for f in topology.faces() {
        *count.entry(topology.valence(f)).or_default() += 1;
    }
    count
}

/// A surface refined far enough for its panels, with its curvature and directions.
pub struct Stages {
    pub surface: TriangleSurface,
    pub curvature: Curvature,
    pub directions: Directions,
    pub corners: HashSet<VertexId>,
    pub length: f64,
}

impl Stages {
    /// The stages before the layout, all on one surface with 25 vertices a panel; rows do not
    /// follow the boundary.
    pub fn new(surface: &TriangleSurface, panels: usize) -> Self {
        let options = DirectionOptions {
            boundary_alignment: 0.0,
            ..Default::default()
        };
        Self::with(surface, panels, &options)
    }

    pub fn with(surface: &TriangleSurface, panels: usize, options: &DirectionOptions) -> Self {
        let smooth: SmoothTarget =
            smooth_target(&normalised(surface), 25 * panels, &Default::default());
        let surface = smooth.finest().clone();
        let length = panel_length(&surface, panels);
        let curvature = curvature(&surface, length, &Default::default());
        let directions = directions(&surface, &curvature, length, options).unwrap();
        Self {
            surface: surface.with_normals(curvature.normal.clone()),
            curvature,
            directions,
            corners: smooth.corners.into_iter().collect(),
            length,
        }
    }

    pub fn topology(&self) -> &Topology {
        self.surface.topology()
    }

    pub fn seeds(&self) -> Placed {
        place_seeds(
            self.topology(),
            &self.directions,
            &LayoutOptions::default(),
            &phex::Silent,
        )
        .unwrap()
    }

    pub fn panelling(&self, seeds: &[Seed]) -> Result<Layout, LayoutError> {
        let cells = CellSurface {
            surface: &self.surface,
            metric: &self.directions.metric,
            mesh: &self.directions.intrinsic,
            corners: &self.corners,
        };
        panelling(&cells, seeds, &phex::Silent)
    }

    pub fn layout(&self) -> Layout {
        self.panelling(&self.seeds().seeds).unwrap()
    }
}

/// Distance of neighbouring panel centres for a number of panels.
pub fn panel_length(surface: &TriangleSurface, panels: usize) -> f64 {
    (surface.area() / panels as f64 / phex::layout::CELL).sqrt()
}
